"""Two measured machines through `ema import table`, as their users would. Skipped where the data are not there."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from ema_tools.data.actuator import read_actuator
from ema_tools.data.emps import LEAD_MM, read_emps
from ema_tools.data.motion_records import read_motion_record
from support import emps_path, lead_screw_folder, run_ema

RPM = 2.0 * np.pi / 60.0
NOMINAL_NM = 9.84e-3
# Sampling period in ms, mean speed in rpm and mean torque in % of the nominal one, as the data's own page has them; the drive counts the other way.
MEANS = {
    "2": (128.0, -28.16),
    "30": (38.4, -26.95),
    "200": (6.4, -32.63),
    "n2": (128.0, 36.13),
    "n100": (12.8, 34.59),
    "n200": (6.4, 39.89),
}


def completed_draft(folder: Path, source: Path) -> Path:
    """The draft of a lead-screw file with what its user knows."""
    path = folder / "map.toml"
    ran = run_ema("import", "draft", source, "-o", path, "--json", folder / "d.json")
    assert ran.code == 0, ran.err
    assert json.loads((folder / "d.json").read_text(encoding="utf-8"))["open"] == ["machine.inertia", "machine.nominal_torque"]
    text = path.read_text(encoding="utf-8").replace("sign = 1", "sign = -1").replace("# lead =", "lead =").replace("# ratio =", "ratio =")
    for entry, value in (("inertia", "21.86 g cm^2"), ("nominal_torque", "9.84 mNm")):
        text = text.replace(f'{entry} = "?"', f'{entry} = "{value}"')
    path.write_text(text.replace("# mass =", "mass ="), encoding="utf-8")
    return path


def test_a_folder_of_drive_files_becomes_records(tmp_path: Path) -> None:
    folder = lead_screw_folder()
    table_map = completed_draft(tmp_path, folder / "steady_state" / "2.csv")
    ran = run_ema("import", "table", folder, "--map", table_map, "-o", tmp_path / "out", "--json", tmp_path / "i.json")
    assert ran.code == 0, ran.err
    result = json.loads((tmp_path / "i.json").read_text(encoding="utf-8"))
    assert len(result["files"]) == 34
    assert all(one["remarks"] == [] and one["records"][0]["rows"] == 500 for one in result["files"])
    assert len({one["records"][0]["period_s"] for one in result["files"]}) >= 7
    for name, (step_ms, percent) in MEANS.items():
        path = tmp_path / "out" / f"{name}.csv"
        record = read_motion_record(path if path.exists() else path.with_name(f"steady_state_{name}.csv"))
        assert record.period_s == pytest.approx(1e-3 * step_ms)
        assert float(np.mean(record.recorded("torque_Nm"))) == pytest.approx(-1e-2 * percent * NOMINAL_NM, rel=1e-3)
        rpm = float(name.lstrip("n")) * (-1.0 if name.startswith("n") else 1.0)
        assert float(np.mean(record.recorded("motor_speed_rad_s"))) == pytest.approx(rpm * RPM, rel=0.1)
    actuator = read_actuator(tmp_path / "out" / "actuator.toml", complete=False)
    assert actuator["screw.lead_mm"] == 2.0
    assert actuator["screw.inertia_kgm2"] == pytest.approx(2.186e-6 + 0.18 * (2e-3 / (2.0 * np.pi)) ** 2, rel=1e-5)
    assert 0.2 * NOMINAL_NM < actuator["screw.csj_Nm"] < 0.4 * NOMINAL_NM


def test_the_wrong_sign_of_a_drive_is_told(tmp_path: Path) -> None:
    folder = lead_screw_folder()
    table_map = completed_draft(tmp_path, folder / "steady_state" / "2.csv")
    text = table_map.read_text(encoding="utf-8")
    place = text.index("[columns.torque_Nm]")
    table_map.write_text(text[:place] + text[place:].replace("sign = -1", "sign = 1"), encoding="utf-8")
    ran = run_ema("import", "table", folder, "--map", table_map, "-o", tmp_path / "out")
    assert ran.code == 1
    assert "write sign = -1 in [columns.torque_Nm] of map.toml" in ran.err
    assert not (tmp_path / "out").exists()


def test_emps_as_any_maker_s_file(tmp_path: Path) -> None:
    signals, gains = read_emps(emps_path())
    (tmp_path / "map.toml").write_text(
        f"""
[columns.time_s]
from = "t"
unit = "s"
[columns.command_mm]
from = "qg"
unit = "m"
[columns.position_mm]
from = "qm"
unit = "m"
[columns.force_N]
from = "vir"
scale = {gains["gtau"]}
unit = "N"
[machine]
name = "EMPS"
lead = "{LEAD_MM} mm"
ratio = 1
mass = "95.1 kg"
""",
        encoding="utf-8",
    )
    ran = run_ema("import", "table", emps_path(), "--map", tmp_path / "map.toml", "-o", tmp_path / "out")
    assert ran.code == 0, ran.err
    record = read_motion_record(tmp_path / "out" / "DATA_EMPS.csv")
    assert (record.period_s, record.rows) == (0.001, 24841)
    np.testing.assert_allclose(record.recorded("position_mm"), 1e3 * signals["qm"], rtol=1e-11)
    np.testing.assert_allclose(record.recorded("force_N"), gains["gtau"] * signals["vir"], rtol=1e-11)
    actuator = read_actuator(tmp_path / "out" / "actuator.toml", complete=False)
    n_m = 1e-3 * actuator["screw.lead_mm"] / (2.0 * np.pi)
    # the published dry friction is 20.4 N
    assert actuator["screw.csj_Nm"] / n_m == pytest.approx(20.4, rel=0.1)
