"""Which sets of causes a search fits beside those of its path, and what of them is told in its answer."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import cast

import numpy as np
import pytest

from benchmarks.hidden import sealed, trials
from ema_tools.base.compiled import HAS_NUMBA
from ema_tools.fit.evidence import View
from ema_tools.fit.refit import Fit
from ema_tools.select import probable, search

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


def test_an_effect_of_an_answer_is_also_fitted_in_its_special_case(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Mapping[str, float]] = []
    seen = View.__new__(View)
    object.__setattr__(seen, "evidence", object())
    object.__setattr__(seen, "_place", type("Place", (), {"at": np.zeros(0)})())

    def refitted(_view: View, start: Mapping[str, float]) -> Fit:
        asked.append(start)
        return _fit(51.0, "stribeck_friction")

    monkeypatch.setattr(search, "settled", lambda *_: _VIEW)
    monkeypatch.setattr(search, "refit", refitted)
    general = replace(_fit(50.0, "directional_stribeck", "cogging_torque"), view=seen)
    assert len(search._special_cases(general)) == 1
    assert set(asked[0]) == {_SIZES["cogging_torque"], _SIZES["stribeck_friction"]}
    assert search._special_cases(replace(_fit(50.0, "supply_sag"), view=seen)) == []


def test_look_alikes_are_those_that_were_fitted_in_its_place() -> None:
    pool = [_fit(40.0, "stribeck_friction", "blk"), _fit(41.0, "directional_stribeck", "blk"), _fit(60.0, "supply_sag")]
    held, likely = ("stribeck_friction", "blk"), ("directional_stribeck", "supply_sag")
    assert probable._alike("stribeck_friction", likely, held, pool) == ["directional_stribeck"]
    assert probable._alike("blk", likely, held, pool) == []


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
