"""What strategies do with a path that the search has grown."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, cast

import numpy as np
import pytest

from ema_tools.base.compiled import HAS_NUMBA
from ema_tools.benchmarks.hidden import trials
from ema_tools.fit.evidence import View
from ema_tools.fit.refit import Fit
from ema_tools.select import search
from ema_tools.select.outcome import Path, Round
from ema_tools.select.strategies import strategy
from ema_tools.select.strategies.data_sheet_alone import DataSheetAlone

_VIEW = cast(View, object())
_SIZES = {
    "supply_sag": "effects.supply_sag.sag",
    "cogging_torque": "effects.cogging_torque.amplitude_Nm",
    "stribeck_friction": "effects.stribeck_friction.rise",
    "directional_stribeck": "effects.directional_stribeck.rise",
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


@pytest.mark.slow
@pytest.mark.skipif(not HAS_NUMBA, reason="the truth plant is slow without numba")
def test_a_large_cogging_is_named_alone_without_repeats() -> None:
    hidden: dict[str, Any] = {"effects": ["cogging_torque"], "severity": "large", "command": "chirp", "machine": 2, "repeats": 0, "day": 0}
    found = trials.perform(trials.restored({"key": "", "kind": "alone", "held_out": None, **hidden}))
    assert (found["verdict"], found["accepted"]) == ("missing", ["cogging_torque"])
