"""What a diagnosis by the balance says of base values: the numbers fitted, beside what the file states, and where the two contradict each other."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from benchmarks.machines.trials import actuator_of
from ema_tools.data.actuator import FROM_RECORDS, Actuator
from ema_tools.data.motion_records import MotionRecord, write_motion_record
from ema_tools.select.base_values import BaseValue
from ema_tools.select.force_balance import improve_by_forces
from ema_tools.words.sentences.base_values import contradiction
from support import run_ema

INERTIA, VISCOUS, FRICTION = 2e-4, 1e-4, 0.03
J, B, C = "screw.inertia_kgm2", "screw.viscous_Nm_s_per_rad", "screw.csj_Nm"


def run(seed: int, motion: float = 1.0, drive: float = 1.0, rows: int = 3000) -> MotionRecord:
    """A shaft that swings, its motion and its drive recorded so many times too large."""
    time, random = np.arange(rows) * 5e-3, np.random.default_rng(seed)
    speed = 80.0 * np.sin(2.9 * time + seed) * np.sin(0.33 * time)
    torque = INERTIA * np.gradient(speed, 5e-3) + FRICTION * np.sign(speed) + VISCOUS * speed + random.normal(0.0, 5e-4, time.size)
    return MotionRecord(5e-3, f"run {seed}").with_columns({"motor_speed_rad_s": motion * speed, "torque_Nm": drive * torque})


def machine(inertia: float = INERTIA, friction: float = FRICTION, remarks: dict[str, str] | None = None) -> Actuator:
    """What a file states of that shaft."""
    return actuator_of("bare motor", 0).changed({J: inertia, B: VISCOUS, C: friction}, remarks=remarks)


def fitted(actuator: Actuator, records: list[MotionRecord]) -> dict[str, BaseValue]:
    """The base values of a diagnosis by name."""
    return {one.name: one for one in improve_by_forces(actuator, records).base}


@pytest.mark.parametrize(
    ("motion", "drive"),
    [(4.0, 1.0), *(pytest.param(*scale, marks=pytest.mark.slow) for scale in ((0.25, 1.0), (1.0, 2.0), (1.0, 1.0 / 3.0)))],
)
def test_a_scale_that_is_wrong_is_told_by_what_is_stated(motion: float, drive: float) -> None:
    records = [run(seed, motion, drive) for seed in range(3)]
    values = fitted(machine(), records)
    assert values[J].times == pytest.approx(drive / motion, rel=0.02)
    assert values[J].contradicts
    text = contradiction(tuple(values.values()), records[0])
    assert f"the inertia fitted is {values[J].times:.3g} times the stated one (95 %:" in text
    assert ("motor_speed_rad_s" in text or "torque_Nm" in text) and "screw.inertia_kgm2" in text


@pytest.mark.slow
def test_a_drive_of_another_scale_is_told_by_friction_too() -> None:
    records = [run(seed, 1.0, 3.0) for seed in range(3)]
    text = contradiction(tuple(fitted(machine(), records).values()), records[0])
    assert (
        "dry friction fitted is 3" in text and "one factor on both is one of the drive's scale" in text and "motor_speed_rad_s" not in text
    )


def test_a_file_that_is_right_is_not_contradicted() -> None:
    records = [run(seed) for seed in range(3)]
    values = fitted(machine(inertia=1.1 * INERTIA), records)
    assert contradiction(tuple(values.values()), records[0]) == ""
    low, high = values[J].interval95
    assert low is not None and high is not None and low < INERTIA < high


def test_what_the_records_hardly_show_contradicts_nothing() -> None:
    """An inertia of a machine that hardly accelerates takes up whatever else the model lacks."""
    values = {J: BaseValue(J, 1e-5, False, 1.6e-4, 1e-5, "", False, 6.76, 6.9)}
    assert values[J].hardly_seen and not values[J].contradicts


@pytest.mark.slow
def test_a_value_that_nobody_stated_contradicts_nothing() -> None:
    values = fitted(machine(friction=3.0 * FRICTION, remarks={C: FROM_RECORDS}), [run(seed) for seed in range(3)])
    assert values[C].by_import and not values[C].contradicts and np.isnan(values[C].times)
    assert fitted(machine(friction=3.0 * FRICTION), [run(seed) for seed in range(3)])[C].contradicts


@pytest.mark.slow
def test_the_command_prints_them(tmp_path: Path) -> None:
    machine(inertia=INERTIA / 4.0, remarks={C: FROM_RECORDS}).write(tmp_path / "machine.toml")
    names = [tmp_path / f"{seed}.csv" for seed in range(3)]
    for seed, name in enumerate(names):
        write_motion_record(name, run(seed))
    ran = run_ema("diagnose", tmp_path / "machine.toml", *names, "--json", tmp_path / "d.json", "--report", tmp_path / "d.html")
    assert ran.code == 0, ran.err
    told = " ".join(ran.out.split())
    assert "the inertia fitted is 4 times the stated one" in told or "the inertia fitted is 3.99 times the stated one" in told, told
    assert "screw.csj_Nm Nm not stated 0.03" in told
    result = json.loads((tmp_path / "d.json").read_text(encoding="utf-8"))
    inertia, friction = result["base"][J], result["base"][C]
    assert inertia["contradicts"] and inertia["times"] == pytest.approx(4.0, rel=0.02) and inertia["unit"] == "kg m2"
    assert friction["stated_from"] == "import" and friction["times"] is None
    assert friction["interval95"][0] < FRICTION < friction["interval95"][1]
    assert any(one["topic"] == "scale" and one["severity"] == "weakens" for one in result["gate"]["remarks"])
    page = (tmp_path / "d.html").read_text(encoding="utf-8")
    assert "Base values as fitted" in page and "not stated" in page
