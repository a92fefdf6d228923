"""`ema map`: friction against speed from runs at constant speed."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from benchmarks.machines.trials import actuator_of
from ema_tools.compare.friction_map import friction_map, model_torque_Nm
from ema_tools.data.actuator import Actuator
from ema_tools.data.motion_records import MotionRecord, write_motion_record
from support import complaint, run_ema

SPEEDS = (2.0, 5.0, 10.0, 40.0)


def machine() -> Actuator:
    return actuator_of("bare motor", 0).changed(
        {
            "screw.csj_Nm": 0.02,
            "screw.viscous_Nm_s_per_rad": 2e-4,
            "screw.load_torque_Nm": 0.004,
            "stribeck_friction.rise": 0.3,
            "stribeck_friction.speed_rad_s": 4.0,
        }
    )


def steady(speed_rad_s: float, seed: int = 0, noise_Nm: float = 3e-4) -> MotionRecord:
    """Two seconds from rest to one speed, which is kept, with the torque that the machine asks for."""
    random, time = np.random.default_rng(seed), np.arange(1000) * 2e-3
    speed = speed_rad_s * np.minimum(time / 0.5, 1.0)
    actuator = machine()
    torque = model_torque_Nm(actuator, np.where(speed == 0.0, np.sign(speed_rad_s) * 1e-9, speed))
    torque = torque + actuator["screw.inertia_kgm2"] * np.gradient(speed, 2e-3) + random.normal(0.0, noise_Nm, time.size)
    return MotionRecord(2e-3, f"at_{speed_rad_s:g}.csv").with_columns({"motor_speed_rad_s": speed, "torque_Nm": torque})


def runs() -> list[MotionRecord]:
    return [steady(side * speed, seed) for seed, (speed, side) in enumerate((speed, side) for speed in SPEEDS for side in (1.0, -1.0))]


def test_torque_of_every_speed_with_its_interval() -> None:
    found = friction_map(machine(), runs())
    kept = {
        speed: [one for one in found.points if abs(one.speed_rad_s - speed) < 0.02 * abs(speed)]
        for speed in (*SPEEDS, *(-one for one in SPEEDS))
    }
    for speed, points in kept.items():
        (point,) = points
        true = float(model_torque_Nm(machine(), np.array([speed]))[0])
        assert point.torque_Nm == pytest.approx(true, rel=0.01)
        assert point.model_Nm == pytest.approx(true, rel=0.01)
        low, high = point.interval
        assert low is not None and high is not None and low - 2e-4 < true < high + 2e-4 and high - low < 1e-3
    by_speed = {round(pair.speed_rad_s): pair for pair in found.pairs}
    for speed in SPEEDS:
        assert by_speed[round(speed)].load_Nm == pytest.approx(0.004, abs=1e-4)
    # friction falls from standstill to a minimum and rises again
    frictions = [by_speed[round(speed)].friction_Nm for speed in SPEEDS]
    assert frictions[0] > frictions[1] > frictions[2] < frictions[3]


def test_a_sign_and_a_known_disturbance_count() -> None:
    record = steady(10.0)
    pushed = record.with_columns({"torque_Nm": record.recorded("torque_Nm") + 0.01, "disturbance_Nm": np.full(record.rows, 0.01)})
    for one, other in zip(friction_map(machine(), [record]).points, friction_map(machine(), [pushed]).points, strict=True):
        assert other.torque_Nm == pytest.approx(one.torque_Nm, abs=1e-9)


def test_a_motion_without_a_constant_speed_is_refused_with_what_to_record(tmp_path: Path) -> None:
    machine().write(tmp_path / "machine.toml")
    time = np.arange(2000) * 2e-3
    swing = MotionRecord(2e-3, "swing.csv").with_columns(
        {"motor_speed_rad_s": 30.0 * np.sin(9.0 * time), "torque_Nm": 0.03 * np.sign(np.sin(9.0 * time))}
    )
    write_motion_record(tmp_path / "swing.csv", swing)
    said = complaint(run_ema("map", tmp_path / "machine.toml", tmp_path / "swing.csv"))
    assert said.startswith("map: no run at constant speed (swing.csv: no speed is kept): record runs of")


def test_the_command_writes_table_json_and_page(tmp_path: Path) -> None:
    machine().write(tmp_path / "machine.toml")
    (tmp_path / "runs").mkdir()
    for record in runs():
        write_motion_record(tmp_path / "runs" / record.file, record)
    ran = run_ema("map", tmp_path / "machine.toml", tmp_path / "runs", "--json", tmp_path / "m.json", "--report", tmp_path / "m.html")
    assert ran.code == 0, ran.err
    result = json.loads((tmp_path / "m.json").read_text(encoding="utf-8"))
    assert result["command"] == "map" and len(result["records"]) == 8 and len(result["both_ways"]) >= 4
    assert all(one["low_Nm"] <= one["torque_Nm"] <= one["high_Nm"] for one in result["points"])
    assert "Both directions" in ran.out and "Friction is" in ran.out
    page = (tmp_path / "m.html").read_text(encoding="utf-8")
    assert "<h1>Friction is " in page and 'id="law-forward"' in page and 'id="law-backward"' in page
    again = run_ema("report", tmp_path / "m.json", "-o", tmp_path / "again.html")
    assert again.code == 0, again.err
