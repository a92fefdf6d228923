"""What a healthy machine may have in its model: no spot as wide as the stroke, and nothing in the place of what is watched."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ema_tools.base.errors import InputError
from ema_tools.data.actuator import reference_actuator
from ema_tools.fit.nuisance import Spread
from ema_tools.select.beside_fault import takes_away
from ema_tools.select.cross_check import _beside_all
from ema_tools.select.known_machine import MachineFit
from ema_tools.select.strategies.healthy_machine import HealthyMachine
from ema_tools.tasks.onboard_search import check_kept

STROKE_MM = 4.0


@pytest.mark.parametrize(
    ("effect", "values", "slight"),
    [
        ("jam_spot", {"effects.jam_spot.amplitude_Nm": 0.14, "effects.jam_spot.width_mm": 12.0}, True),
        ("jam_spot", {"effects.jam_spot.amplitude_Nm": 0.02, "effects.jam_spot.width_mm": 0.3}, False),
        ("pitch_ripple", {"effects.pitch_ripple.ratio": 0.03}, False),
        # the inertia is free in a healthy machine: beside it the effect ran to +0.53 and the inertia the other way
        ("inertia_change", {"effects.inertia_change.change": 0.5}, True),
        ("gain_drift", {"effects.gain_drift.drift": 0.05}, False),
    ],
)
def test_what_stands_for_a_value_of_the_machine_itself_is_no_standing_effect(effect: str, values: dict[str, float], slight: bool) -> None:
    record = SimpleNamespace(command_mm=np.linspace(0.0, STROKE_MM, 9))
    machine: Any = SimpleNamespace(evidence=SimpleNamespace(record=record, spread=(Spread(("screw.inertia_kgm2",), 0.05, True),)))
    fit: Any = SimpleNamespace(values=values)
    assert HealthyMachine.is_slight(machine, fit, effect) is slight


def test_a_machine_without_its_friction_is_refused_and_says_what_stands_for_it() -> None:
    given = reference_actuator()
    gone = given.changed({"screw.csj_Nm": 0.0, "effects.jam_spot.amplitude_Nm": 0.14, "effects.jam_spot.width_mm": 12.0})
    with pytest.raises(InputError, match=r"healthy_0\.csv .*screw\.csj_Nm would be 0, .*jam_spot would stand for it"):
        check_kept(given, gone, "healthy_0.csv")
    check_kept(given, given.changed({"screw.csj_Nm": 0.6 * given["screw.csj_Nm"]}), "healthy_0.csv")


def test_an_effect_beside_which_play_is_gone_is_not_named() -> None:
    """A constant load, seen by the rod alone, was a sensor's offset and BLK -73 %."""
    known: Any = SimpleNamespace(evidence=SimpleNamespace(relative=True), actuator={"screw.blk_mm": 0.04}, faults=("screw.blk_mm",))
    assert takes_away(known, {"screw.blk_mm": 0.01})
    assert not takes_away(known, {"screw.blk_mm": 0.035})
    # by a data sheet alone a unit may always have had less
    known.evidence.relative = False
    assert not takes_away(known, {"screw.blk_mm": 0.01})


def test_a_fault_stands_where_it_does_beside_whatever_explains_the_other() -> None:
    known: Any = SimpleNamespace(actuator={"screw.csj_Nm": 0.14})

    def fit(effect: str, csj: float) -> MachineFit:
        return MachineFit(effect, {"screw.csj_Nm": csj}, {}, 0.0)

    assert _beside_all(known, [fit("spring_load", 0.28), fit("cogging_torque", 0.27)], "screw.csj_Nm", 0.05)
    assert not _beside_all(known, [fit("spring_load", 0.28), fit("cogging_torque", 0.145)], "screw.csj_Nm", 0.05)
