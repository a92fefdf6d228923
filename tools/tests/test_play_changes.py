"""The play between motor and rod by both positions, on records written down here: where friction decides the side, where a load does, and what has changed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ema_tools.base.arrays import Reals
from ema_tools.data.actuator import Actuator, read_actuator
from ema_tools.data.motion_records import MotionRecord
from ema_tools.select.play_changes import play_seen
from ema_tools.tasks.diagnose_by_balance import BalanceAnswer, answer_by_balance

PERIOD_S, NOISE_MM = 0.002, 0.002
MM_PER_RAD = 0.8
INERTIA, VISCOUS, DRY, CONSTANT = 2e-3, 2e-3, 0.4, 0.5


def moves(seed: int) -> tuple[Reals, Reals]:
    """Motor position in mm and its rate, with rests."""
    random = np.random.default_rng(seed)
    asked: list[Reals] = []
    for k in range(16):
        speed = float(random.uniform(8.0, 40.0)) * (1.0 if k % 2 else -1.0)
        asked += [np.full(int(random.integers(200, 320)), speed), np.zeros(60)]
    smooth = np.hanning(41)
    rate = np.convolve(np.concatenate(asked), smooth / smooth.sum(), mode="same")
    place = np.cumsum(rate) * PERIOD_S
    return place - np.mean(place), rate


def behind(motor: Reals, width: float) -> Reals:
    """A rod that stays until the play is used up."""
    rod = np.empty_like(motor)
    here = float(motor[0])
    for k, place in enumerate(motor.tolist()):
        here = min(max(here, place - 0.5 * width), place + 0.5 * width)
        rod[k] = here
    return rod


def record(seed: int, width: float, *, by_load: bool = False, dry: float = DRY) -> MotionRecord:
    """One record of both positions and the current; `by_load`: a spring at the rod holds it against one side, on either side of its middle."""
    random = np.random.default_rng(1000 + seed)
    motor, rate = moves(seed)
    rod = motor - 0.5 * width * np.sign(motor) if by_load else behind(motor, width)
    speed = rate / MM_PER_RAD
    torque = INERTIA * np.gradient(speed, PERIOD_S) + VISCOUS * speed + dry * (1.0 + 0.01 * random.normal()) * np.sign(np.round(speed, 3))
    return MotionRecord(
        PERIOD_S,
        f"run_{seed}.csv",
        position_mm=1.0005 * rod + 0.3 + NOISE_MM * random.normal(size=rod.size),
        motor_position_mm=motor,
        current_A=torque / CONSTANT + 0.01 * random.normal(size=rod.size),
    )


@pytest.fixture
def sheet(tmp_path: Path) -> Actuator:
    path = tmp_path / "actuator.toml"
    lead = 2.0 * np.pi * MM_PER_RAD
    path.write_text(
        f"[motor]\ntorque_constant_Nm_per_A = {CONSTANT}\n\n[gearbox]\nratio = 1.0\n\n[screw]\nlead_mm = {lead}\ninertia_kgm2 = {INERTIA}\n"
        "viscous_Nm_s_per_rad = 2e-3\ncsj_Nm = 0.4\n",
        encoding="utf-8",
    )
    return read_actuator(path, complete=False)


@pytest.mark.parametrize("by_load", [False, True], ids=["friction", "load"])
@pytest.mark.parametrize("width", [0.015, 0.03, 0.1])
def test_width_is_seen_whatever_decides_the_side(sheet: Actuator, width: float, by_load: bool) -> None:
    found = play_seen(sheet, record(1, width, by_load=by_load))
    assert found is not None
    # a tenth of the sensor's noise, which thousands of rows average
    assert found.width_mm == pytest.approx(width, abs=0.0006, rel=0.02)
    assert found.left_mm == pytest.approx(NOISE_MM, rel=0.1)


def test_no_play_is_told_of_other_signals(sheet: Actuator) -> None:
    there = record(1, 0.03)
    alone = MotionRecord(PERIOD_S, "alone.csv", position_mm=there.position_mm, current_A=there.current_A)
    assert play_seen(sheet, alone) is None
    assert there.motor_position_mm is not None
    # of another axis
    other = MotionRecord(PERIOD_S, "other.csv", position_mm=there.motor_position_mm[::-1].copy(), motor_position_mm=there.motor_position_mm)
    assert play_seen(sheet, other) is None


def answered(sheet: Actuator, today: list[MotionRecord]) -> BalanceAnswer:
    return answer_by_balance(sheet, today, healthy=[record(seed, 0.03) for seed in range(4)])


@pytest.mark.slow
def test_a_play_that_has_grown_is_told_and_nothing_else(sheet: Actuator) -> None:
    found = answered(sheet, [record(seed, 0.06) for seed in (50, 51)])
    (change,) = found.changed
    assert (found.verdict, change.name) == ("adequate", "screw.blk_mm")
    assert (change.healthy, change.today) == (pytest.approx(0.03, rel=0.03), pytest.approx(0.06, rel=0.03))
    assert abs(change.today - change.healthy - 0.03) < 1.96 * change.std
    assert any(one.name == "screw.blk_mm" and one.by_import and one.value == pytest.approx(0.03, rel=0.03) for one in found.base)


@pytest.mark.slow
def test_a_play_that_is_the_same_is_no_change_beside_more_friction(sheet: Actuator) -> None:
    found = answered(sheet, [record(seed, 0.031, dry=1.3 * DRY) for seed in (60, 61)])
    assert [one.name for one in found.changed] == ["screw.csj_Nm"]
