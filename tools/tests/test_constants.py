"""The constants that steer the diagnosis: each has a reason and a use, and a changed one is changed wherever it is bound."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.constants import sweep as sweep_program
from benchmarks.constants.changing import scaled
from benchmarks.constants.document import effects_of, written
from benchmarks.constants.listing import Constant, constants, constants_in, unused, without_reason
from benchmarks.constants.replay import Job, outline
from benchmarks.constants.sweep import CASES, Moved, Swept, moved, read_swept, renewed, sources_of, words, write_swept
from benchmarks.frozen import CASES as FROZEN_CASES
from ema_tools.base.errors import InputError
from support import ROOT

SOURCE = '''
"""A module."""
from elsewhere import made

_PLAIN = 3.0
# Above it
# in two lines [chance]
_ABOVE: float = 2.5
_BEHIND = (1, -0.5)  # behind it [precision]
_ONE, _TWO = 1, 2  # both [effort]
_NONE, _TEXT, _ON, _MADE = 0.0, "1", True, made(3.0)
_DERIVED = 4 * _ABOVE  # from another [judgement]
_TABLE = {"a": 1.0, ("b",): 2.0}  # of numbers [physics]


class Thing:
    """A class."""

    share: float = 0.3  # of it [judgement]
    neutral: int = 1
    limits = made(
        first=8,  # how many [effort]
        none=0.0,
        second=_ABOVE * 2.0,
    )
'''
ONE = Constant("fit.here", "_ONE", 3, "2.0", "what it is", "judgement")


@pytest.mark.slow
def test_every_constant_has_a_reason_and_a_use() -> None:
    assert without_reason(constants()) == []
    assert unused() == []


def test_constants_are_found_with_their_reasons() -> None:
    found = {one.name: (one.text, one.reason, one.set_by) for one in constants_in("a.module", SOURCE)}
    assert found == {
        "_PLAIN": ("3.0", "", ""),
        "_ABOVE": ("2.5", "Above it in two lines", "chance"),
        "_BEHIND": ("(1, -0.5)", "behind it", "precision"),
        "_ONE": ("1", "both", "effort"),
        "_TWO": ("2", "both", "effort"),
        "_DERIVED": ("4 * _ABOVE", "from another", "judgement"),
        "_TABLE": ("{'a': 1.0, ('b',): 2.0}", "of numbers", "physics"),
        "Thing.share": ("0.3", "of it", "judgement"),
        "Thing.limits.first": ("8", "how many", "effort"),
        "Thing.limits.second": ("_ABOVE * 2.0", "", ""),
    }
    assert [line.split(": ")[:3] for line in without_reason(tuple(constants_in("a.module", SOURCE)))] == [
        ["a/module.py:5", "_PLAIN", "no comment"],
        ["a/module.py:24", "Thing.limits.second", "no comment"],
    ]


def test_every_number_of_a_value_is_scaled() -> None:
    assert scaled(3.0, 0.5) == 1.5 and scaled(7, 2.0) == 14 and scaled(1, 0.5) == 1 and scaled(True, 2.0) is True
    assert scaled({"a": (1.0, "text", [4])}, 2.0) == {"a": (2.0, "text", [8])}
    assert scaled(np.array([1.0, 2.0]), 0.5).tolist() == [0.5, 1.0]


def in_a_process(text: str) -> dict[str, object]:
    """What a program prints as JSON."""
    ran = subprocess.run([sys.executable, "-c", text], cwd=ROOT, capture_output=True, text=True, check=True)
    found: dict[str, object] = json.loads(ran.stdout)
    return found


@pytest.mark.slow
def test_a_changed_constant_is_changed_wherever_it_is_bound() -> None:
    found = in_a_process("""
import json
from benchmarks.constants.changing import install_change
changed = install_change(["select.strategies.strategy:LEAST_LIMIT"], 2.0)
import ema_tools.select.strategies.strategy as strategy, ema_tools.tasks.add as add
from ema_tools.select.strategies import DataSheetAlone, WithRepeats
print(json.dumps([changed, strategy.LEAST_LIMIT, add.LEAST_LIMIT, WithRepeats.limits.least, DataSheetAlone.limits.least]))
""")
    assert found == [{"select.strategies.strategy:LEAST_LIMIT": True}, 60.0, 60.0, 60.0, 120.0]
    found = in_a_process("""
import json
from benchmarks.constants.changing import install_change
changed = install_change(["select.strategies.with_repeats:WithRepeats.limits.finalists", "fit.evidence:_ROUNDS"], 0.5)
from ema_tools.select.strategies import WithRepeats
import ema_tools.fit.evidence as evidence
print(json.dumps([WithRepeats.limits.finalists, WithRepeats.limits.finalist_share, evidence.settled.__defaults__[1], evidence._ROUNDS]))
""")
    assert found == [2, 0.4, 3, 3]


@pytest.mark.slow
def test_readings_are_noted() -> None:
    found = in_a_process("""
import json
from benchmarks.constants.changing import install_notes
read, imported = install_notes()
import numpy as np
from ema_tools.fit.bounded import FreeValue, OneSided, Stop, fit
import ema_tools.tasks.signature_table, ema_tools.fit.laps
before = sorted(read)
fit([FreeValue("a", 1.0, 1.0, 0.0, 3.0)], lambda values: np.array([values["a"] - 2.0]), OneSided((0.1,)), Stop(5, 1e-9, 1e-9))
print(json.dumps([before, sorted(read), "tasks.signature_table:RATE_HZ" in imported, "fit.laps:SAME" in imported]))
""")
    assert found == [[], ["fit.bounded:_INSIDE"], True, False]


def answer(verdict: str, error: float | None, *accepted: str) -> dict[str, object]:
    """A row of one case."""
    return {"outline": {"verdict": verdict, "first": (*accepted, None)[0], "accepted": list(accepted), "error": error}, "seconds": 1.0}


def swept_rows() -> Swept:
    """A constant read in two of three cases."""
    rows = Swept(sources_of())
    for name, plain in (("a", answer("missing", 1.0, "x")), ("b", answer("adequate", 1.0)), ("c", answer("adequate", 1.0))):
        rows.cases[name] = {**plain, "read": ["fit.here:_ONE"] if name != "c" else [], "imported": []}
    return rows


def test_what_moved_is_counted_in_the_cases_that_read_the_constant() -> None:
    rows = swept_rows()
    assert rows.reached("fit.here:_ONE") == ("a", "b") and rows.reached("fit.here:_OTHER") == ()
    assert rows.reached("fit.here:Thing.limits.first") == ("a", "b", "c")
    assert words(moved(rows, ONE, 2.0)) == "not swept"
    rows.keep(ONE, 2.0, "a", answer("unknown", 1.2, "y"))
    rows.keep(ONE, 2.0, "b", answer("adequate", 1.0))
    assert moved(rows, ONE, 2.0) == Moved(2, 1, 1, 1, 0, pytest.approx(0.2), False)
    assert words(moved(rows, ONE, 2.0)) == "1 verdict, 1 first name, 1 accepted set, error 20 % of 2"
    rows.keep(ONE, 0.5, "a", {"broken": "ValueError: no"})
    assert words(moved(rows, ONE, 0.5)) == "1 broken of 1"
    text = written([ONE, Constant("fit.here", "_OTHER", 4, "1.0", "another", "chance")], rows)
    assert "| `fit.here` `_ONE` | `2.0` | what it is | judgement | 1 broken of 1 | 1 verdict" in text
    assert "| `fit.here` `_OTHER` | `1.0` | another | chance | not reached by these cases | not reached by these cases |" in text


@pytest.mark.slow
def test_rows_are_kept_for_the_same_value_and_the_same_sources(tmp_path: Path) -> None:
    rows = swept_rows()
    rows.keep(ONE, 2.0, "a", answer("missing", 1.0, "x"))
    path = tmp_path / "rows.json"
    write_swept(path, rows)
    again = read_swept(path)
    assert again == rows
    other = Constant(ONE.module, ONE.name, ONE.line, "5.0", ONE.reason, ONE.set_by)
    assert again.answers(ONE, 2.0) and not again.answers(other, 2.0)
    again.sources = "another"
    write_swept(path, again)
    with pytest.raises(InputError, match="measured with other sources than today's: --sweep looks which of its rows still hold"):
        read_swept(path)


@pytest.mark.slow
def test_a_document_keeps_what_an_earlier_one_measured_of_the_same_value() -> None:
    other = replace(ONE, name="_OTHER", text="{'a|b': 3.0}")
    swept, whole = swept_rows(), swept_rows()
    for name in ("a", "b", "c"):
        swept.cases[name]["read"] = whole.cases[name]["read"] = [ONE.key, other.key]
        for factor in (0.5, 2.0):
            swept.keep(ONE, factor, name, answer("adequate", 1.0))
            whole.keep(ONE, factor, name, answer("adequate", 1.0))
            whole.keep(other, factor, name, answer("unknown", 1.0))
    earlier = written([ONE, other], whole)
    said = effects_of(earlier)
    assert said["fit.here", "_OTHER", other.text] == ("3 verdicts, 1 first name, 1 accepted set of 3",) * 2
    assert effects_of(written([ONE, other], swept, earlier)) == said
    # another value was never measured, and without the earlier document nothing is known
    changed = replace(other, text="4.0")
    assert effects_of(written([ONE, changed], swept, earlier)) == effects_of(written([ONE, changed], swept))
    assert effects_of(written([ONE, other], swept)) != said


@pytest.mark.slow
def test_rows_of_other_sources_hold_where_the_plain_answer_is_what_it_was() -> None:
    rows = swept_rows()
    for name in ("a", "b"):
        rows.keep(ONE, 2.0, name, answer("unknown", 2.0))
    rows.sources = "another"
    today = {name: dict(one) for name, one in rows.cases.items()}
    today["a"] = {**today["a"], **answer("missing", 1.01, "x")}
    found = renewed(rows, today)
    assert found.sources == sources_of() and list(found.answers(ONE, 2.0)) == ["b"]
    assert (rows.count, found.count) == (2, 1)


@pytest.mark.slow
def test_a_group_is_halved_until_it_is_known_which_constant_moved_the_answer(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of six constants the fourth turns the verdict of one case, and the sixth ends the program in another; of the others nothing moves."""
    chosen = [Constant("fit.here", f"_{place}", place, "2.0", "what it is", "judgement") for place in range(6)]
    plain = {name: {**answer("adequate", 1.0), "read": [one.key for one in chosen], "imported": []} for name in ("a", "b")}
    path = tmp_path / "rows.json"
    write_swept(path, Swept(sources_of(), plain))
    runs = []

    def run(job: Job, _seconds: object, keep: Callable[[dict[str, object]], None], _ended: object) -> None:
        runs.append((len(job.keys), len(job.folders)))
        for case in job.folders:
            moved_it = case == "a" and "fit.here:_3" in job.keys
            row = {"broken": "ended"} if case == "b" and "fit.here:_5" in job.keys else answer("missing" if moved_it else "adequate", 1.0)
            keep({"case": case, **row, "unchanged": ["fit.here:_0"] if "fit.here:_0" in job.keys else []})

    monkeypatch.setattr(sweep_program, "run", run)
    monkeypatch.setattr(sweep_program, "recorded", lambda names, records, told: {name: str(records) for name in names})
    told: list[str] = []
    found = sweep_program.sweep(chosen, ("a", "b"), path, tmp_path, 1, told.append)
    for factor in (0.5, 2.0):
        texts = [words(moved(found, one, factor)) for one in chosen]
        assert texts == ["stays what it is", "nothing of 2", "nothing of 2", "1 verdict of 2", "nothing of 2", "1 broken of 2"]
    assert found.rows["fit.here:_1"]["2.0"]["b"]["together"] == 3 and found.rows["fit.here:_3"]["2.0"]["a"]["together"] == 1
    assert runs[0] == (6, 2) and len(runs) == 14
    assert sorted({line.partition(" ")[0] for line in told}) == [one.key for one in chosen]
    runs.clear()
    sweep_program.sweep(chosen, ("a", "b"), path, tmp_path, 1, told.append)
    assert not runs


def test_an_answer_is_told_by_its_verdict_its_first_name_and_what_is_accepted() -> None:
    listed = [{"name": "x", "accepted": False, "score": 9.0}, {"name": "y", "accepted": True, "score": 5.0}]
    full = {"verdict": "missing", "effects": listed, "faults": {"csj": {"accepted": True, "score": 7.0}}, "error": {"after": 1.5}}
    assert outline(full) == {"verdict": "missing", "first": "csj", "accepted": ["csj", "y"], "error": 1.5}
    assert outline({"error_line": "no"}) == {"verdict": "refused", "first": "no", "accepted": [], "error": None}


def test_the_usual_cases_exist() -> None:
    assert set(CASES) <= {case.name for case in FROZEN_CASES}
