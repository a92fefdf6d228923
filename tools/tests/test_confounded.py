"""Effects that do what a parameter does: the same model either way, and a size with the doubt of the parameter."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.hidden.catalogue import LIBRARY
from benchmarks.hidden.machines import machine, measured
from benchmarks.hidden.sealed import STEP_S
from ema_tools.base.compiled import HAS_NUMBA
from ema_tools.data.actuator import reference_actuator
from ema_tools.data.records import Record
from ema_tools.fit.confounded import confounded_fits, confounded_parameter
from ema_tools.fit.evidence import settled
from ema_tools.fit.nuisance import SLIGHT_REACH, is_slight, slight
from ema_tools.library.definitions import load_definitions
from ema_tools.library.faults import effect_of
from ema_tools.library.registry import record_of
from ema_tools.select.baseline import gather
from ema_tools.select.holdout import ErrorFall
from ema_tools.select.search import diagnose
from ema_tools.tasks.diagnose import answer
from ema_tools.words.sentences.diagnosis import sentence
from support import chirp_record

needs_numba = pytest.mark.skipif(not HAS_NUMBA, reason="the truth plant takes minutes a record without Numba")
NOISE = {"position_mm": 0.002, "motor_position_mm": 0.002, "current_A": 0.03, "voltage_V": 0.01}
SIZES = {
    "rise_degC": 12.0,
    "loss": 0.03,
    "sag": 0.01,
    "change": 0.06,
    "drift": 0.006,
    "rise": 0.4,
    "error": 0.0004,
    "offset_mm": 0.004,
    "asymmetry": 0.005,
}

CONFOUNDED = [f"effects.{row.size.name}" for row in load_definitions().effects if record_of(row.name).confounded is not None]


@pytest.mark.parametrize("name", CONFOUNDED)
def test_the_effect_and_its_parameter_make_the_same_model(name: str) -> None:
    actuator, parameter = reference_actuator(), confounded_parameter(name)
    assert parameter is not None
    size = SIZES[name.split(".")[-1]]
    spread = next(one for one in gather(actuator, noisy({}, 1)).spread if one.title == parameter.parameter)
    change = size / parameter.size_per_change
    with_effect = chirp_record(actuator.changed({name: size}))
    with_parameter = chirp_record(actuator.changed(spread.changes(actuator, change / spread.std)))
    for channel in ("position_mm", "motor_position_mm", "current_A", "voltage_V"):
        one, other = getattr(with_effect, channel), getattr(with_parameter, channel)
        # both in double precision: only the order of the products differs
        assert np.max(np.abs(one - other)) < 1e-6 * np.max(np.abs(other)), channel


def noisy(changes: dict[str, float], seed: int) -> Record:
    return replace(chirp_record(reference_actuator().changed(changes)).with_noise(NOISE, seed), file=f"run {seed}")


@pytest.mark.slow
def test_what_a_data_sheet_leaves_open_is_not_named_and_what_it_does_not_is_with_its_doubt() -> None:
    for rise, named in ((12.0, ()), (100.0, ("winding_heating",))):
        found = diagnose(gather(reference_actuator(), noisy({"winding_heating.rise_degC": rise}, 5)))
        assert tuple(one.name for one in found.named if one.accepted) == named
    size, std = found.named[0].values["effects.winding_heating.rise_degC"], found.named[0].std["effects.winding_heating.rise_degC"]
    # 4 % of a resistance that is up to 39 % larger are 10 to 14 degC; what else is known by the data sheet alone adds to it
    assert 10.0 < std < 40.0 and size == pytest.approx(100.0, abs=2.0 * std)


def test_a_twin_that_cannot_have_the_sign_is_left_out() -> None:
    sheet = reference_actuator()
    strong = gather(
        sheet, noisy({name: 1.05 * sheet[name] for name in ("motor.torque_constant_Nm_per_A", "motor.back_emf_V_s_per_rad")}, 6)
    )
    assert "magnet_weakening" not in {effect_of(name) for fit in confounded_fits(settled(strong, {}, reach=12.0)) for name in fit.values}


def test_slight_is_what_every_machine_has() -> None:
    ripple = "effects.pitch_ripple.ratio"
    usual = max(changes[ripple] for changes in slight() if ripple in changes)
    sheet = reference_actuator()
    assert is_slight(sheet, ripple, SLIGHT_REACH * usual) and not is_slight(sheet, ripple, 1.01 * SLIGHT_REACH * usual)
    assert not is_slight(sheet, "effects.pitch_ripple.phase_rad", 0.0) and not is_slight(sheet, "effects.winding_heating.rise_degC", 0.0)
    # cogging of 1.5 % and a spot of 0.8 % of the dry friction
    for name, most in (("effects.cogging_torque.amplitude_Nm", 0.00207), ("effects.jam_spot.amplitude_Nm", 0.0011)):
        assert is_slight(sheet, name, most) and not is_slight(sheet, name, 1.05 * most)


@pytest.mark.parametrize("effect", LIBRARY)
def test_no_effect_of_a_typical_size_is_slight(effect: str) -> None:
    """Nor one of half the lower end of its typical range."""
    assert not is_slight(reference_actuator(), f"effects.{effect}.{LIBRARY[effect].size}", 0.5 * LIBRARY[effect].medium)


@pytest.mark.slow
@needs_numba
@pytest.mark.parametrize("unit", [3, pytest.param(5, marks=pytest.mark.slow)])
def test_a_healthy_unit_that_is_known_by_its_data_sheet_alone_is_not_accused(unit: int) -> None:
    """Contacts that stretch before they slide look a little like Stribeck friction (0.1 %), and like a spring."""
    run = measured(machine(unit), {}, "chirp", 91)
    found = diagnose(
        gather(
            reference_actuator(),
            Record(STEP_S, run.command_mm, run.position_mm, run.motor_position_mm, run.current_A, run.voltage_V, file="run"),
        )
    )
    assert found.verdict == "adequate", [(one.name, one.score, one.values) for one in found.named]


@pytest.mark.slow
def test_no_share_of_chance_is_said_to_stay() -> None:
    """Beside what a unit's own parameters explain little is left to be shared."""
    found = answer(reference_actuator(), noisy({"sensor_offset.offset_mm": 0.05}, 8))
    assert found.diagnosis.verdict == "missing" and found.errors.after < 1.05 * found.errors.floor
    assert "sensor_offset" in sentence(found) and "stays unexplained" not in sentence(found)
    much = replace(found, errors=ErrorFall(60.0, 3.4, 0.9, 40.0, 4.5, 0.9))
    assert "3.8 times the floor is left, so that more is missing; of the record held out 5 times its floor is left" in sentence(much)
