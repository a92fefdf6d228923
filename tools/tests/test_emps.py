"""EMPS, a measured ball-screw axis: the published reference model is reproduced. Skipped where the data are not there."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from scipy import signal

from ema_tools.data.actuator import read_actuator
from ema_tools.data.emps import N_M_PER_RAD, PUBLISHED, PUBLISHED_STD, read_emps
from ema_tools.data.linear_axis import ForceModel, at_rod, to_values
from ema_tools.data.records import read_record
from support import complaint, emps_path, run_ema


@pytest.fixture(scope="module")
def imported(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("emps")
    ran = run_ema("import", "emps", emps_path(), "-o", folder)
    assert ran.code == 0, ran.err
    return folder


def published_fit(signals: dict[str, np.ndarray], gains: dict[str, float]) -> tuple[ForceModel, ForceModel, float]:
    """The published estimates, their standard errors and the relative force error, by the published steps: Butterworth of order 4 at 100 Hz on the position,
    central differences, 49 samples dropped in front, everything decimated by 10, ordinary least squares with a white residual."""
    numerator, denominator = signal.butter(4, 100.0 / 500.0)
    position = signal.filtfilt(numerator, denominator, signals["qm"], padlen=12)
    speed = np.gradient(position, 1e-3)
    columns = np.column_stack([np.gradient(speed, 1e-3), speed, np.sign(speed), np.ones_like(speed)])[49:]
    numerator, denominator = signal.cheby1(8, 0.05, 0.8 / 10.0)

    def decimated(values: np.ndarray) -> np.ndarray:
        rows = values.size
        first = 10 - (10 * -(-rows // 10) - rows) - 1
        return signal.filtfilt(numerator, denominator, values, padlen=24)[first::10]

    matrix = np.column_stack([decimated(column) for column in columns.T])
    force = decimated(gains["gtau"] * signals["vir"][49:])
    found, *_ = np.linalg.lstsq(matrix, force, rcond=None)
    residual = force - matrix @ found
    std = np.std(residual, ddof=1) * np.sqrt(np.diag(np.linalg.inv(matrix.T @ matrix)))
    return ForceModel(*found), ForceModel(*std), float(100.0 * np.linalg.norm(residual) / np.linalg.norm(force))


def test_published_numbers_come_from_the_published_steps() -> None:
    model, std, percent = published_fit(*read_emps(emps_path()))
    for name, value in PUBLISHED.as_dict().items():
        assert getattr(model, name) == pytest.approx(value, abs=1e-4)
        assert getattr(std, name) == pytest.approx(getattr(PUBLISHED_STD, name), rel=2e-3)
    assert percent == pytest.approx(4.083, abs=0.001)


def test_import_is_the_published_model(imported: Path) -> None:
    actuator = read_actuator(imported / "actuator.toml")
    model = at_rod(actuator.values, N_M_PER_RAD)
    for name, value in PUBLISHED.as_dict().items():
        assert getattr(model, name) == pytest.approx(value, rel=1e-12)
    assert 1e-3 * actuator.lead_mm_per_rad == pytest.approx(N_M_PER_RAD)
    signals, gains = read_emps(emps_path())
    assert actuator["motor.torque_constant_Nm_per_A"] * actuator["drive.current_scale_A"] / N_M_PER_RAD == pytest.approx(
        10.0 * gains["gtau"]
    )
    record = read_record(imported / "record.csv", actuator)
    assert record.rows == 24841
    assert np.array_equal(record.position_mm, 1e3 * signals["qm"])
    assert np.array_equal(record.command_mm, 1e3 * signals["qg"])
    assert np.array_equal(record.voltage_V, signals["vir"])


def test_compare_reproduces_the_published_force_error(imported: Path) -> None:
    ran = run_ema("compare", imported / "actuator.toml", imported / "record.csv", "--json", imported / "c.json")
    assert ran.code == 0, ran.err
    result = json.loads((imported / "c.json").read_text(encoding="utf-8"))
    balances = result["balances"]
    assert balances["mechanical"]["relative_percent"] == pytest.approx(4.083, abs=0.1)
    assert 1e3 * balances["controller"]["rms"] == pytest.approx(3.7, abs=0.1)
    assert balances["electrical"]["relative_percent"] is None
    assert "command" in balances["electrical"]["reason"]
    assert balances["kinematic"]["reason"] == "motor_position_mm is not recorded"
    # Closed loop: the position is nearly blind to the mechanics, the drive's command is not.
    assert result["channels"]["position_mm"]["rmse"] < 0.002
    assert 3.0 < result["channels"]["voltage_V"]["relative_percent"] < 6.0
    assert "is in the mechanical balance" in result["sentence"]


def test_calibrate_finds_the_published_values(imported: Path) -> None:
    ran = run_ema(
        "calibrate", imported / "actuator.toml", imported / "record.csv", "-o", imported / "new.toml", "--json", imported / "k.json"
    )
    assert ran.code == 0, ran.err
    result = json.loads((imported / "k.json").read_text(encoding="utf-8"))["at_rod"]
    for name, value in PUBLISHED.as_dict().items():
        assert abs(result["after"][name] - value) < 2.0 * getattr(PUBLISHED_STD, name), name
        # The residual repeats from lap to lap, so that the honest errors are larger than the published ones, which take it as white.
        assert result["std"][name] > getattr(PUBLISHED_STD, name)


@pytest.mark.slow
def test_calibrate_does_not_need_the_published_start(imported: Path) -> None:
    actuator = read_actuator(imported / "actuator.toml")
    wrong = ForceModel(mass_kg=60.0, viscous_N_s_per_m=100.0, coulomb_N=40.0, offset_N=0.0)
    actuator.changed(to_values(wrong, N_M_PER_RAD)).write(imported / "wrong.toml")
    ran = run_ema("calibrate", imported / "wrong.toml", imported / "record.csv", "-o", imported / "right.toml", "--balances-only")
    assert ran.code == 0, ran.err
    model = at_rod(read_actuator(imported / "right.toml").values, N_M_PER_RAD)
    for name, value in PUBLISHED.as_dict().items():
        assert abs(getattr(model, name) - value) < 2.0 * getattr(PUBLISHED_STD, name), name


def test_nothing_is_overwritten(imported: Path) -> None:
    assert "exists already" in complaint(run_ema("import", "emps", emps_path(), "-o", imported))


def test_other_mat_files_are_refused(tmp_path: Path) -> None:
    from scipy.io import savemat

    savemat(tmp_path / "o.mat", {"t": np.arange(3.0)})
    assert (
        complaint(run_ema("import", "emps", tmp_path / "o.mat", "-o", tmp_path / "x"))
        == "o.mat: qg: variable missing: give EMPS's own DATA_EMPS.mat"
    )
    (tmp_path / "b.mat").write_bytes(b"no")
    assert "not a readable .mat file" in complaint(run_ema("import", "emps", tmp_path / "b.mat", "-o", tmp_path / "x"))
    assert not (tmp_path / "x").exists()


def test_force_model_round_trip() -> None:
    assert at_rod(to_values(PUBLISHED, N_M_PER_RAD), N_M_PER_RAD).as_dict() == pytest.approx(PUBLISHED.as_dict())
