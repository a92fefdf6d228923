"""The demo: from a record that its model does not explain to the missing effect and the right faults; from healthy runs to a unit's own model, by which the flight code answers; then the
paper's cases. What `ema demo` does.

Every step prints the command that does the same by hand; docs/WALK_THROUGH.md goes the same way at leisure.
"""

from __future__ import annotations

import shlex
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from rich.console import Console
from rich.text import Text

from ema_tools.base.errors import InputError
from ema_tools.base.files import write_json, write_text
from ema_tools.compare.comparison import compare
from ema_tools.data import own_unit, story
from ema_tools.data.actuator import Actuator, read_actuator, reference_actuator
from ema_tools.data.cases import CASES, PaperCase
from ema_tools.data.records import Record, read_record, simulated
from ema_tools.library.definitions import is_installed, library_folder, shipped_folder
from ema_tools.library.faults import FAULTS as CHANGEABLE
from ema_tools.plant.native import Progress, SearchSettings
from ema_tools.results.codec import to_json
from ema_tools.results.identification import IdentificationResult
from ema_tools.results.parts import Provenance
from ema_tools.results.provenance import curves, provenance
from ema_tools.results.reading import Result
from ema_tools.tasks.add import add
from ema_tools.tasks.baseline_records import with_state
from ema_tools.tasks.calibrate import calibrate
from ema_tools.tasks.diagnose import answer
from ema_tools.tasks.export import header_text
from ema_tools.tasks.identify import identify
from ema_tools.tasks.model_error import model_error
from ema_tools.tasks.objective_shape import shape_of
from ema_tools.tasks.own_machine import of_own_machine, own_machine
from ema_tools.tasks.workbench import bench
from ema_tools.words.advice import with_next
from ema_tools.words.answers.addition import addition
from ema_tools.words.answers.calibration import calibration
from ema_tools.words.answers.comparison import comparison
from ema_tools.words.answers.diagnosis import diagnosis
from ema_tools.words.answers.identification import identification
from ema_tools.words.page import write_report
from ema_tools.words.page.results import FAULTS, ShownIdentification, identified
from ema_tools.words.page.text import shift, signed
from ema_tools.words.sentences.identification import TITLES
from ema_tools.words.sentences.paths import with_paths
from ema_tools.words.terminal import console as terminal
from ema_tools.words.terminal import show

COMMAND = "ema demo"
_BITS = 32
# Both encoders: play is what lies between them.
_WEIGHTS = "position_mm=1,motor_position_mm=1"
_WEIGHT = (1.0, 1.0, 0.0, 0.0)
# What the story leaves for the page, in its order there, and what it leaves beside it.
_ON_PAGE = ("diagnose.json", "add.json", "identify_before.json", "identify_after.json")
_COMPARED = "compare.json"
_MACHINE = "machine.toml"
# The same of the unit that the flight code judges.
_CALIBRATED = "calibrate.json"
_OWN_MODEL = "unit.toml"
_HEADER = "ema_actuator_data.h"
_FLOWN = tuple(f"identify_{day.name}.json" for day in own_unit.LATER)


@dataclass(frozen=True)
class Shipped:
    """One recording of the paper's cases: the case that it holds and the sensor noise in it."""

    file: str
    case: PaperCase
    noise: str = ""


RECORDINGS = (
    *(Shipped(f"case_{case.letter.lower()}.csv", case) for case in CASES),
    Shipped("case_a_noisy.csv", CASES[0], "5 µm sensor noise"),
)


@dataclass(frozen=True)
class _Unit:
    """The story's machine as its owner has it: the data sheet, the records, and how to type them."""

    sheet: Actuator
    today: Record
    healthy: tuple[Record, ...]
    held_out: Record
    sheet_file: str
    today_file: str
    others: str
    others_quoted: str  # the same without what a shell expands


def recordings_folder() -> Path:
    """Folder of the shipped recordings."""
    return shipped_folder() / "recordings"


def output_folder() -> Path:
    """Where the demo leaves its results: beside the libraries in the build folder, from an installed package below the current folder."""
    return Path("ema_demo") if is_installed() else library_folder().parent / "demo"


def written(folder: Path) -> list[Path]:
    """What the demo writes to `folder`: the results in the order of the page, what the story leaves besides, then the page."""
    beside = (_COMPARED, _MACHINE, _CALIBRATED, _OWN_MODEL, _HEADER)
    return [*_results(folder), *(folder / name for name in beside), folder / "report.html"]


def _results(folder: Path) -> list[Path]:
    return [folder / name for name in (*_ON_PAGE, *_FLOWN, *(f"{Path(shipped.file).stem}.json" for shipped in RECORDINGS))]


def run(output: Console, folder: Path) -> Path:
    """Go through the story, the unit that the flight code judges and the paper's cases, print what is found, write the results and the page to `folder`.

    Returns the page. Files of an earlier demo are overwritten. Raises InputError when a recording is absent.
    """
    unit = _unit()
    healthy, later = _own_unit(unit.sheet)
    cases = shipped_cases()
    _tell_story(output, folder, unit)
    output.print()
    _tell_flight(output, folder, unit, healthy, later)
    output.print()
    tell_cases(output, folder, cases)
    page = folder / "report.html"
    write_report(_results(folder), page, COMMAND, force=True)
    output.print(Text(f"The page with all of this and the curves: {_shown(page)}"))
    return page


def shipped_cases(noisy: bool = True) -> list[tuple[Shipped, Path]]:
    """The recordings of the paper's cases, with where they lie. Raises InputError when one is absent."""
    return [(shipped, _recording(shipped.file)) for shipped in RECORDINGS if noisy or not shipped.noise]


def _recording(name: str) -> Path:
    path = recordings_folder() / name
    if not path.is_file():
        raise InputError(f"{name}: not in {_shown(path.parent)}: run the demo from a checkout of the project, which holds the recordings")
    return path


def _unit() -> _Unit:
    sheet_file = recordings_folder().parent / "actuators" / "reference.toml"
    names = [story.TODAY, *(story.healthy_name(run) for run in range(1, story.HEALTHY_RUNS + 1)), story.HELD_OUT]
    paths = [_recording(f"story/{name}.csv") for name in names]
    sheet = read_actuator(sheet_file)
    today, *healthy, held_out = (read_record(path, sheet) for path in paths)
    folder = _shown(paths[0].parent)
    others = f"--healthy={folder}/healthy_{{1..{story.HEALTHY_RUNS}}}.csv --holdout {folder}/{story.HELD_OUT}.csv"
    quoted = shlex.join(["--healthy", f"{folder}/healthy_*.csv", "--holdout", f"{folder}/{story.HELD_OUT}.csv"])
    return _Unit(sheet, today, tuple(healthy), held_out, _shown(sheet_file), _shown(paths[0]), others, quoted)


def _tell_story(output: Console, folder: Path, unit: _Unit) -> None:
    """Compare, identify, diagnose, add, identify again."""
    _say(
        output,
        f"A unit of the reference actuator was recorded {story.HEALTHY_RUNS} times when it was healthy, and again today. Does its model still hold, and what has changed?",
    )

    _command(output, 1, f"ema compare {unit.sheet_file} {unit.today_file}")
    with terminal.progress("comparing", 3) as bar:
        measured = compare(unit.sheet, unit.today, report=bar.update)
    compared = comparison(
        measured,
        _origin(unit, f"ema compare {unit.sheet_file} {unit.today_file}"),
        curves(unit.today, model=measured.simulation),
        model_error(unit.sheet, unit.today),
    )
    _write(folder / _COMPARED, compared)
    rod, current = (compared.channels[name].relative_percent for name in ("position_mm", "current_A"))
    _say(output, f"The rod is off by {terminal.number(rod, 2)} %, the current by {terminal.number(current, 2)} %. {compared.sentence}")

    _command(output, 2, f"ema identify {unit.sheet_file} {unit.today_file} --weight {_WEIGHTS}")
    before = _searched(unit, unit.sheet, unit.sheet_file, "the data sheet's model")
    _write(folder / _ON_PAGE[2], before)
    _say(output, f"{_verdict(before)}, because")
    for reason in before.reasons:
        _say(output, f"- {reason}")

    _command(output, 3, f"ema diagnose {unit.sheet_file} {unit.today_file} {unit.others}")
    with terminal.progress("diagnosing", 100) as bar:
        found = answer(unit.sheet, unit.today, unit.healthy, unit.held_out, lambda share, text: bar.update(100.0 * share, text))
    drawn = curves(unit.today, before=simulated(found.evidence.actuator, unit.today), after=simulated(found.on_its_day, unit.today))
    asked = f"ema diagnose {unit.sheet_file} {unit.today_file} {unit.others_quoted}"
    missing = replace(diagnosis(found, _origin(unit, asked), drawn), workbench=bench(found.evidence.actuator, unit.today, found.evidence))
    missing = with_next(missing)
    _write(folder / _ON_PAGE[0], missing)
    _say(output, missing.where.sentence)
    _say(output, missing.sentence)
    if not found.effects:
        return

    effect = found.effects[0].name
    _command(output, 4, f"ema add {unit.sheet_file} {effect} --fit {unit.today_file} {unit.others} -o {_shown(folder / _MACHINE)}")
    with terminal.progress("adding", 100) as bar:
        added = add(unit.sheet, effect, unit.today, unit.healthy, unit.held_out, lambda share, text: bar.update(100.0 * share, text))
    machine = with_state(added.machine, unit.sheet, unit.healthy, added.healthy, (effect,), unit.today, added.fitted, "add")
    added = added.with_last_error(model_error(machine, unit.today, unit.healthy).fitted)
    machine.write(folder / _MACHINE, True)
    drawn = curves(unit.today, before=simulated(added.fit.view.evidence.actuator, unit.today), after=simulated(added.fitted, unit.today))
    asked = f"ema add {unit.sheet_file} {effect} --fit {unit.today_file} {unit.others_quoted} -o {_shown(folder / _MACHINE)}"
    model = addition(added, unit.today.file, _shown(folder / _MACHINE), _origin(unit, asked), drawn)
    seen = added.fit.view.evidence
    model = replace(model, workbench=bench(seen.actuator, unit.today, seen))
    _write(folder / _ON_PAGE[1], model)
    show.steps(output, model.steps or (), model.error.floor)
    beside = " and ".join(TITLES[value] for name, value in CHANGEABLE.items() if name in added.fit.effects)
    _say(
        output,
        f"{effect} is fitted{f' beside {beside}, which may have changed with it' if beside else ''}; nothing is fitted to the record held out.",
    )

    _command(output, 5, f"ema identify {_shown(folder / _MACHINE)} {unit.today_file}")
    after = _searched(unit, machine, _shown(folder / _MACHINE), f"with {effect}")
    _write(folder / _ON_PAGE[3], after)
    _say(output, f"{_verdict(after)}; the model is {'adequate' if after.adequate else 'not adequate'}.")
    true = ", ".join(f"{name.split('.')[1]} {value:g}" for name, value in story.EFFECT_VALUES.items())
    _say(
        output,
        f"The record was made with CSJ {shift(story.CSJ_SHIFT_PERCENT)}, BLK {shift(story.BLK_SHIFT_PERCENT)} and {story.EFFECT} {true},"
        f" by an independent model; dry friction scatters by {100.0 * story.SCATTER['screw.csj_Nm']:g} % from run to run.",
    )


def _own_unit(sheet: Actuator) -> tuple[tuple[Record, ...], tuple[Record, ...]]:
    """Records of the unit with standing errors: the healthy runs, and those of later days."""
    healthy = [own_unit.healthy_day(run).name for run in range(1, own_unit.HEALTHY_RUNS + 1)]
    found = [read_record(_recording(f"unit/{name}.csv"), sheet) for name in (*healthy, *(day.name for day in own_unit.LATER))]
    return tuple(found[: len(healthy)]), tuple(found[len(healthy) :])


def _tell_flight(output: Console, folder: Path, unit: _Unit, healthy: tuple[Record, ...], later: tuple[Record, ...]) -> None:
    """Healthy runs, the unit's own model, its header, and what the flight code answers by it."""
    _say(
        output,
        f"Another unit was recorded {len(healthy)} times when it was healthy, and on {len(later)} days since. Its contact yields, its screw ripples, its sensors err, and no data sheet"
        " says so. What does the flight code say of it, which sees the rod alone?",
    )
    records = _shown(recordings_folder() / "unit")
    own_model, header = (_shown(folder / name) for name in (_OWN_MODEL, _HEADER))

    _command(output, 6, f"ema calibrate {unit.sheet_file} {records}/healthy_*.csv -o {own_model}")
    with terminal.progress("calibrating", 3) as bar:
        base = calibrate(unit.sheet, healthy, report=bar.update)
        own = own_machine(base.actuator, healthy, lambda _, text: bar.update(3, text))
    assert own is not None  # the healthy runs are of one command
    known = of_own_machine(base, own, healthy)
    known.actuator.write(folder / _OWN_MODEL, True)
    found = calibration(known, _OWN_MODEL, provenance(COMMAND, actuator=unit.sheet.name), own)
    _write(folder / _CALIBRATED, found)
    assert found.own_machine is not None
    show.own_machine(output, found.own_machine)

    _command(output, 7, f"ema export {own_model} -o {header}")
    write_text(folder / _HEADER, header_text(known.actuator), force=True)
    _say(output, f"{header} written: what the firmware compiles in")

    for place, (record, file) in enumerate(zip(later, _FLOWN, strict=True), 8):
        _command(output, place, f"ema identify {own_model} {records}/{record.file} --no-guard")
        with terminal.progress("identifying", known.actuator["search.evaluation_budget"]) as bar:
            flown = identify(known.actuator, record, bits=_BITS, progress=partial(_tell, bar, 0.0), guarding=False)
        drawn = curves(record, before=simulated(flown.healthy, record), after=simulated(flown.actuator, record))
        asked = f"ema identify {own_model} {records}/{record.file} --no-guard"
        origin = provenance(asked, actuator=known.actuator.name, record=f"recordings/unit/{record.file}")
        said = _with_paths(
            identification(flown, f"{record.file}, the unit's own model", origin, drawn), own_model, f"{records}/{record.file}"
        )
        _write(folder / file, said)
        _say(output, f"{_verdict(said)}{', because' if said.reasons else '.'}")
        for reason in said.reasons:
            _say(output, f"- {reason}")
    true = ", ".join(f"{name.split('.')[1]} {value:g}" for name, value in own_unit.EFFECT_VALUES.items())
    _say(
        output,
        f"The unit was sound and {own_unit.SOUND.warmer_degC:g} degC warmer; worn by CSJ {shift(own_unit.CSJ_SHIFT_PERCENT)}, BLK {shift(own_unit.BLK_SHIFT_PERCENT)} and"
        f" {-own_unit.WORN.warmer_degC:g} degC colder; and sound with {own_unit.EFFECT} {true}. The same answers come from the example firmware on its target: docs/FIRMWARE.md.",
    )


def _say(output: Console, text: str) -> None:
    output.print(Text(text))


def _command(output: Console, place: int, line: str) -> None:
    output.print()
    output.print(Text(f"{place}  {line}", style="bold"))


def _searched(unit: _Unit, actuator: Actuator, file: str, model: str) -> IdentificationResult:
    """Today's record by the data sheet's model with the weights of both encoders, or by a machine file with its baseline records."""
    healthy = unit.healthy if actuator.baseline is not None else ()
    search = None if healthy else SearchSettings(weight=_WEIGHT)
    with terminal.progress("identifying", actuator["search.evaluation_budget"]) as bar:
        found = identify(actuator, unit.today, healthy, search, bits=_BITS, progress=partial(_tell, bar, 0.0))
    drawn = curves(unit.today, before=simulated(found.healthy, unit.today), after=simulated(found.actuator, unit.today))
    said = identification(
        found,
        f"{unit.today.file}, {model}",
        _origin(unit, f"ema identify {file} {unit.today_file}{'' if healthy else f' --weight {_WEIGHTS}'}"),
        drawn,
        shape_of(found),
    )
    return _with_paths(said, file, unit.today_file)


def _with_paths(found: IdentificationResult, actuator: str, record: str) -> IdentificationResult:
    """The commands in its words as they are typed for this record."""
    reasons = tuple(with_paths(reason, actuator, [record]) for reason in found.reasons)
    return replace(found, sentence=with_paths(found.sentence, actuator, [record]), reasons=reasons)


def _verdict(found: IdentificationResult) -> str:
    """Verdict and shifts in a few words."""
    shifts = ", ".join(f"{show.FAULTS[name]} {shift(estimate.shift_percent)}" for name, estimate in found.estimates.items())
    return f"{found.verdict.capitalize()}: {'the search reads ' if found.verdict == 'undecided' else ''}{shifts}"


def _origin(unit: _Unit, command: str) -> Provenance:
    """What made a result; `command` does the same by hand, and what follows it has its paths."""
    return provenance(command, actuator=unit.sheet.name, record=f"recordings/story/{unit.today.file}")


def _write(path: Path, result: Result) -> None:
    """The file that the command's --json would be."""
    write_json(path, to_json(result), force=True)


def tell_cases(output: Console, folder: Path, cases: list[tuple[Shipped, Path]]) -> list[ShownIdentification]:
    """The paper's cases, for which the model holds all there is: searched, written to `folder`, printed."""
    actuator = reference_actuator()
    budget = actuator["search.evaluation_budget"]
    results: list[ShownIdentification] = []
    with terminal.progress("identifying", budget * len(cases)) as bar:
        for place, (shipped, path) in enumerate(cases):
            found = _identified(actuator, shipped, path, partial(_tell, bar, place * budget))
            _write(folder / f"{path.stem}.json", found)
            results.append(identified(found, str(path), path.stem))
    _print_cases(output, results)
    output.print()
    return results


def _tell(bar: terminal.Bar, before: float, run_number: int, _cost: float, best: float, _tried: tuple[float, ...]) -> None:
    """Progress after a model run; `before` runs belong to earlier recordings."""
    bar.update(before + run_number, f"best {best:.2g} mm2 s")


def _identified(actuator: Actuator, shipped: Shipped, path: Path, progress: Progress) -> IdentificationResult:
    """The result of one recording, with the curves for the page."""
    record = read_record(path, actuator)
    found = identify(actuator, record, bits=_BITS, progress=progress)
    origin = provenance(
        f"ema identify reference {_shown(path)} --no-guard",
        actuator=actuator.name,
        seed=found.seed,
        precision=f"float{_BITS}, as onboard",
        record=f"recordings/{shipped.file}",
    )
    drawn = curves(record, before=simulated(found.healthy, record), after=simulated(found.actuator, record))
    return identification(
        found, shipped.file, origin, drawn, shape_of(found), command="demo", case=shipped.case.letter, noise=shipped.noise
    )


def _shown(path: Path) -> str:
    """The path as the reader would type it: short where it lies below the current folder."""
    here = Path.cwd()
    return str(path.relative_to(here)) if path.is_relative_to(here) else str(path)


def _print_cases(output: Console, results: list[ShownIdentification]) -> None:
    table = terminal.table(
        "The paper's cases, where nothing is missing: found by the onboard module, beside the paper (shifts and errors in % of the healthy value)",
        "case", "fault", "true", "found", "error", "paper's", "runs", "paper's", "time", "paper's",
        text_columns=2,
    )  # fmt: skip
    for result in results:
        table.add_row(*_row(result, 0))
        table.add_row(*_row(result, 1))
    output.print(table)


def _row(result: ShownIdentification, place: int) -> list[str]:
    """One fault of one result; what belongs to the whole case stands in its first row."""
    name, label = FAULTS[place], ("CSJ", "BLK")[place]
    case, paper = result.case, result.paper
    assert case is not None and result.wall_s is not None
    true, found = case.shift_percent(name), result.faults[name].shift_percent
    cells = [
        result.label if place == 0 else "",
        label,
        shift(true),
        shift(found),
        signed(found - true),
        signed(paper.paper_shift_percent(name) - true) if paper else "-",
    ]
    if place == 0:
        cells += [
            str(result.evaluations),
            str(paper.paper_iterations) if paper else "-",
            f"{result.wall_s:.2f} s",
            f"{paper.paper_wall_s:.0f} s" if paper else "-",
        ]
    return cells
