"""How a machine's numbers are told: of one that turns, behind a gear, and of one that moves along a line; and what stands first on the terminal."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.machines.trials import actuator_of
from ema_tools.base.errors import InputError
from ema_tools.data.motion_records import MotionRecord, write_motion_record
from ema_tools.library.registry import called, effect_called, named
from ema_tools.tasks.diagnose_by_balance import gates_of
from ema_tools.words.sentences.balance import along_text
from ema_tools.words.sentences.machine_units import TURNING, MachineUnits, units_of
from support import run_ema

MASS, FRICTION, LEAD_MM = 8.0, 14.0, 32.0


def linear(seed: int) -> MotionRecord:
    """A carriage on a linear motor."""
    time, random = np.arange(3000) * 4e-3, np.random.default_rng(seed)
    way = 300.0 * np.sin(1.3 * time + seed) * np.sin(0.31 * time)
    speed = np.gradient(way, 4e-3)
    force = 1e-3 * MASS * np.gradient(speed, 4e-3) + FRICTION * np.sign(speed) + 0.012 * speed + random.normal(0.0, 0.5, time.size)
    return MotionRecord(4e-3, f"run {seed}").with_columns({"position_mm": way, "force_N": force})


def test_a_swing_of_the_output_is_told_as_one() -> None:
    arm = MachineUnits(ratio=100.0)
    assert (
        arm.swing(0.01)
        == "once per turn of the output, once every 100 motor turns: the weight of what turns there, or its unbalance, is one cause"
    )
    assert arm.swing(0.02) == "2 times per turn of the output, once every 50 motor turns"
    assert arm.swing(0.2) == "once every 5 motor turns"
    assert arm.swing(1.0) == "once per motor turn" and arm.swing(4.37) == "4.37 times per motor turn"
    assert TURNING.swing(1.0 / 3.0) == "once every 3 motor turns"
    assert MachineUnits(m_per_rad=5e-3).swing(2.0) == "once every 15.7 mm"


def test_what_is_recorded_along_a_line_is_told_in_its_units() -> None:
    machine = actuator_of("linear motor", 0)
    units = units_of(machine, [linear(1)])
    assert units.m_per_rad == pytest.approx(machine["screw.lead_mm"] / (2e3 * np.pi * machine["gearbox.ratio"]))
    assert units.told(MASS * units.m_per_rad**2, "kg m2") == (pytest.approx(MASS), "kg")
    assert units.told(FRICTION * units.m_per_rad, "Nm") == (pytest.approx(FRICTION), "N")
    assert units.told(2.0, "ohm") == (2.0, "ohm")
    assert units.title("screw.inertia_kgm2") == "mass" and TURNING.title("screw.inertia_kgm2") == "screw.inertia_kgm2"
    turning = linear(1).with_columns({"position_mm": None, "motor_speed_rad_s": linear(1).recorded("position_mm")})
    assert units_of(machine, [turning]).m_per_rad is None


@pytest.mark.slow
def test_the_terminal_says_the_verdict_first_and_no_torque_of_a_linear_machine(tmp_path: Path) -> None:
    n = 1e-3 * LEAD_MM / (2.0 * np.pi)
    machine = actuator_of("linear motor", 0).changed(
        {"screw.lead_mm": LEAD_MM, "gearbox.ratio": 1.0, "screw.inertia_kgm2": MASS * n * n, "screw.csj_Nm": FRICTION * n}
    )
    machine.write(tmp_path / "machine.toml")
    names = [tmp_path / f"{seed}.csv" for seed in range(3)]
    for seed, name in enumerate(names):
        write_motion_record(name, linear(seed))
    ran = run_ema("diagnose", tmp_path / "machine.toml", *names, "--report", tmp_path / "d.html")
    assert ran.code == 0, ran.err
    assert ran.out.startswith("Verdict: adequate: no effect is missing.\n"), ran.out
    told = " ".join(ran.out.partition("Refused")[0].split())
    assert "mass kg 8" in told and "dry friction N 14" in told and "Nm" not in told and "the motor's speed" not in told, told
    assert "Held out: the last of 3 parts of the records, to which nothing of the line was fitted; it is no part of those fitted" in told
    assert ">mass<" in (tmp_path / "d.html").read_text(encoding="utf-8")


def test_a_record_that_is_too_short_is_named_once() -> None:
    short = MotionRecord(1e-5, "log1.csv").with_columns({"motor_speed_rad_s": np.sin(np.arange(1709) / 50.0), "torque_Nm": np.ones(1709)})
    with pytest.raises(InputError) as told:
        gates_of(actuator_of("bare motor", 0), [short])
    assert str(told.value).startswith("log1.csv has 1709 rows, 0.0171 s, too few for any filter: record ")
    assert str(told.value).count("log1.csv") == 1 and "whether the unit of its time is right" in str(told.value)


def test_friction_along_the_stroke_is_told_with_a_size() -> None:
    table = {"gain": 0.02, "axis": 1.0, "first": 0.0, "last": 500.0, "node_00": -1.0, "node_01": 0.5}
    assert along_text(table, TURNING) == "-0.02 to +0.01 Nm over 0 .. 500 mm"
    assert along_text(table, MachineUnits(m_per_rad=0.01)) == "-2 to +1 N over 0 .. 500 mm"
    assert all(effect_called(called(effect)) == effect for effect in named())


def test_the_help_says_what_healthy_records_serve_in_adding() -> None:
    assert "by the balance of forces ACTUATOR says what the machine is like" in " ".join(run_ema("add", "--help").out.split())
