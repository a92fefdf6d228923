"""A machine's run, and the same run as many makers would write it."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas
from scipy.io import savemat

RPM = 2.0 * np.pi / 60.0
INERTIA, VISCOUS, FRICTION, LOAD = 3e-6, 2e-5, 4e-3, 1e-3


def run(rows: int = 400, period_s: float = 0.005) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Time s, speed rad/s and torque Nm of a machine that goes both ways, [rows] each."""
    time_s = period_s * np.arange(rows)
    phase = 2.0 * np.pi * 1.3 * time_s
    speed = 40.0 * np.sin(phase) + 12.0 * np.sin(2.7 * phase)
    torque = INERTIA * np.gradient(speed, period_s) + VISCOUS * speed + FRICTION * np.sign(speed) + LOAD
    return time_s, np.round(speed / RPM, 6) * RPM, np.round(torque, 9)


def columns(rows: int = 400) -> dict[str, np.ndarray]:
    """The run with the names and units of a maker: ms, rpm, mNm."""
    time_s, speed, torque = run(rows)
    return {"Time [ms]": np.round(1e3 * time_s, 6), "Motor speed [rpm]": speed / RPM, "Torque [mNm]": 1e3 * torque}


def text(delimiter: str = ",", decimal: str = ".", preamble: str = "", two_rows: bool = False, end: str = "\n", rows: int = 400) -> str:
    """The run as text."""
    found = columns(rows)
    names = list(found)
    lines = [delimiter.join(names)]
    if two_rows:
        lines = [
            delimiter.join(name.partition(" [")[0] for name in names),
            delimiter.join(name.partition("[")[2].rstrip("]") for name in names),
        ]
    for row in np.column_stack(list(found.values())).tolist():
        lines.append(delimiter.join(f"{value:.9g}".replace(".", decimal) for value in row))
    return preamble + end.join(lines) + end


MAP = """
[columns.time_s]
from = "Time [ms]"
unit = "ms"
[columns.motor_speed_rad_s]
from = "Motor speed [rpm]"
unit = "rpm"
[columns.torque_Nm]
from = "Torque [mNm]"
unit = "mNm"
"""
# Of files whose names carry no unit.
PLAIN_MAP = MAP.replace(" [ms]", "").replace(" [rpm]", "").replace(" [mNm]", "")
_PREAMBLE = 'Date:;2020-07-08 21:28:28\nSampling period:;5.000\nScale:;0;True;2.000;6.000\n"Trigger:;1;""Parameter values"""\n\n'


def _plain() -> dict[str, np.ndarray]:
    return {name.partition(" [")[0]: values for name, values in columns().items()}


def _mat(path: Path) -> None:
    time, speed, torque = columns().values()
    savemat(path, {"log": {"t": time, "n": speed.reshape(-1, 1), "rest": {"torque": torque}}, "gain": 35.1})


def _npz(path: Path) -> None:
    np.savez(path, **_plain(), Ts=0.005)


def _text(content: str, encoding: str) -> Callable[[Path], None]:
    return lambda path: path.write_bytes(content.encode(encoding)) and None


# Name of a file: how it is written, and its map.
FORMATS: dict[str, tuple[Callable[[Path], None], str]] = {
    "comma.csv": (_text(text(), "utf-8"), MAP),
    "bom.csv": (_text(text(), "utf-8-sig"), MAP),
    "semicolon_comma.csv": (_text(text(";", ",", end="\r\n"), "utf-8"), MAP),
    "tab_comma.txt": (_text(text("\t", ","), "utf-8"), MAP),
    "tab.tsv": (_text(text("\t"), "utf-16"), MAP),
    "old_mac.csv": (_text(text(end="\r"), "utf-8"), MAP),
    "bar.txt": (_text(text("|", preamble="recorded by hand\n" * 40), "utf-8"), MAP),
    "spaces.dat": (_text(text("  ", preamble="% température 20 °C\n"), "cp1252"), MAP),
    "trailing.csv": (_text(text(";", ",").replace("\n", ";\n"), "utf-8"), MAP),
    "utf16_be.csv": (_text(text(";", ","), "utf-16-be"), MAP),
    "quoted_comma.csv": (
        _text("\n".join(",".join(f'"{cell}"' for cell in line.split(";")) for line in text(";", ",").splitlines()), "utf-8"),
        MAP,
    ),
    "two_rows.csv": (_text(text(";", preamble=_PREAMBLE, two_rows=True, end="\r\n"), "utf-8"), PLAIN_MAP),
    "footer.csv": (_text(text(";", preamble=_PREAMBLE, two_rows=True) + "\nEnd of record\n", "utf-8"), PLAIN_MAP),
    "struct.mat": (
        _mat,
        MAP.replace("Time [ms]", "log.t").replace("Motor speed [rpm]", "log.n").replace("Torque [mNm]", "log.rest.torque"),
    ),
    "array.npz": (_npz, PLAIN_MAP),
    "frame.parquet": (lambda path: pandas.DataFrame(columns()).to_parquet(path), MAP),
    "lists.json": (lambda path: path.write_text(json.dumps({name: values.tolist() for name, values in columns().items()})) and None, MAP),
    "records.json": (
        lambda path: path.write_text(pandas.DataFrame(columns()).to_json(orient="records", double_precision=15)) and None,
        MAP,
    ),
    "split.json": (lambda path: path.write_text(pandas.DataFrame(columns()).to_json(orient="split", double_precision=15)) and None, MAP),
    "by_row.json": (lambda path: path.write_text(pandas.DataFrame(columns()).to_json(double_precision=15)) and None, MAP),
    "lines.jsonl": (
        lambda path: path.write_text(pandas.DataFrame(columns()).to_json(orient="records", lines=True, double_precision=15)) and None,
        MAP,
    ),
    "nested.json": (
        lambda path: (
            path.write_text(json.dumps({"device": "x", "data": {name: values.tolist() for name, values in columns().items()}})) and None
        ),
        MAP.replace('from = "', 'from = "data.'),
    ),
}
