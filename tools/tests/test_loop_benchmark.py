"""The walks along the advised commands: how an end is counted, with a command in place of `ema` that answers at once."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pytest

from benchmarks.loop import simulator, trials
from benchmarks.loop.document import written
from benchmarks.loop.trials import Trial, Truth
from benchmarks.loop.walk import MOST_COMMANDS, Answer, Walk, ema, judged, perform, walked

FIRST = ["ema", "diagnose", "reference", "today.csv"]
IDENTIFY = ["ema", "identify", "reference", "today.csv"]
HEALTHY = {"csj": 0.138, "blk": 0.033}
SOUND = Truth((), {}, HEALTHY, HEALTHY)
WORN = Truth((), {"blk": 0.6}, HEALTHY, {"csj": 0.138, "blk": 0.0528})


def diagnosis(*advised: Sequence[str], **values: Any) -> Answer:
    result: dict[str, Any] = {
        "command": "diagnose",
        "method": "simulation",
        "verdict": "missing",
        "next": [list(one) for one in advised],
        **values,
    }
    printed = "".join(f"Next: do it: {' '.join(one)}\n" for one in advised)
    return Answer(0, printed, "", result)


def identification(verdict: str, blk_mm: float = 0.033) -> Answer:
    sizes = {
        key: {
            "estimate": value,
            "healthy": healthy,
            "shift_percent": 100.0 * (value / healthy - 1.0),
            "interval95": [value * 0.98, value * 1.02],
        }
        for key, value, healthy in (("csj_Nm", 0.138, 0.138), ("blk_mm", blk_mm, 0.033))
    }
    return Answer(0, "", "", {"command": "identify", "verdict": verdict, "next": [], **sizes})


def walk_of(answers: Mapping[str, Answer]) -> Walk:
    """The walk where each command answers as told by its line."""
    return walked(FIRST, Path(), lambda arguments, folder, answer: answers[" ".join(arguments)])


def test_a_circle_is_counted() -> None:
    walk = walk_of({" ".join(FIRST): diagnosis(IDENTIFY), " ".join(IDENTIFY): diagnosis(FIRST)})
    assert walk.end == "circle" and len(walk.steps) == 3 and judged(walk, SOUND)[0] == "circle"


@pytest.mark.parametrize(
    "answer",
    [
        Answer(70, "", "Traceback (most recent call last):\nKeyError: 'width_mm'", {}),
        Answer(1, "", "ema: today.csv: does not exist", {}),
        Answer(0, "Traceback (most recent call last):", "", {"command": "diagnose", "next": []}),
        Answer(0, "no result", "", {}),
    ],
)
def test_a_traceback_and_a_refusal_are_errors(answer: Answer) -> None:
    walk = walk_of({" ".join(FIRST): diagnosis(IDENTIFY), " ".join(IDENTIFY): answer})
    assert walk.end == "error" and judged(walk, SOUND)[0] == "error"
    assert walk.steps[-1]["command"] == " ".join(IDENTIFY)


def test_advice_that_never_ends_is_counted() -> None:
    walk = walked(FIRST, Path(), lambda arguments, folder, answer: diagnosis([*arguments, "again"]))
    assert walk.end == "long" and len(walk.steps) == MOST_COMMANDS and not walk.unprinted


def test_an_advised_command_that_is_not_printed_is_counted() -> None:
    answer = diagnosis(IDENTIFY)
    walk = walk_of({" ".join(FIRST): Answer(0, "Next: ema identify\n", "", answer.result), " ".join(IDENTIFY): identification("healthy")})
    assert walk.unprinted == [" ".join(IDENTIFY)] and walk.end == "verdict"


@pytest.mark.parametrize(
    ("verdict", "blk_mm", "truth", "expected"),
    [
        ("healthy", 0.033, SOUND, "right"),
        ("healthy", 0.033, WORN, "wrong"),
        ("fault", 0.0528, WORN, "right"),
        ("fault", 0.0545, WORN, "right"),  # outside its interval, by less than a tenth of the healthy value
        ("fault", 0.0600, WORN, "wrong"),
        ("fault", 0.0528, SOUND, "wrong"),
        ("undecided", 0.0528, WORN, "undecided"),
    ],
)
def test_a_verdict_is_judged_by_the_truth(verdict: str, blk_mm: float, truth: Truth, expected: str) -> None:
    walk = walk_of({" ".join(FIRST): diagnosis(IDENTIFY), " ".join(IDENTIFY): identification(verdict, blk_mm)})
    assert judged(walk, truth)[0] == expected


@pytest.mark.parametrize(
    ("verdict", "accepted", "hidden", "expected"),
    [
        ("adequate", (), (), "right"),
        ("adequate", (), ("spring_load",), "undecided"),
        ("missing", ("spring_load",), ("spring_load",), "right"),
        ("missing", ("cogging_torque",), ("spring_load",), "wrong"),
        ("missing", ("cogging_torque",), (), "wrong"),
        ("missing", ("presliding",), (), "right"),  # which every one of those machines has
    ],
)
def test_an_end_by_the_balance_is_judged_by_its_names(
    verdict: str, accepted: tuple[str, ...], hidden: tuple[str, ...], expected: str
) -> None:
    effects = [{"name": name, "class": [], "accepted": True} for name in accepted]
    walk = walk_of({" ".join(FIRST): diagnosis(method="balance", verdict=verdict, effects=effects, faults={})})
    assert walk.end == "verdict" and judged(walk, Truth(hidden, {}, None, None))[0] == expected


def test_worn_friction_that_the_balance_calls_healthy_is_wrong() -> None:
    walk = walk_of({" ".join(FIRST): diagnosis(method="balance", verdict="adequate", effects=[], faults={})})
    assert judged(walk, Truth((), {"csj": 0.3}, None, None)) == ("wrong", "csj called healthy")


def test_an_effect_that_was_added_before_counts_at_the_end_by_the_balance() -> None:
    add = ["ema", "add", "reference", "spring_load"]
    effects = [{"name": "spring_load", "class": [], "accepted": True}]
    answers = {
        " ".join(FIRST): diagnosis(add, method="balance", effects=effects, faults={}),
        " ".join(add): diagnosis(IDENTIFY, command="add"),
        " ".join(IDENTIFY): diagnosis(method="balance", verdict="adequate", effects=[], faults={}),
    }
    assert judged(walk_of(answers), Truth(("spring_load",), {}, None, None))[0] == "right"


def test_the_list_is_long_enough_and_a_sample_is_even() -> None:
    every = trials.trials()
    kinds = Counter(trial.kind for trial in every)
    assert len(every) >= 600 and len({trial.key for trial in every}) == len(every)
    sample = Counter(trial.kind for trial in trials.trials(100))
    assert all(abs(sample[kind] - 100.0 * count / len(every)) < 3.0 for kind, count in kinds.items())
    assert trials.trials(50) == trials.trials(100)[:50]


def test_the_document_lists_every_walk_that_is_not_right() -> None:
    steps = [{"command": "ema diagnose reference today.csv", "sentence": "Told so.", "next": "", "seconds": 1.0}]
    rows = [
        {"key": f"walk {end}", "kind": "fault", "judged": end, "why": "", "steps": steps, "unprinted": []}
        for end in ("right", "wrong", "circle")
    ]
    text = written(rows, "call")
    assert "| fault | 3 | 1.0 | 1 | 0 | 1 | 1 | 0 | 0 |" in text
    assert "### walk wrong" in text and "### walk circle" in text and "### walk right" not in text


def test_an_unknown_effect_of_the_simulator_is_refused() -> None:
    with pytest.raises(KeyError, match="no_such_effect"):
        simulator.record(3, (1,), {"no_such_effect": 1.0})


@pytest.mark.slow
@pytest.mark.parametrize(("faults", "verdict"), [((), "healthy"), ((("blk", 0.6),), "fault")])
def test_a_walk_on_the_simulator_ends_at_the_truth(faults: tuple[tuple[str, float], ...], verdict: str) -> None:
    row = perform(Trial(5, "fault", "simulator", 3, faults=faults))
    assert (row["end"], row["judged"], row["verdict"]) == ("verdict", "right", verdict)
    assert not row["unprinted"]


def test_a_trial_names_what_is_hidden() -> None:
    trial = Trial(7, "effect and fault", "truth", 1, ("supply_sag",), "large", (("csj", 0.4),), 0)
    assert trial.key == "7: effect and fault, truth 1, chirp: supply_sag + csj +40 % large, no baseline"


@pytest.mark.slow
def test_what_explains_as_much_too_weakly_to_be_named_is_told_beside_what_is_named(tmp_path: Path) -> None:
    """Stribeck friction of a joint whose records hardly reach the speeds where it falls: a drag that bends does the same there."""
    trial = next(one for one in trials.trials() if one.number == 620)
    first, truth = trial.prepare(tmp_path)
    answer = ema(first, tmp_path, "answer.json")
    assert answer.code == 0, answer.err
    named = next(one for one in answer.result["effects"] if one["accepted"])
    assert truth.effects == ("stribeck_friction",)
    assert set(truth.effects) <= {named["name"], *named["class"]}


@pytest.mark.slow
def test_what_the_balance_names_can_be_added_where_a_free_inertia_would_hide_it(tmp_path: Path) -> None:
    trial = next(one for one in trials.trials() if one.number == 564)
    row = perform(trial)
    assert [step["command"].split()[1] for step in row["steps"]] == ["diagnose", "add", "diagnose"]
    assert row["judged"] in ("right", "undecided")


def test_records_that_the_first_command_refuses_are_no_advice_that_fails(tmp_path: Path) -> None:
    refused = Answer(1, "", "ema: today.csv: too few rows: record more", {})
    assert walked(FIRST, tmp_path, lambda *_: refused).end == "open"
    assert walked(FIRST, tmp_path, lambda *_: Answer(1, "", "Traceback (most recent call last):", {})).end == "error"
    advised = iter((diagnosis(IDENTIFY), refused))
    assert walked(FIRST, tmp_path, lambda *_: next(advised)).end == "error"
