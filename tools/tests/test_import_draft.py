"""What `ema import draft` takes for a drive and a motion by the names of makers: actual values before setpoints, and nothing that only looks like a drive."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest

from ema_tools.data.tables.text import split_unit
from ema_tools.data.tables.units import Units
from support import run_ema

ROWS = 400
TIME = 0.002 * np.arange(ROWS)
WAVE = np.sin(9.0 * TIME) * np.sin(2.3 * TIME)


def drafted(
    folder: Path, *names: str, still: dict[str, float] | None = None, delimiter: str = ";"
) -> tuple[dict[str, dict[str, object]], str, str]:
    """The columns of a map drafted of a file with columns of these names, each another wave; its text; what the terminal said."""
    waves = [
        np.full(ROWS, (still or {})[name]) if name in (still or {}) else (k + 1.0) * np.roll(WAVE, 17 * k) for k, name in enumerate(names)
    ]
    rows = np.column_stack([TIME, *waves]).tolist()
    lines = [delimiter.join(("Zeit [s]", *names)), *(delimiter.join(f"{value:.9g}" for value in row) for row in rows)]
    (folder / "log.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    ran = run_ema("import", "draft", folder / "log.csv", "-o", folder / "map.toml", "--force")
    assert ran.code == 0, ran.err
    text = (folder / "map.toml").read_text(encoding="utf-8")
    return tomllib.loads(text)["columns"], text, ran.out


def taken(columns: dict[str, dict[str, object]]) -> dict[str, object]:
    return {name: one["from"] for name, one in columns.items() if name != "time_s"}


def line_of(text: str, name: str) -> str:
    """The remark at a column that is used, or the line of one that is not."""
    return next(line for line in text.splitlines() if line.startswith("#   ") and f'"{name}"' in line)


PAIRS = [
    # setpoint, actual, the record's column
    ("torque demand [Nm]", "torque actual [Nm]", "torque_Nm"),
    ("Drehzahlsollwert [rpm]", "Drehzahlistwert [rpm]", "motor_speed_rad_s"),
    ("nSoll [rpm]", "nIst [rpm]", "motor_speed_rad_s"),
    ("iqref [A]", "iqmeas [A]", "current_A"),
    ("Sollstrom [A]", "Iststrom [A]", "current_A"),
    ("axis1.set.velocity [rpm]", "axis1.act.velocity [rpm]", "motor_speed_rad_s"),
    ("TargetCurrent_A", "ActualCurrent_A", "current_A"),
    ("Strom w [A]", "Strom x [A]", "current_A"),
    ("i_cmd_mA", "i_fb_mA", "current_A"),
    ("Winkel Vorgabe [deg]", "Winkel gemessen [deg]", "motor_angle_rad"),
    ("force reference [kN]", "force feedback [kN]", "force_N"),
]


@pytest.mark.parametrize("first", ["setpoint", "actual"])
@pytest.mark.parametrize(("asked", "actual", "name"), PAIRS, ids=str)
def test_the_actual_value_is_taken_beside_its_setpoint(tmp_path: Path, asked: str, actual: str, name: str, first: str) -> None:
    columns, text, _ = drafted(tmp_path, *((asked, actual) if first == "setpoint" else (actual, asked)))
    assert columns[name]["from"] == actual
    assert asked not in taken(columns).values()
    assert "a setpoint" in line_of(text, asked)


@pytest.mark.parametrize(
    ("asked", "actual"),
    [("Lagesollwert [mm]", "Lageistwert [mm]"), ("w [mm]", "x [mm]"), ("ram.cmd [mm]", "ram.pos [mm]"), ("pos_target_mm", "pos_act_mm")],
)
def test_a_setpoint_of_the_position_is_the_command(tmp_path: Path, asked: str, actual: str) -> None:
    assert taken(drafted(tmp_path, asked, actual, "F_N")[0]) == {"command_mm": asked, "position_mm": actual, "force_N": "F_N"}


def test_a_setpoint_alone_is_taken_and_said(tmp_path: Path) -> None:
    columns, text, out = drafted(tmp_path, "Drehzahl [rpm]", "Momentensollwert [Nm]")
    assert taken(columns) == {"motor_speed_rad_s": "Drehzahl [rpm]", "torque_Nm": "Momentensollwert [Nm]"}
    table = text.partition("[columns.torque_Nm]")[2]
    assert "a setpoint, and no actual value of it was recognised" in table.splitlines()[1]
    assert "torque_Nm: CHECK: a setpoint" in out
    # beside any other drive, or motion, it is none
    assert "torque_Nm" not in drafted(tmp_path, "Drehzahl [rpm]", "Momentensollwert [Nm]", "iq [A]")[0]
    assert "motor_speed_rad_s" not in drafted(tmp_path, "speed_ref_rpm", "angle_deg", "iq [A]")[0]
    assert "motor_speed_rad_s" in drafted(tmp_path, "speed_ref_rpm", "iq [A]")[0]


def test_w_alone_is_a_speed(tmp_path: Path) -> None:
    assert taken(drafted(tmp_path, "w_rads", "iq [A]")[0])["motor_speed_rad_s"] == "w_rads"


SUPPLIES = [
    "Batteriespannung [V]",
    "u_dc [V]",
    "DC-Link voltage [V]",
    "Zwischenkreisspannung [V]",
    "SupplyVoltage_V",
    "V_bus [V]",
    "battery_current_A",
    "Akku [V]",
]


@pytest.mark.parametrize("supply", SUPPLIES)
def test_a_supply_is_no_drive(tmp_path: Path, supply: str) -> None:
    columns, text, _ = drafted(tmp_path, "Winkel [deg]", supply)
    assert supply not in taken(columns).values()
    assert "of the supply and not of the motor" in line_of(text, supply)
    assert taken(drafted(tmp_path, "Winkel [deg]", supply, "Motorspannung [V]")[0])["voltage_V"] == "Motorspannung [V]"


def test_a_duty_cycle_is_proposed_as_a_share_of_the_supply_s_voltage(tmp_path: Path) -> None:
    columns, text, out = drafted(tmp_path, "Winkel [deg]", "Tastgrad [%]", "Akkuspannung [V]", still={"Akkuspannung [V]": 11.1})
    assert (columns["voltage_V"]["from"], columns["voltage_V"]["unit"]) == ("Tastgrad [%]", "%")
    assert "# PROPOSED, to be checked: a duty cycle" in text
    assert 'nominal_voltage = "?"' in text and '"11.1 V", the supply' in text
    assert "machine.nominal_voltage" in out
    # a share of one without a unit; and beside a drive it is none
    assert drafted(tmp_path, "angle_deg", "pwm_duty", still={"pwm_duty": 0.4})[0]["voltage_V"]["scale"] == 100
    assert drafted(tmp_path, "angle_deg", "pwm_duty", still={"pwm_duty": 180.0})[0]["voltage_V"]["unit"] == "?"
    assert taken(drafted(tmp_path, "angle_deg", "pwm_duty", "iq [A]")[0]) == {"motor_angle_rad": "angle_deg", "current_A": "iq [A]"}


PHASES = [
    ("i_a", "i_b", "i_c"),
    ("IU [A]", "IV [A]", "IW [A]"),
    ("Phasenstrom L1 [A]", "Phasenstrom L2 [A]"),
    ("phase current 1", "phase current 2"),
    ("ialpha_A", "ibeta_A"),
]


@pytest.mark.parametrize("phases", PHASES, ids=str)
def test_currents_of_phases_are_no_drive(tmp_path: Path, phases: tuple[str, ...]) -> None:
    columns, text, out = drafted(tmp_path, "Drehzahl [rpm]", *phases)
    assert taken(columns) == {"motor_speed_rad_s": "Drehzahl [rpm]", "current_A": "?"}
    assert "the torque-forming current Iq is needed" in text and "amplitude with the sign of the torque" in text
    assert "current_A: only phases are there" in out and "columns.current_A.from" in out and "machine.torque_constant" in out
    for wanted in ("iq_ist [A]", "torque current [A]", "momentenbildender Strom [A]"):
        columns, text, _ = drafted(tmp_path, "Drehzahl [rpm]", *phases, "i_d [A]", wanted)
        assert taken(columns)["current_A"] == wanted
        assert "it makes no torque" in line_of(text, "i_d [A]")


def test_the_current_of_an_armature_is_a_drive(tmp_path: Path) -> None:
    columns, text, _ = drafted(tmp_path, "Drehzahl [rpm]", "I_a [A]")
    assert taken(columns)["current_A"] == "I_a [A]"
    assert "where it is one phase of several" in text
    assert "where it is one phase of several" not in drafted(tmp_path, "Drehzahl [rpm]", "I [A]")[1]


def test_voltages_of_phases_are_no_drive(tmp_path: Path) -> None:
    assert taken(drafted(tmp_path, "Drehzahl [rpm]", "U_a [V]", "U_b [V]", "U_c [V]")[0])["current_A"] == "?"
    assert taken(drafted(tmp_path, "Drehzahl [rpm]", "U_a [V]")[0])["voltage_V"] == "U_a [V]"


def test_a_servo_s_pulse_is_neither_a_time_nor_a_duty_cycle(tmp_path: Path) -> None:
    columns, text, _ = drafted(tmp_path, "angle_deg", "pwm_us", "iq [A]")
    assert taken(columns) == {"motor_angle_rad": "angle_deg", "current_A": "iq [A]"} and columns["time_s"]["from"] == "Zeit [s]"
    assert "how long a pulse is" in line_of(text, "pwm_us")


def test_what_a_controller_has_still_to_make_good_is_no_motion(tmp_path: Path) -> None:
    columns, text, _ = drafted(tmp_path, "Schleppfehler [mm]", "position error [mm]", "iq [A]")
    assert taken(columns)["motor_speed_rad_s"] == "?"
    assert "make good" in line_of(text, "Schleppfehler [mm]") and "make good" in line_of(text, "position error [mm]")


@pytest.mark.parametrize(
    ("cell", "name"),
    [
        ("Kraftmessdose [N]", "disturbance_N"),
        ("load [kN]", "disturbance_N"),
        ("External Force [lbf]", "disturbance_N"),
        ("Prozesskraft [N]", "disturbance_N"),
        ("load torque [Nm]", "disturbance_Nm"),
        ("Lastmoment [Nm]", "disturbance_Nm"),
    ],
)
def test_a_load_cell_beside_a_drive_is_a_load(tmp_path: Path, cell: str, name: str) -> None:
    for drive in ("iq [A]", "Motormoment [Nm]"):
        columns, text, _ = drafted(tmp_path, "Hub [mm]", "Weg [mm]", cell, drive)
        assert columns[name]["from"] == cell
        assert not {"force_N", "disturbance_Nm", "disturbance_N"} - {name} & set(columns)
        assert "a load that another sensor measures" in text
    columns, text, _ = drafted(tmp_path, "Weg [mm]", "Kraftmessdose [N]")
    assert columns["force_N"]["from"] == "Kraftmessdose [N]" and "CHECK: a load cell" in text
    # beside another force it is a load, too
    assert taken(drafted(tmp_path, "Weg [mm]", "Kraftmessdose [N]", "motor force [N]")[0])["force_N"] == "motor force [N]"
    assert "a force beside another drive" in drafted(tmp_path, "Weg [mm]", "Kraft [N]", "iq [A]")[1]


def test_a_load_s_position_is_a_motion(tmp_path: Path) -> None:
    assert taken(drafted(tmp_path, "load position [mm]", "iq [A]")[0])["position_mm"] == "load position [mm]"


def test_an_angle_of_the_output_is_a_way_by_the_lead(tmp_path: Path) -> None:
    """Taken for the motor's, it would be as many times too small as the gear reduces."""
    found, text, said = drafted(tmp_path, "joint_pos [deg]", "motor speed [rpm]", "iq [A]")
    assert taken(found)["position_mm"] == "joint_pos [deg]" and found["position_mm"]["unit"] == "deg"
    assert 'lead = "360 mm"' in text and "turns behind the gear" in said
    assert taken(drafted(tmp_path, "motor pos [deg]", "iq [A]")[0])["motor_angle_rad"] == "motor pos [deg]"


@pytest.mark.parametrize(
    ("name", "bare", "unit"),
    [
        ("Weg/mm", "Weg", "mm"),
        ("omega/rad/s", "omega", "rad/s"),
        ("n/1/min", "n", "1/min"),
        ("t/s", "t", "s"),
        ("M/Nm", "M", "Nm"),
        ("bench/axis/U/V", "bench/axis/U", "V"),
        ("rad/s", "rad/s", ""),
        ("Lagertemperatur (F)", "Lagertemperatur", "F"),
        ("oil temp [C]", "oil temp", "C"),
        ("T_C", "T", "C"),
        ("i_c", "i_c", ""),
        ("i_d", "i_d", ""),
        ("I_C", "I_C", ""),
        ("i_A", "i", "A"),
        ("n_m", "n_m", ""),
        ("log.iq_m", "log.iq_m", ""),
        ("x_s", "x_s", ""),
        ("log.t_s", "log.t", "s"),
        ("x_m", "x", "m"),
        ("way_m", "way", "m"),
    ],
)
def test_units_of_names(name: str, bare: str, unit: str) -> None:
    assert split_unit(name, Units()) == (bare, unit)


def test_headings_of_quantity_and_unit_are_read(tmp_path: Path) -> None:
    columns, _, _ = drafted(tmp_path, "phi/rad", "n/1/min", "M/Nm", "Lagertemperatur (F)")
    assert {name: (one["from"], one["unit"]) for name, one in columns.items() if name != "time_s"} == {
        "motor_angle_rad": ("phi/rad", "rad"),
        "motor_speed_rad_s": ("n/1/min", "1/min"),
        "torque_Nm": ("M/Nm", "Nm"),
        "temperature_C": ("Lagertemperatur (F)", "F"),
    }


def test_degrees_are_never_farads() -> None:
    assert Units().converted(np.array([212.0]), "F", "temperature_C", "")[0] == pytest.approx(100.0)
    assert Units().converted(np.array([21.0]), "C", "temperature_C", "")[0] == pytest.approx(21.0)


def test_the_next_command_can_be_pasted(tmp_path: Path) -> None:
    folder = tmp_path / "bench 7 (old)"
    folder.mkdir()
    out = drafted(folder, "Drehzahl [rpm]", "iq [A]")[2]
    assert f"ema import table '{folder}/log.csv' --map '{folder}/map.toml' -o DIR" in " ".join(out.split())


def test_a_drive_that_stands_still_is_doubted(tmp_path: Path) -> None:
    assert "# DOUBTFUL: the same number in all rows" in drafted(tmp_path, "Drehzahl [rpm]", "iq [A]", still={"iq [A]": 0.0})[1]
    assert "# DOUBTFUL: the same number" in drafted(tmp_path, "Drehzahl [rpm]", "U [V]", still={"U [V]": 24.0})[1]
    assert "DOUBTFUL" not in drafted(tmp_path, "Drehzahl [rpm]", "iq [A]")[1]
