"""Units twice as far from their data sheet as is assumed, and with twice the ripple, without healthy runs: nothing of that is another effect, and what is hidden beside it is named alone."""

from __future__ import annotations

import pytest

from benchmarks.hidden import scoring
from benchmarks.hidden.machines import width_of_units
from benchmarks.hidden.trials import Trial, perform
from ema_tools.base.compiled import HAS_NUMBA

pytestmark = pytest.mark.skipif(not HAS_NUMBA, reason="the truth plant takes minutes a record without Numba")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("unit", "day", "was"),
    [(1703, 11, "jam_spot"), pytest.param(1003, 4, "sensor_offset"), pytest.param(2103, 15, "magnet_weakening")],
)
def test_a_healthy_unit_is_accused_of_nothing(unit: int, day: int, was: str) -> None:
    """A ripple of 0.7 % of the friction, a zero 4.8 and magnets 4 of the usual standard deviations off, each beside others as far off."""
    found = perform(Trial("twice", (), "", "chirp", unit, 0, day))
    assert found["verdict"] == "adequate" and not found["accepted"], was


@pytest.mark.slow
@pytest.mark.parametrize("effect", ["winding_heating", "inverter_dead_time"])
def test_an_effect_beside_the_units_own_ripple_is_named_alone(effect: str) -> None:
    """The ripple is 0.76 % of the friction: sought beside it, a spot in the screw explained it as well to three units of cost, and a winding of 90 degC was not asked for again."""
    assert perform(Trial("twice", (effect,), "large", "chirp", 3, 0))["accepted"] == [effect]


def test_what_units_differ_by_themselves_is_known_by_its_size() -> None:
    # 3 standard deviations of 5 % as assumed, 1.5 of units twice as wide; 8.8 of a resistance, and 17.6 of one half as wide
    assert width_of_units("screw.inertia_kgm2", "twice") == pytest.approx(0.1)
    assert width_of_units("screw.inertia_kgm2", "half") == pytest.approx(0.05)
    assert width_of_units("encoder.rod_offset_mm", "twice") == pytest.approx(0.006)

    def within(effect: str, severity: str, kind: str) -> bool:
        return scoring.of_units({"effects": [effect], "severity": severity, "kind": kind})

    assert within("inertia_change", "large", "half") and within("inertia_change", "large", "twice")
    assert within("winding_heating", "medium", "half") and not within("winding_heating", "large", "half")
    assert not within("cogging_torque", "medium", "twice")
