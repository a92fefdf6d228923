"""The benchmark of what has happened since a machine was healthy: what it counts, and that days differ by what it says; some of its machines, asked as a user would."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from benchmarks.machines.plants import EFFECTS, Machine, records_of_day
from benchmarks.since_healthy.document import right, written, wrong
from benchmarks.since_healthy.trials import CHANGES, HEALTHY_DAYS, NOTHING, TODAY, DayTrial, perform, plan

CSJ, VISCOUS, SHARE = "screw.csj_Nm", "screw.viscous_Nm_s_per_rad", "screw.dynamic_ratio"


def _row(since: str, verdict: str = "adequate", accepted: str = "", changed: tuple[str, ...] = (), as_well: str = "") -> dict[str, Any]:
    return {
        "since": since,
        "verdict": verdict,
        "accepted": [accepted] if accepted else [],
        "classes": [[accepted]] if accepted else [],
        "changed": dict.fromkeys(changed, 10.0),
        "as_well": [as_well] if as_well else [],
    }


@pytest.mark.parametrize(
    ("row", "is_right", "is_wrong"),
    [
        (_row(NOTHING), True, False),
        (_row(NOTHING, "unknown"), False, False),
        (_row(NOTHING, changed=(CSJ,)), False, True),
        (_row(NOTHING, "missing", "spring_load"), False, True),
        (_row("friction", changed=(CSJ,)), True, False),
        (_row("friction"), False, False),
        (_row("friction", changed=(VISCOUS,)), False, True),
        (_row("friction", changed=(CSJ, VISCOUS)), False, True),
        (_row("friction", "missing", "spring_load", (CSJ,)), False, True),
        (_row("spring_load", "missing", "spring_load"), True, False),
        (_row("spring_load", "missing", "spring_load", (CSJ,)), False, True),
        (_row("spring_load", "missing", "constant_load"), False, True),
        (_row("spring_load", "unknown"), False, False),
        (_row("spring_load", changed=(CSJ,), as_well="spring_load"), True, False),
    ],
)
def test_what_counts(row: dict[str, Any], is_right: bool, is_wrong: bool) -> None:
    assert (right(row), wrong(row)) == (is_right, is_wrong)
    text = written([{**row, "key": "k", "kind": "belt", "command": "sweeps", "size": ""}], "call")
    assert ("| k |" in text) is not is_right


@pytest.mark.slow
def test_a_day_changes_what_it_says_and_no_more() -> None:
    trials = plan(1)
    assert len({one.key for one in trials}) == len(trials)
    assert {one.since for one in trials} == {NOTHING, *CHANGES, *EFFECTS}
    sound, days = Machine("bare motor", 0, {}), (*HEALTHY_DAYS, TODAY)
    first, again, other = (records_of_day(sound, "pick and place", day)[0].recorded("torque_Nm") for day in (days[0], days[0], days[-1]))
    assert np.array_equal(first, again) and not np.array_equal(first[:1000], other[:1000])
    # the same noise and friction of the day, another mass: in a sweep it is the last, fastest part that tells
    heavier, plain = (records_of_day(one, "sweeps", TODAY)[0] for one in (DayTrial("bare motor", 0, "sweeps", "inertia").today, sound))
    assert np.std(heavier.recorded("torque_Nm")[-500:]) > 1.1 * np.std(plain.recorded("torque_Nm")[-500:])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("trial", "verdict", "changed", "as_well"),
    [
        # values that explain the lesser part of a play with a mass behind it are no change
        (DayTrial("linear motor", 0, "sweeps", "elastic_backlash", "large"), "unknown", [], []),
        # drag by the square of the speed, or by the speed: this motion hardly says
        (
            DayTrial("ball screw", 0, "pick and place", "quadratic_viscous", "medium"),
            "adequate",
            [VISCOUS],
            ["concave_viscous", "quadratic_viscous"],
        ),
        # a bump that is over before the machine slides well shows where it breaks away
        (DayTrial("belt", 0, "start and stop", "stribeck_friction", "medium"), "adequate", [SHARE], ["stribeck_friction"]),
    ],
)
def test_what_is_not_told_is_said(trial: DayTrial, verdict: str, changed: list[str], as_well: list[str]) -> None:
    row = perform(trial)
    assert (row["verdict"], list(row["changed"]), row["as_well"], row["accepted"]) == (verdict, changed, as_well, [])


@pytest.mark.slow
def test_one_effect_is_named_where_it_foretells_what_was_held_out_better_than_changed_values() -> None:
    row = perform(DayTrial("ball screw", 0, "pick and place", "quadratic_viscous", "large"))
    assert (row["verdict"], list(row["changed"]), row["accepted"]) == ("missing", [], ["quadratic_viscous"])
