"""The demo: cases A, B and C from the shipped recordings to the page, by the onboard module. What `ema demo` does."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.text import Text

from ema_tools import console as terminal
from ema_tools.actuator import Actuator, reference_actuator
from ema_tools.cases import CASES, Case
from ema_tools.definitions import library_folder
from ema_tools.errors import InputError
from ema_tools.files import write_json
from ema_tools.identify import identify
from ema_tools.native import Progress
from ema_tools.records import read_record, simulated
from ema_tools.report import write_report
from ema_tools.report.page import finding, sentence
from ema_tools.report.results import FAULTS, Identified, parse_result
from ema_tools.report.words import shift, signed
from ema_tools.results import curves, provenance

COMMAND = "ema demo"
_BITS = 32


@dataclass(frozen=True)
class Shipped:
    """One recording of the demo: the case that it holds and the sensor noise in it."""

    file: str
    case: Case
    noise: str = ""


RECORDINGS = (*(Shipped(f"case_{case.letter.lower()}.csv", case) for case in CASES), Shipped("case_a_noisy.csv", CASES[0], "5 µm sensor noise"))


def recordings_folder() -> Path:
    """Folder of the shipped recordings, in the project around this file."""
    return Path(__file__).resolve().parents[2] / "recordings"


def output_folder() -> Path:
    """Where the demo leaves its results: beside the libraries, in the build folder."""
    return library_folder().parent / "demo"


def written(folder: Path) -> list[Path]:
    """What the demo writes to `folder`: a result per recording, then the page."""
    return [*(folder / f"{Path(shipped.file).stem}.json" for shipped in RECORDINGS), folder / "report.html"]


def run(output: Console, folder: Path) -> Path:
    """Identify on every shipped recording, write the results and the page to `folder`, print what was found.

    Returns the page. Files of an earlier demo are overwritten. Raises InputError when a recording is absent.
    """
    actuator = reference_actuator()
    budget = actuator["search.evaluation_budget"]
    results: list[Identified] = []
    *files, page = written(folder)
    with terminal.progress("identifying", budget * len(RECORDINGS)) as bar:
        for place, shipped in enumerate(RECORDINGS):
            data = _identified(actuator, shipped, partial(_tell, bar, place * budget))
            write_json(files[place], data, force=True)
            results.append(_parsed(data, files[place]))
    write_report(files, page, COMMAND, force=True)
    _print(output, results, page)
    return page


def _tell(bar: terminal.Bar, before: float, run_number: int, _cost: float, best: float) -> None:
    """Progress after a model run; `before` runs belong to earlier recordings."""
    bar.update(before + run_number, f"best {best:.2g} mm2 s")


def _identified(actuator: Actuator, shipped: Shipped, progress: Progress) -> dict[str, Any]:
    """The result of one recording, with the curves for the page."""
    path = recordings_folder() / shipped.file
    if not path.is_file():
        raise InputError(f"{shipped.file}: not in {_shown(path.parent)}: run the demo from a checkout of the project, which holds the recordings")
    record = read_record(path, actuator)
    found = identify(actuator, record, bits=_BITS, progress=progress)
    return {
        "command": "demo",
        "name": shipped.file,
        "case": shipped.case.letter,
        "noise": shipped.noise,
        **found.result(),
        "curves": curves(record, {"before": simulated(found.healthy, record), "after": simulated(found.actuator, record)}),
        "provenance": provenance(COMMAND, actuator=actuator.name, seed=found.seed, precision=f"float{_BITS}, as onboard", record=f"recordings/{shipped.file}"),
    }


def _parsed(data: dict[str, Any], path: Path) -> Identified:
    result = parse_result(data, str(path), path.stem)
    assert isinstance(result, Identified)
    return result


def _shown(path: Path) -> str:
    """The path as the reader would type it: short where it lies below the current folder."""
    here = Path.cwd()
    return str(path.relative_to(here)) if path.is_relative_to(here) else str(path)


def _print(output: Console, results: list[Identified], page: Path) -> None:
    first = results[0]
    output.print(Text(f"{sentence(first)} {finding(first)}"))
    output.print()
    table = terminal.table(
        "Found by the onboard module, beside the paper (shifts and errors in % of the healthy value)",
        "case", "fault", "true", "found", "error", "paper's", "runs", "paper's", "time", "paper's",
        text_columns=2,
    )  # fmt: skip
    for result in results:
        table.add_row(*_row(result, 0))
        table.add_row(*_row(result, 1))
    output.print(table)
    output.print()
    output.print(Text(f"The page with the curves: {_shown(page)}"))


def _row(result: Identified, place: int) -> list[str]:
    """One fault of one result; what belongs to the whole case stands in its first row."""
    name, label = FAULTS[place], ("CSJ", "BLK")[place]
    case, paper = result.case, result.paper
    assert case is not None and result.wall_s is not None
    true, found = case.shift_percent(name), result.faults[name].shift_percent
    cells = [result.label if place == 0 else "", label, shift(true), shift(found), signed(found - true), signed(paper.paper_shift_percent(name) - true) if paper else "-"]
    if place == 0:
        cells += [str(result.evaluations), str(paper.paper_iterations) if paper else "-", f"{result.wall_s:.2f} s", f"{paper.paper_wall_s:.0f} s" if paper else "-"]
    return cells
