"""Records of a machine of which nothing is simulated: rows that no machine makes, a drive that has nothing to do with the motion, and a swing that is faster than the filter passes."""

from __future__ import annotations

import io
from contextlib import redirect_stdout

import numpy as np
import pytest

from benchmarks.machines.trials import actuator_of
from ema_tools.base.arrays import Reals
from ema_tools.compare.friction_map import measured_bump
from ema_tools.compare.motion_validity import judge_motion
from ema_tools.compare.odd_rows import UNSEEN
from ema_tools.data.motion_records import MotionRecord
from ema_tools.tasks.diagnose_by_balance import BalanceAnswer
from ema_tools.tasks.method import diagnosed
from ema_tools.words.answers.method import diagnosis
from ema_tools.words.sentences.balance import sentence
from ema_tools.words.terminal.console import output, table

PERIOD_S = 2e-3
MACHINE = actuator_of("bare motor", 0).changed({"screw.inertia_kgm2": 2.4e-5, "screw.viscous_Nm_s_per_rad": 2.5e-5, "screw.csj_Nm": 0.012})


def swept(torque: Reals | None = None, speed_limit: float = np.inf) -> MotionRecord:
    """Twenty seconds to and fro, with noise of 0.04 rad/s and 0.4 mNm."""
    random, time = np.random.default_rng(3), np.arange(10_000) * PERIOD_S
    speed = 60.0 * np.sin(2.0 * np.pi * 0.4 * time)
    made = 2.4e-5 * np.gradient(speed, PERIOD_S) + 2.5e-5 * speed + 0.012 * np.sign(speed) + random.normal(0.0, 4e-4, time.size)
    read = np.clip(speed + random.normal(0.0, 0.04, time.size), -speed_limit, speed_limit)
    return MotionRecord(PERIOD_S, "swept.csv").with_columns({"motor_speed_rad_s": read, "torque_Nm": made if torque is None else torque})


def steady(speed_rad_s: float, seed: int, cogging_Nm: float) -> MotionRecord:
    """Eight seconds at one speed, which is read with noise of 0.04 rad/s."""
    random, time = np.random.default_rng(seed), np.arange(4000) * PERIOD_S
    torque = 0.012 * np.sign(speed_rad_s) + 2.5e-5 * speed_rad_s + cogging_Nm * np.sin(14.0 * speed_rad_s * time)
    return MotionRecord(PERIOD_S, f"steady_{seed}.csv").with_columns(
        {
            "motor_speed_rad_s": speed_rad_s + random.normal(0.0, 0.04, time.size),
            "torque_Nm": torque + random.normal(0.0, 4e-4, time.size),
        }
    )


def speeds(cogging_Nm: float) -> list[MotionRecord]:
    return [steady(side * speed, 2 * k + (side > 0), cogging_Nm) for k, speed in enumerate((12.0, 25.0, 50.0, 100.0)) for side in (-1, 1)]


def remarks(record: MotionRecord) -> dict[str, str]:
    return {remark.topic: remark.text for remark in judge_motion(MACHINE, record).remarks}


def test_a_sound_record_has_nothing_odd() -> None:
    assert not remarks(swept())
    assert UNSEEN not in remarks(steady(12.0, 1, 0.0))


def test_a_value_far_off_is_said_with_its_row() -> None:
    record = swept()
    assert record.torque_Nm is not None
    torque = record.torque_Nm.copy()
    torque[3000] = 99999.0
    assert "torque_Nm is 1e+05 in row 3001" in remarks(swept(torque))["spikes"]


def test_a_speed_that_is_cut_off_is_said() -> None:
    said = remarks(swept(speed_limit=50.0))["clipping"]
    assert "motor_speed_rad_s stands at its highest value 50" in said


def test_a_drive_that_is_noise_is_said() -> None:
    noise = np.random.default_rng(5).normal(0.0, 0.02, 10_000)
    assert "leave" in remarks(swept(noise))["signals"]


@pytest.mark.slow
def test_no_machine_is_called_adequate_that_swings_faster_than_its_records_show() -> None:
    """Noise of the speed lowers the filter to where the magnets of a motor that turns slowly are no more seen: "no effect is missing" was said of 15 % of cogging."""
    found = diagnosed(MACHINE, speeds(1.8e-3))
    assert isinstance(found, BalanceAnswer)
    assert found.verdict != "adequate" or any("cogging_torque" in (step.effect, *step.alike) for step in found.accepted)
    if not found.accepted:
        assert "swings 14 times per motor turn" in sentence(found)
        assert any("swings 14 times" in remark.text for remark in diagnosis(found, {}).gate.remarks)
    sound = diagnosed(MACHINE, speeds(0.0))
    assert isinstance(sound, BalanceAnswer) and sound.verdict == "adequate"


def test_friction_of_runs_at_constant_speed_is_told_without_a_model() -> None:
    def run(speed: float, seed: int) -> MotionRecord:
        level = np.sign(speed) * 0.012 * (1.0 + 0.4 * np.exp(-abs(speed) / 3.0)) + 2.5e-5 * speed
        time = np.arange(1500) * PERIOD_S
        torque = level + np.random.default_rng(seed).normal(0.0, 4e-4, time.size)
        return MotionRecord(PERIOD_S, f"run_{seed}.csv").with_columns({"motor_speed_rad_s": np.full(time.size, speed), "torque_Nm": torque})

    runs = [run(side * speed, 2 * k + (side > 0)) for k, speed in enumerate((2.0, 5.0, 20.0, 60.0, 120.0)) for side in (-1, 1)]
    bump = measured_bump(MACHINE, runs)
    assert bump is not None and (bump.slowest_rad_s, bump.least_at_rad_s) == pytest.approx((2.0, 20.0), rel=1e-6)
    truth = (0.012 * (1.0 + 0.4 * np.exp(-2.0 / 3.0)) + 5e-5) / (0.012 * (1.0 + 0.4 * np.exp(-20.0 / 3.0)) + 5e-4)
    assert bump.above_percent == pytest.approx(100.0 * (truth - 1.0), abs=0.5)
    assert measured_bump(MACHINE, runs[:4]) is None


def test_no_number_of_a_table_is_cut() -> None:
    shown = table("", "value", "unit", *(f"column {k}" for k in range(6)))
    shown.add_row("screw.viscous_Nm_s_per_rad", "Nm s/rad", *["0.000109971 .. 0.00011006"] * 6)
    caught = io.StringIO()
    with redirect_stdout(caught):
        output().print(shown)
    assert caught.getvalue().count("0.000109971 .. 0.00011006") == 6
