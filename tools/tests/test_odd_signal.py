"""What one signal alone shows is told from what the machine does: a sensor that sticks, saturates or jumps, a recorder's clock that jitters, a voltage that is not the applied one; and magnets that
are as warm as the winding are no effect. Machines are of the truth plant, which shares no code with the module."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import fields, replace
from functools import cache

import numpy as np
import pytest

from benchmarks.hidden.machines import machine, measured
from benchmarks.hidden.sealed import record_of
from ema_tools.base.arrays import Reals
from ema_tools.base.recording import Recording
from ema_tools.data.actuator import reference_actuator
from ema_tools.data.records import Record
from ema_tools.tasks.diagnose import answer
from ema_tools.tasks.identify import Identified, identify
from ema_tools.words.answers.diagnosis import diagnosis
from ema_tools.words.answers.identification import identification
from ema_tools.words.sentences.identification import reasons, sentence

pytestmark = pytest.mark.slow
KNOWN = reference_actuator()
UNIT = machine(41)
# of ten seconds of a chirp: the time of a search grows with the rows
WHOLE, HALF = 10_000, 5_000
MAGNETS = ("motor.torque_constant_Nm_per_A", "motor.back_emf_V_s_per_rad")


def _run(changes: Mapping[str, float], seed: int, rows: int) -> Recording:
    """The first rows of a chirp."""
    run = measured(UNIT, changes, "chirp", seed)
    return Recording(**{field.name: getattr(run, field.name)[:rows] for field in fields(run)})


def _of_unit(name: str) -> float:
    return UNIT.values.get(name, KNOWN[name])


@cache
def _today(warmer_degC: float = 0.0, of_magnets: float = 0.0, sag: float = 0.0, rows: int = HALF) -> Recording:
    """A run with copper, grease and magnets as they are at that temperature, the magnets by a share of it."""
    changes = {
        "motor.resistance_ohm": (1.0 + 0.00393 * warmer_degC) * _of_unit("motor.resistance_ohm"),
        "screw.viscous_Nm_s_per_rad": math.exp(-0.03 * warmer_degC) * _of_unit("screw.viscous_Nm_s_per_rad"),
        **{name: (1.0 - of_magnets * warmer_degC) * _of_unit(name) for name in MAGNETS},
        "drive.supply_V": (1.0 - sag) * _of_unit("drive.supply_V"),
    }
    return _run(changes, 99, rows)


@cache
def _healthy(rows: int) -> tuple[Record, ...]:
    return tuple(record_of(_run({}, seed, rows), seed) for seed in range(3))


def _identified(run: Recording) -> Identified:
    return identify(KNOWN, record_of(run, 99), _healthy(run.command_mm.size))


def _diagnosed(run: Recording) -> str:
    return diagnosis(answer(KNOWN, record_of(run, 99), _healthy(run.command_mm.size)), {}).sentence


def _sticks(run: Recording) -> Recording:
    read, held = np.array(run.position_mm), run.position_mm[0]
    for row, value in enumerate(read):
        held = value if abs(value - held) > 0.02 else held
        read[row] = held
    return replace(run, position_mm=read)


def _saturates(run: Recording) -> Recording:
    return replace(run, current_A=np.clip(run.current_A, -3.5, 3.5))


@pytest.mark.parametrize(
    ("errs", "said"),
    [
        (_sticks, "shows in the rod position (position_mm) alone"),
        (_saturates, "shows in the current (current_A) alone"),
    ],
)
def test_a_sensor_that_errs_in_its_own_way_is_suspected(errs: Callable[[Recording], Recording], said: str) -> None:
    found = _identified(errs(_today()))
    assert found.verdict == "undecided" and found.checked is not None and found.checked.sensor is not None
    assert len(reasons(found)) >= 1 and said in reasons(found)[0] and "record again" in reasons(found)[0]
    assert said in _diagnosed(errs(_today()))
    sensor = identification(found, "today.csv", {}).sensor
    assert sensor is not None and sensor.channel == found.checked.sensor.channel and sensor.sentence in reasons(found)[0]


def test_rows_that_were_not_taken_evenly_are_the_clock_s() -> None:
    run = _today()
    late_s = np.random.default_rng(5).uniform(-4e-4, 4e-4, run.position_mm.size)
    place = np.arange(run.position_mm.size) * 1e-3

    def at(signal: Reals) -> Reals:
        return np.interp(place - late_s, place, signal)

    found = _identified(
        replace(run, **{name: at(getattr(run, name)) for name in ("position_mm", "motor_position_mm", "current_A", "voltage_V")})
    )
    assert found.verdict == "undecided" and found.checked is not None and found.checked.sensor is not None
    assert found.checked.sensor.channel == "time_s" and found.checked.sensor.late_s == pytest.approx(8e-4 / math.sqrt(12.0), rel=0.1)
    assert "not evenly spaced in time" in sentence(found)


def test_a_supply_that_gives_less_than_is_asked_of_it_is_named_whichever_voltage_is_recorded() -> None:
    applied = _today(sag=0.06)
    asked = replace(applied, voltage_V=applied.voltage_V / 0.94)
    for run, left_out in ((applied, ""), (asked, "voltage_V")):
        checked = _identified(run).checked
        assert checked is not None and checked.kind == "missing" and checked.left_out == left_out
        assert next(iter(checked.values.values())) == pytest.approx(0.06, abs=0.004)


# on half a chirp the grease is read as three times as warm, until the magnets are known
@pytest.mark.parametrize(("warmer_degC", "rows"), [(13.0, HALF), (-11.0, WHOLE)])
def test_magnets_as_warm_as_the_winding_are_no_effect(warmer_degC: float, rows: int) -> None:
    run = _today(warmer_degC, 0.001, rows=rows)
    found = _identified(run)
    assert found.verdict == "healthy" and found.magnets is not None
    assert found.magnets.warmer_degC == pytest.approx(warmer_degC, abs=2.0) and found.magnets.loss == pytest.approx(
        0.001 * warmer_degC, abs=0.003
    )
    assert "as temperature makes them, which is taken off" in sentence(found)
    assert "no effect is missing" in _diagnosed(run)


@pytest.mark.parametrize(
    ("warmer_degC", "of_magnets"), [(13.0, -0.001), (8.0, 0.005)], ids=["to the other side", "beyond what temperature does"]
)
def test_what_temperature_does_not_make_of_magnets_is_named(warmer_degC: float, of_magnets: float) -> None:
    found = _identified(_today(warmer_degC, of_magnets))
    assert (
        found.magnets is None
        and found.verdict == "undecided"
        and found.checked is not None
        and found.checked.kind in ("missing", "unknown")
    )
