"""Import of EMPS, a measured ball-screw axis: its `.mat` becomes a recording and an actuator with the published reference model.

Source: A. Janot, M. Gautier, M. Brunot, "Data Set and Reference Models of EMPS", Workshop on Nonlinear System Identification Benchmarks,
Eindhoven 2019. A linear axis is a rotary one with n = lead / (2 pi): inertia M n^2, torque F n.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.base.errors import InputError
from ema_tools.base.files import may_write, readable, reason
from ema_tools.data.actuator import AT_ROW, COMMAND_ACTS, Actuator, reference_actuator
from ema_tools.data.linear_axis import ForceModel, to_values
from ema_tools.data.records import Record, write_record

LEAD_MM = 2.5
N_M_PER_RAD = 1e-3 * LEAD_MM / (2.0 * math.pi)
OUTPUT_LIMIT_V = 10.0


PUBLISHED = ForceModel(mass_kg=95.1089, viscous_N_s_per_m=203.5034, coulomb_N=20.3935, offset_N=-3.1648)
# Standard errors of the published estimates: the published program's own formula (ordinary least squares, residual taken as white) on the published record.
PUBLISHED_STD = ForceModel(mass_kg=0.1085, viscous_N_s_per_m=1.1460, coulomb_N=0.1012, offset_N=0.0444)
_SIGNALS = ("t", "qg", "qm", "vir")
_GAINS = ("gtau", "kp", "kv")


def read_emps(path: str | Path) -> tuple[dict[str, Reals], dict[str, float]]:
    """Signals t s, qg m, qm m, vir V, each [rows], and the gains gtau N/V, kp 1/s, kv V s/m.

    Raises InputError that names the file and the variable.
    """
    from scipy.io import loadmat
    from scipy.io.matlab import MatReadError

    file = readable(Path(path).name)
    try:
        content = loadmat(path)
    except FileNotFoundError as error:
        raise InputError(f"{path}: {reason(error)}: check the path") from None
    except (MatReadError, ValueError, TypeError, NotImplementedError, EOFError, OSError):
        raise InputError(f"{file}: not a readable .mat file: give EMPS's own DATA_EMPS.mat") from None
    for name in (*_SIGNALS, *_GAINS):
        if name not in content:
            raise InputError(f"{file}: {name}: variable missing: give EMPS's own DATA_EMPS.mat")
    signals = {name: np.asarray(content[name], dtype=np.float64).ravel() for name in _SIGNALS}
    gains = {name: float(np.asarray(content[name]).ravel()[0]) for name in _GAINS}
    rows = signals["t"].size
    for name, values in signals.items():
        if values.size != rows or not np.isfinite(values).all():
            raise InputError(f"{file}: {name}: not {rows} finite numbers: give EMPS's own DATA_EMPS.mat")
    return signals, gains


def emps_record(signals: dict[str, Reals], file: str) -> Record:
    """The recording: command and position in mm, the controller's output as voltage_V."""
    period_s = float((signals["t"][-1] - signals["t"][0]) / (signals["t"].size - 1))
    return Record(
        period_s=round(period_s, 9),
        command_mm=1e3 * signals["qg"],
        position_mm=1e3 * signals["qm"],
        voltage_V=signals["vir"],
        file=file,
    )


def emps_actuator(gains: dict[str, float], period_s: float, file: str) -> Actuator:
    """The axis with its controller and the published reference model."""
    values = {
        "control.structure": 1.0,
        "control.average_speed": 1.0,
        "control.kp_per_m": 0.0,
        "control.ki_per_m_s": 0.0,
        "control.anti_windup_per_s": 0.0,
        "control.position_gain_per_s": gains["kp"],
        "control.speed_gain_s_per_m": gains["kv"] / OUTPUT_LIMIT_V,
        "drive.mode": 1.0,
        # One "ampere" per volt of command: the amplifier's own scale is not published, only force per volt.
        "drive.current_scale_A": OUTPUT_LIMIT_V,
        "drive.command_scale_V": OUTPUT_LIMIT_V,
        "drive.current_loop_s": 0.0,
        "motor.torque_constant_Nm_per_A": gains["gtau"] * N_M_PER_RAD,
        "motor.back_emf_V_s_per_rad": 0.0,
        "motor.inductance_H": 0.0,
        "motor.torque_limit_Nm": 0.0,
        "gearbox.ratio": 1.0,
        "screw.lead_mm": LEAD_MM,
        "screw.blk_mm": 0.0,
        "screw.travel_mm": 500.0,
        "encoder.side": 1.0,
        "timing.step_s": period_s,
        # Two steps of the encoder, 50000 per turn.
        "verdict.position_noise_mm": 2.0 * LEAD_MM / 50000.0,
        "search.csj_lower_Nm": 0.2 * PUBLISHED.coulomb_N * N_M_PER_RAD,
        "search.csj_upper_Nm": 10.0 * PUBLISHED.coulomb_N * N_M_PER_RAD,
        "search.blk_upper_mm": 0.1,
        **to_values(PUBLISHED, N_M_PER_RAD),
    }
    about = {
        "name": "EMPS ball-screw axis",
        "notes": (
            "Rotary form of a linear axis: n = lead / (2 pi), inertia = M n^2, torque = F n. Published reference model: "
            f"M {PUBLISHED.mass_kg} kg, Fv {PUBLISHED.viscous_N_s_per_m} N s/m, Fc {PUBLISHED.coulomb_N} N, offset {PUBLISHED.offset_N} N. "
            f"The command drives a current amplifier, force = {gains['gtau']:.5f} N/V; one ampere here is one volt of command."
        ),
        "source": "A. Janot, M. Gautier, M. Brunot, Data Set and Reference Models of EMPS, Workshop on Nonlinear System Identification Benchmarks, Eindhoven 2019",
    }
    return Actuator(values=reference_actuator().changed(values).values, about=about, file=file)


@dataclass(frozen=True)
class Imported:
    """What an import wrote."""

    actuator_path: Path
    record_path: Path
    actuator: Actuator
    record: Record


def targets(folder: str | Path) -> tuple[Path, Path]:
    """The actuator and the recording that an import writes to `folder`."""
    return Path(folder) / "actuator.toml", Path(folder) / "record.csv"


def import_emps(path: str | Path, folder: str | Path, force: bool = False) -> Imported:
    """Write `folder`/actuator.toml and `folder`/record.csv. Raises InputError as `read_emps`, and when a file exists and `force` is not set."""
    signals, gains = read_emps(path)
    file = readable(Path(path).name)
    record = emps_record(signals, file)
    # the published model takes the command of a row as acting at that row
    actuator = emps_actuator(gains, record.period_s, file).changed({}, about={COMMAND_ACTS: AT_ROW})
    actuator_path, record_path = targets(folder)
    for target in (actuator_path, record_path):
        may_write(target, force)
    actuator.write(actuator_path, force)
    comments = (
        f"EMPS, a measured ball-screw axis, from {file}: qg as command_mm, qm as position_mm, vir as voltage_V.",
        "voltage_V is the controller's output, which commands a current amplifier; the current itself was not recorded.",
        f"Cite: {actuator.about['source']}.",
    )
    write_record(record_path, record, comments, force)
    return Imported(actuator_path, record_path, actuator, record)
