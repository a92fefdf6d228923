"""The trials on machines whose days differ in everything: which there are, and how an answer is judged."""

from __future__ import annotations

import pytest

from benchmarks.days.simulator import EFFECTS, machine_values, record
from benchmarks.days.trials import HEALTHY, KINDS, Trial, judged, trials
from benchmarks.hidden.sealed import Said, SealedAnswer
from ema_tools.library.definitions import load_definitions
from ema_tools.library.faults import FAULTS


def answer(verdict: str, *accepted: str, refused: str | None = None) -> SealedAnswer:
    said = tuple(Said(name, (name,), {}, {}, 1.0, True) for name in accepted)
    return SealedAnswer(verdict, said, {}, {}, None, 0.0, None, refused, 0.0, 0.0)


def trial(kind: str, *hidden: str) -> Trial:
    return Trial(kind, 1, hidden, "medium", 5, 1.0)


def test_every_trial_has_a_machine_of_its_own_and_names_of_the_library() -> None:
    every = trials(KINDS, 5, 1.0)
    assert len({one.number for one in every}) == len({one.key for one in every}) == len(every)
    assert sum(one.kind == "healthy" for one in every) == HEALTHY
    known = {effect.name for effect in load_definitions().physical} | set(FAULTS)
    assert {name for one in every for names in one.names for name in names} <= known
    assert machine_values(1) == machine_values(1) != machine_values(2)


def test_an_unknown_change_is_refused() -> None:
    with pytest.raises(KeyError, match="no_such"):
        record(1, (1,), {"no_such": 1.0, **dict.fromkeys(EFFECTS, 0.0)})


@pytest.mark.parametrize(
    ("one", "said", "expected"),
    [
        (trial("healthy"), answer("adequate"), "right"),
        (trial("healthy"), answer("unknown"), "unknown"),
        (trial("healthy"), answer("missing", "supply_sag"), "accused"),
        (trial("healthy"), answer("refused", refused="no"), "refused"),
        (trial("effect", "bus_low"), answer("missing", "supply_sag"), "right"),
        (trial("effect", "bus_low"), answer("missing", "supply_sag", "csj"), "part"),
        (trial("effect", "bus_low"), answer("missing", "inertia_change"), "wrong"),
        (trial("effect", "bus_low"), answer("unknown"), "unnamed"),
        (trial("fault", "play_mm"), answer("missing", "blk"), "right"),
        (trial("pair", "bus_low", "heavier"), answer("missing", "inertia_change"), "part"),
        (trial("outside", "slow_return"), answer("unknown"), "right"),
        (trial("outside", "slow_return"), answer("missing", "presliding"), "wrong"),
    ],
)
def test_an_answer_is_judged_by_what_is_hidden(one: Trial, said: SealedAnswer, expected: str) -> None:
    assert judged(one, said) == expected
