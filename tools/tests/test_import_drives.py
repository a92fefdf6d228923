"""Drives that contradict each other, a speed that lost its sign, and a drive that drives nothing: what an import says of them, and what it leaves alone."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from support import complaint, run_ema

PERIOD_S, INERTIA, FRICTION, CONSTANT, LEAD_MM = 0.004, 3e-5, 0.05, 0.08, 4.0
ROWS = 3000
TIME = PERIOD_S * np.arange(ROWS)
MM_PER_RAD = LEAD_MM / (2.0 * np.pi)
MACHINE = f'inertia = "{INERTIA} kg m^2"\ntorque_constant = "{CONSTANT} Nm/A"\nlead = "{LEAD_MM} mm"\nratio = 1\n'
RANDOM = np.random.default_rng(5)


def bench() -> dict[str, np.ndarray]:
    """A shaft that goes both ways and rests between: speed in rad/s, torque in Nm, way of the rod in mm."""
    speed = 80.0 * np.sin(2.0 * TIME) * (np.abs(np.sin(2.0 * TIME)) > 0.2)
    torque = INERTIA * np.gradient(speed, PERIOD_S) + FRICTION * np.sign(speed) + 2e-4 * speed + RANDOM.normal(0.0, 0.002, ROWS)
    return {"t": TIME, "n": speed, "m": torque, "i": torque / CONSTANT, "x": MM_PER_RAD * np.cumsum(speed) * PERIOD_S}


def imported(
    folder: Path, columns: dict[str, np.ndarray], mapped: dict[str, tuple[str, str]], machine: str = MACHINE, more: str = ""
) -> object:
    """`ema import table`; `mapped`: the file's name and the unit of each column of the record; `more` stands below the last of them."""
    rows = np.column_stack(list(columns.values())).tolist()
    (folder / "run.csv").write_text(
        "\n".join([",".join(columns), *(",".join(f"{value:.9g}" for value in row) for row in rows)]) + "\n", encoding="utf-8"
    )
    told = "".join(f'[columns.{name}]\nfrom = "{of}"\nunit = "{unit}"\n' for name, (of, unit) in mapped.items())
    (folder / "map.toml").write_text(f"{told}{more}\n[machine]\n{machine}", encoding="utf-8")
    (folder / "i.json").unlink(missing_ok=True)
    return run_ema(
        "import", "table", folder / "run.csv", "--map", folder / "map.toml", "-o", folder / "out", "--json", folder / "i.json", "--force"
    )


def remarks(folder: Path, ran: object) -> str:
    assert ran.code == 0, ran.err  # type: ignore[attr-defined]
    return "\n".join(json.loads((folder / "i.json").read_text(encoding="utf-8"))["remarks"])


CLOCK = {"time_s": ("t", "s"), "motor_speed_rad_s": ("n", "rad/s")}
WITH_FORCE = {**CLOCK, "current_A": ("i", "A"), "force_N": ("f", "N")}


def test_two_drives_that_have_little_in_common_are_refused(tmp_path: Path) -> None:
    columns = bench()
    push = 200.0 * np.cos(7.0 * TIME) + RANDOM.normal(0.0, 5.0, ROWS)
    said = complaint(imported(tmp_path, {**columns, "f": push}, WITH_FORCE))
    assert "run.csv: force_N and current_A have little in common (correlation 0." in said
    assert "[columns.disturbance_N] in place of [columns.force_N]; else leave one of the two out of map.toml" in said
    remarks(tmp_path, imported(tmp_path, {**columns, "f": push}, WITH_FORCE, more="sure = true"))
    remarks(tmp_path, imported(tmp_path, {**columns, "f": push}, {**CLOCK, "current_A": ("i", "A"), "disturbance_N": ("f", "N")}))
    said = complaint(imported(tmp_path, {**columns, "f": push / 1000.0}, {**CLOCK, "torque_Nm": ("f", "Nm"), "current_A": ("i", "A")}))
    assert "torque_Nm and current_A have little in common" in said and "[columns.disturbance_Nm]" in said


@pytest.mark.parametrize("late", [0, 8], ids=["one clock", "32 ms late"])
def test_drives_that_agree_are_left_alone(tmp_path: Path, late: int) -> None:
    columns = bench()
    # a force behind the screw's own friction, noisy, on another clock
    force = np.roll(0.7 * columns["m"] / (1e-3 * MM_PER_RAD), late) + RANDOM.normal(0.0, 15.0, ROWS)
    remarks(tmp_path, imported(tmp_path, {**columns, "f": force}, WITH_FORCE))


def test_drives_that_are_held_tell_nothing(tmp_path: Path) -> None:
    """At constant speed both are a mean with noise of their own."""
    columns = {"t": TIME, "n": np.full(ROWS, 50.0) + RANDOM.normal(0.0, 0.3, ROWS)}
    columns |= {name: size * (1.0 + RANDOM.normal(0.0, 0.05, ROWS)) for name, size in (("i", 0.8), ("f", 100.0))}
    remarks(tmp_path, imported(tmp_path, columns, WITH_FORCE))


def test_drives_of_another_size_are_refused(tmp_path: Path) -> None:
    columns = bench()
    mapped = {**CLOCK, "torque_Nm": ("m", "Nm"), "current_A": ("i", "A")}
    remarks(tmp_path, imported(tmp_path, columns, mapped))
    said = complaint(imported(tmp_path, {**columns, "i": 10.0 * columns["i"]}, mapped))
    assert "torque_Nm is 0.1 times as large as current_A makes it" in said and "torque_constant in [machine] of map.toml" in said


VOLTS = {**CLOCK, "voltage_V": ("u", "V")}
MOTOR = MACHINE + 'back_emf = "0.08 V s/rad"\nresistance = "0.9 ohm"\n'


def volts(columns: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    return {**columns, "u": 0.9 * columns["m"] / CONSTANT + CONSTANT * columns["n"]}


def test_a_speed_that_lost_its_sign_is_told(tmp_path: Path) -> None:
    columns = volts(bench())
    unsigned = {**columns, "n": np.abs(columns["n"])}
    remarks(tmp_path, imported(tmp_path, columns, VOLTS, MOTOR))
    said = complaint(imported(tmp_path, unsigned, VOLTS, MOTOR))
    assert "run.csv: motor_speed_rad_s never changes its sign while voltage_V turns round from motion to motion: its sign was lost" in said
    assert "give it the sign of voltage_V in the file, or write sure = true in [columns.motor_speed_rad_s]" in said
    driven = {**CLOCK, "current_A": ("i", "A")}
    assert "while current_A turns round" in complaint(imported(tmp_path, unsigned, driven))
    # counted the other way it is none either; where a position is there it says the sign
    assert "never changes its sign" in complaint(imported(tmp_path, {**columns, "n": -np.abs(columns["n"])}, VOLTS, MOTOR))
    said = complaint(imported(tmp_path, unsigned, {**driven, "position_mm": ("x", "mm")}))
    assert "or leave out [columns.motor_speed_rad_s] of map.toml: it is then made of position_mm" in said
    assert "the sign of the way of command_mm" in complaint(imported(tmp_path, unsigned, {**driven, "command_mm": ("x", "mm")}))


def test_a_machine_that_goes_one_way_and_brakes_keeps_its_speed(tmp_path: Path) -> None:
    speed = 80.0 * np.sin(2.0 * TIME) ** 2
    # braking asks for as much torque as speeding up, but for the friction
    torque = 20.0 * INERTIA * np.gradient(speed, PERIOD_S) + FRICTION * np.sign(speed)
    assert float(np.mean(torque < 0.0)) > 0.2
    columns = volts({"t": TIME, "n": speed, "m": torque, "i": torque / CONSTANT})
    for mapped, machine in ((VOLTS, MOTOR), ({**CLOCK, "current_A": ("i", "A")}, MACHINE)):
        remarks(tmp_path, imported(tmp_path, columns, mapped, machine.replace(f"{INERTIA}", f"{20.0 * INERTIA}")))


def test_a_drive_that_overcomes_no_friction_is_doubted(tmp_path: Path) -> None:
    columns = volts(bench())
    assert "no friction at all" not in remarks(tmp_path, imported(tmp_path, columns, VOLTS, MOTOR))
    # a supply under load is no motor's voltage
    sagging = {**columns, "u": 24.0 - 0.02 * np.abs(columns["i"]) - 0.01 * columns["n"]}
    said = remarks(tmp_path, imported(tmp_path, sagging, VOLTS, MOTOR))
    assert "the records show no friction at all, neither dry nor viscous: voltage_V is doubtful as the drive" in said
    assert "check from, unit and sign in [columns.voltage_V]" in said
    said = remarks(tmp_path, imported(tmp_path, {**columns, "u": np.full(ROWS, 24.0)}, VOLTS, MOTOR))
    assert "voltage_V is 24 in all rows, and no other drive is recorded: doubtful" in said


def test_stamps_that_stray_by_a_digit_lose_no_row(tmp_path: Path) -> None:
    columns = bench()
    stamps = np.round(1000.0 * TIME)
    stamps[[700, 1900]] += 1.0
    clock = {"time_s": ("t", "ms"), "motor_speed_rad_s": ("n", "rad/s"), "torque_Nm": ("m", "Nm")}
    ran = imported(tmp_path, {**columns, "t": stamps}, clock)
    assert ran.code == 0, ran.err  # type: ignore[attr-defined]
    told = json.loads((tmp_path / "i.json").read_text(encoding="utf-8"))["files"][0]["remarks"]
    assert told == ["the stamps of time are rounded: put on an even rate of 0.004 s"]
