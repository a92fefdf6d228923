"""What the terminal says last: what to do next, with a command that runs as it stands; and that tables keep to eighty columns without cutting a name."""

from __future__ import annotations

import io
import json
import shlex
from dataclasses import replace
from pathlib import Path

import pytest
from rich.console import Console

from ema_tools.data.actuator import reference_actuator
from ema_tools.design.typical import typical_change
from ema_tools.library.faults import FAULTS
from ema_tools.results.codec import to_json
from ema_tools.results.diagnosis import DiagnosisResult
from ema_tools.results.identification import BaselineEntry, Guard, IdentificationResult
from ema_tools.results.parts import ErrorsEntry, WeightedErrors
from ema_tools.results.reading import result_of
from ema_tools.results.validity import Remark, Validity
from ema_tools.select.outcome import Diagnosis, Named
from ema_tools.words.advice import advice_of, with_next
from ema_tools.words.sentences.sizes import ends_text
from ema_tools.words.terminal import show
from ema_tools.words.terminal.next_step import say_next
from report_results import JUDGED, judged
from support import RECORDINGS, REFERENCE, run_ema

TODAY = RECORDINGS / "story" / "today.csv"


def printed(width: int = 200) -> Console:
    return Console(file=io.StringIO(), width=width, highlight=False)


def text_of(console: Console) -> str:
    assert isinstance(console.file, io.StringIO)
    return console.file.getvalue()


def last_line(out: str) -> str:
    """The `Next:` of an answer, which is its last line but for files that were written."""
    lines = [line for line in out.strip().splitlines() if not line.endswith(" written")]
    return lines[-1]


def test_a_comparison_ends_with_a_command_that_runs(tmp_path: Path) -> None:
    ran = run_ema("compare", REFERENCE, TODAY)
    assert ran.code == 0 and last_line(ran.out).startswith("Next: ask what is missing: ema diagnose ")
    command = shlex.split(last_line(ran.out).rpartition(": ")[2])
    assert command[2:4] == [str(REFERENCE), str(TODAY)] and all(Path(path).is_file() for path in command[2:4])


def test_an_identification_that_was_not_kept_ends_with_keeping_it(tmp_path: Path) -> None:
    ran = run_ema("identify", REFERENCE, RECORDINGS / "case_b.csv", "--no-guard")
    assert last_line(ran.out).startswith("Next: hold it against all signals: ema identify ")
    again = run_ema(
        "identify", REFERENCE, RECORDINGS / "case_b.csv", "--no-guard", "--json", tmp_path / "b.json", "--report", tmp_path / "b.html"
    )
    # the page says the same
    said = json.loads((tmp_path / "b.json").read_text(encoding="utf-8"))
    assert last_line(again.out).rpartition(": ")[2] in (tmp_path / "b.html").read_text(encoding="utf-8").replace("<span>", "").replace(
        "</span>", ""
    )
    assert said["verdict"] == "fault"


def adequate(after: float) -> DiagnosisResult:
    """A diagnosis that names nothing and leaves so much, at a noise level of 0.8."""
    command = {"command": "ema diagnose mine.toml today.csv --healthy a.csv b.csv"}
    return DiagnosisResult(verdict="adequate", error=WeightedErrors(40.0, after, 0.8), gate=Validity(), provenance=command)


def healthy(*without: str) -> IdentificationResult:
    """A healthy verdict of a model with effects that its healthy records are `without`."""
    return IdentificationResult(
        verdict="healthy",
        objective_before_mm2s=1.0,
        objective_after_mm2s=0.1,
        evaluations=50,
        adequate=True,
        guard=Guard("adequate", skipped=None, wall_s=1.0),
        baseline=BaselineEntry({}, {}, 5, {}, without),
        error=ErrorsEntry(None, 0.8, 0.8),
        provenance={"command": "ema identify mine.toml today.csv"},
    )


def test_a_model_that_leaves_much_is_not_read_again() -> None:
    assert advice_of(adequate(0.81)).arguments[:2] == ("ema", "identify")
    told = with_next(adequate(2.3))
    assert told.next == () and told.next_experiment.startswith("Next: look at the pictures: something that is in no effect of the library")


def test_a_voltage_that_was_left_out_is_decided_on_before_anything_is_added() -> None:
    remark = Remark("asked voltage", "weakens", "the recorded voltage contradicts what the other signals agree on")
    told = with_next(replace(adequate(0.8), verdict="missing", gate=Validity(remarks=(remark,))))
    assert told.next == () and "call its column terminal_voltage_V" in told.next_experiment


def test_what_is_new_since_the_healthy_records_is_looked_for() -> None:
    assert advice_of(healthy()).short == "Nothing; follow it"
    assert advice_of(healthy("jam_spot")).short == "Find the cause of jam spot, and follow it"


def test_an_advised_file_is_none_that_is_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert advice_of(healthy()).arguments[-1] == "today.json"
    (tmp_path / "today.json").touch()
    assert advice_of(healthy()).arguments[-1] == "today_2.json"


def test_a_missing_effect_is_added_to_a_file_that_can_be_written() -> None:
    found = result_of(judged(JUDGED[2]), "x")
    assert isinstance(found, IdentificationResult)
    console = printed()
    say_next(console, found)
    command = "ema add mine.toml stribeck_friction --fit today.csv --known -o with_stribeck_friction.toml"
    assert text_of(console).rstrip() == f"Next: put it into the model: {command}"
    assert with_next(found).next == (tuple(command.split()),)
    other = result_of({**to_json(found), "reasons": ["Stribeck friction (stribeck_friction; rise 0.30) is missing from the model"]}, "x")
    assert isinstance(other, IdentificationResult)
    console = printed()
    say_next(console, other)
    assert text_of(console).startswith("Next: record today's machine again: ema identify mine.toml NEXT.csv")
    assert with_next(other).next == ()


@pytest.mark.parametrize("alike", [(), ("spring_load", "constant_load")])
def test_candidates_keep_to_eighty_columns_with_their_names_whole(alike: tuple[str, ...]) -> None:
    size = {"effects.concave_viscous.drag_Nm_per_sqrt_rad_s": -0.0073}
    named = tuple(
        Named(name, (name, *alike), values, dict.fromkeys(values, 0.3), score, 30.0, False)
        for name, values, score in (
            ("directional_stribeck", {}, 1.1e6),
            ("load_dependent_stribeck", {}, 9e5),
            ("concave_viscous", size, 8e5),
        )
    )
    console = printed(80)
    show._candidates(console, Diagnosis("missing", None, named, (), (), 1.0, 1.0, 1.0, 0.0, 30.0))
    lines = text_of(console).splitlines()
    assert max(map(len, lines)) <= 80 and ("looks like" in lines[1]) is bool(alike)
    if not alike:
        assert all(any(line.startswith(f"{one.name} ") for line in lines) for one in named)
    assert "…" not in text_of(console)


@pytest.mark.parametrize(
    ("low", "high", "expected"),
    [
        (-131.2, 409.8, "-130 .. 410"),
        (0.29561, 0.30312, "0.2956 .. 0.3031"),
        (-4000.0, 123456.0, "0 .. 120000"),
        (1e6, 9e6, "1e+06 .. 9e+06"),
    ],
)
def test_an_interval_has_no_powers_of_ten_where_none_are_needed(low: float, high: float, expected: str) -> None:
    assert ends_text(low, high) == expected


@pytest.mark.parametrize("fault", FAULTS)
def test_a_typical_fault_is_larger_than_the_healthy_value(fault: str) -> None:
    healthy = reference_actuator()
    assert [value > healthy[name] for name, value in (typical_change(healthy, fault, 1.0) or {}).items()] == [True]
