"""What strategies do with a path that the search has grown."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple, cast

import numpy as np
import pytest

from benchmarks.hidden import sealed, trials
from ema_tools.base.compiled import HAS_NUMBA
from ema_tools.fit.evidence import View
from ema_tools.fit.refit import Fit
from ema_tools.select import search
from ema_tools.select.outcome import Path, Round
from ema_tools.select.strategies import strategy
from ema_tools.select.strategies.data_sheet_alone import DataSheetAlone
from ema_tools.select.strategies.strategy import Strategy

_VIEW = cast(View, object())
_SIZES = {
    "supply_sag": "effects.supply_sag.sag",
    "cogging_torque": "effects.cogging_torque.amplitude_Nm",
    "stribeck_friction": "effects.stribeck_friction.rise",
    "directional_stribeck": "effects.directional_stribeck.rise",
    "blk": "screw.blk_mm",
}


def _fit(cost: float, *effects: str) -> Fit:
    return Fit(effects, {_SIZES[effect]: 0.1 for effect in effects}, np.zeros((0, 0)), (), _VIEW, cost)


def _fewer(path: Path, alone: Mapping[str, float]) -> Path:
    """What becomes of a path where effects fitted alone cost so much; each is fitted from its own values and no others."""

    def fitted(start: Mapping[str, float]) -> Fit:
        (name,) = start
        effect = next(effect for effect, size in _SIZES.items() if size == name)
        return _fit(alone[effect], effect)

    return object.__new__(DataSheetAlone).fewer(path, fitted)


def test_an_effect_that_explains_more_alone_is_the_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(strategy, "seen_from", lambda fit: fit.view)
    first = _fit(70.0, "supply_sag")
    path = Path((Round({}, (first,), {}), Round({}, (), {})), (first, _fit(50.0, "supply_sag", "cogging_torque")), _VIEW)
    found = _fewer(path, {"supply_sag": 70.0, "cogging_torque": 40.0})
    assert [fit.effects for fit in found.steps] == [("cogging_torque",)] and found.steps[-1].cost == 40.0
    assert [fit.effects for fit in found.rounds[0].fits] == [("cogging_torque",), ("supply_sag",)] and len(found.rounds) == 1
    assert _fewer(path, {"supply_sag": 70.0, "cogging_torque": 50.0}) is path


def test_one_effect_and_none_stay() -> None:
    for path in (Path((Round({}, (), {}),), (), _VIEW), Path((Round({}, (), {}),), (_fit(70.0, "supply_sag"),), _VIEW)):
        assert _fewer(path, {}) is path


def test_a_special_case_gone_astray_is_fitted_again_from_what_it_is_a_case_of(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[str] = []

    def as_special_case(fit: Fit, effect: str) -> Fit | None:
        asked.append(effect)
        return _fit(51.0, "stribeck_friction") if effect == "directional_stribeck" else None

    monkeypatch.setattr(search, "_as_special_case", as_special_case)
    general, cogging = _fit(50.0, "directional_stribeck"), _fit(60.0, "cogging_torque")

    def shown(special: float) -> dict[tuple[str, ...], float]:
        asked.clear()
        fits = search._with_special_cases((general, cogging, _fit(special, "stribeck_friction")), (), "directional_stribeck")
        return {fit.effects: fit.cost for fit in fits}

    # chance parts them by less than nine: then its own fit is as good
    assert shown(80.0)["stribeck_friction",] == 51.0 and asked == ["directional_stribeck"]
    assert shown(57.0)["stribeck_friction",] == 57.0 and asked == []


def test_one_physics_is_the_same_name_class_or_special_case_and_nothing_else() -> None:
    assert search._one_physics("presliding", "elastic_backlash") and search._one_physics("elastic_backlash", "presliding")
    assert search._one_physics("constant_load", "coulomb_asymmetry") and search._one_physics("supply_sag", "supply_sag")
    # neither is a special case of any
    assert not search._one_physics("presliding", "spring_load") and not search._one_physics("supply_sag", "cogging_torque")


class _Excess(NamedTuple):
    """What `_alone` asks of a strategy: costs from a floor of 10 to 110."""

    floor: float = 10.0
    excess: float = 100.0
    beyond: float = 100.0


def _alone(first: Fit, *others: Fit) -> tuple[str, ...]:
    found = search._alone(Path((Round({}, (first, *others), {}),), (first,), _VIEW), cast(Strategy, _Excess()))
    return found.effects if found is not None else ()


def test_one_effect_that_nothing_comes_near_is_in_a_form_of_its_own() -> None:
    cogging, far = _fit(20.0, "cogging_torque"), _fit(60.0, "supply_sag")
    assert _alone(cogging, far) == ("cogging_torque",)
    # a rival that leaves less than four times as much comes near, and one of the same physics is none
    assert _alone(cogging, _fit(45.0, "supply_sag")) == ()
    assert _alone(_fit(20.0, "stribeck_friction"), _fit(21.0, "directional_stribeck")) == ("stribeck_friction",)
    # another law altogether leaves so much, and a fault that nothing else explains may
    assert _alone(_fit(32.0, "cogging_torque")) == () and _alone(_fit(43.0, "blk")) == ("blk",)
    assert _alone(_fit(43.0, "blk"), _fit(95.0, "supply_sag")) == () and _alone(_fit(46.0, "blk")) == ()
    # what several effects began with is no reason against the one that does it all
    assert _alone(_fit(111.0, "supply_sag", "blk"), cogging) == ("cogging_torque",)


def _answered(kind: str, effect: str, machine: int, repeats: int) -> sealed.SealedAnswer:
    """What is said of a large effect under the reference chirp, without the ideal observer, who is not asked here."""
    trial = trials.Trial(kind, (effect,), "large", "chirp", machine, repeats)
    run, healthy = trials.runs(trial, trial.command, trials.hidden_changes(trial.unit, trial, trial.command))
    return sealed.answered(run, healthy, None, None, [])


@pytest.mark.release
@pytest.mark.skipif(not HAS_NUMBA, reason="the truth plant is slow without numba")
@pytest.mark.parametrize(("form", "machine", "named"), [("elastic_stop", 1, "blk"), ("dahl", 3, "presliding")])
def test_another_form_is_named_with_the_share_that_it_leaves(form: str, machine: int, named: str) -> None:
    """A play behind contacts that yield, and friction that stretches by a square: a winding was read of the latter's misfit, and taken for a day's temperature."""
    found = _answered("form", form, machine, 5)
    assert (found.first, list(found.accepted)) == (named, [named]) and found.verdict in ("missing", "adequate")
    assert 0.05 < found.unexplained < 0.2


@pytest.mark.release
@pytest.mark.skipif(not HAS_NUMBA, reason="the truth plant is slow without numba")
def test_a_large_cogging_is_named_alone_without_repeats() -> None:
    found = _answered("alone", "cogging_torque", 2, 0)
    assert (found.verdict, list(found.accepted)) == ("missing", ["cogging_torque"])


@pytest.mark.release
@pytest.mark.skipif(not HAS_NUMBA, reason="the truth plant is slow without numba")
@pytest.mark.parametrize(("effect", "machine"), [("actuation_delay", 1), ("viscous_rise", 3)])
def test_a_day_of_another_temperature_hides_no_effect(effect: str, machine: int) -> None:
    """Magnets were read of a hidden delay and taken off; and grease beyond all scatter was seen from the edge of what scatter may do."""
    found = _answered("scatter", effect, machine, 5)
    assert (found.verdict, list(found.accepted)) == ("missing", [effect])
    # of the excess, of which the temperature has taken its part
    assert found.unexplained < 0.12
