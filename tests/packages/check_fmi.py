"""The co-simulation units of FMI 3.0: built, held against the standard's schema, run in FMPy, and compared to the bit with what the installed tools simulate.

Run by a Python that has FMPy, after check_wheel.py, whose environment has the tools.
"""

from __future__ import annotations

import argparse
import csv
import sys
from pathlib import Path
from typing import Any

import fmpy
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu
from outside import expect, main, run

ROWS = 3000
OUTPUTS = ("position_mm", "motor_position_mm", "current_A", "voltage_V", "speed_mm_s")
CHANGED = {"screw.csj_Nm": 0.2, "screw.blk_mm": 0.05, "effects.stribeck_friction.rise": 0.3, "effects.presliding.stretch_rad": 0.05}
# What a plant without a controller is in the library: one that passes its command on.
PASS_MM = 1e11
PLANT = """
import sys
import numpy as np
from ema_tools.library.definitions import load_definitions
from ema_tools.plant.native import library
known, changed, shares = load_definitions(), eval(sys.argv[1]), np.loadtxt(sys.argv[2])
real = [row for row in known.rows if not getattr(row, "is_option", False)]
whole = [row for row in known.rows if getattr(row, "is_option", False)]
value = {row.name: row.nominal for row in known.rows}
names = {f"effects.{row.name}": row.name for effect in known.effects for row in effect.parameters}
value.update({names.get(name, name): number for name, number in changed.items()})
values = np.array([value[row.name] for row in real])
options = np.array([int(value[row.name]) for row in whole], dtype=np.int32)
found = library(64).simulate(values, options, shares * 1e11)
for row in zip(found.position_mm, found.motor_position_mm, found.current_A, found.voltage_V, found.speed_mm_s):
    print(*(float(number).hex() for number in row))
"""


class Unit:
    """An FMU in FMPy, its variables by name."""

    def __init__(self, file: Path, folder: Path, values: dict[str, float]) -> None:
        """Unpack, check, instantiate and initialise with `values`."""
        problems = validate_fmu(str(file))
        expect(not problems, f"{file.name}: {problems}")
        description = fmpy.read_model_description(str(file))
        self.reference = {variable.name: variable.valueReference for variable in description.modelVariables}
        self.said: list[str] = []
        fmpy.extract(str(file), str(folder))
        self.slave: Any = FMU3Slave(
            guid=description.guid, unzipDirectory=str(folder), modelIdentifier=description.coSimulation.modelIdentifier, instanceName="unit"
        )
        self.slave.instantiate()
        self.slave.enterInitializationMode()
        for name, value in values.items():
            self.slave.setFloat64([self.reference[name]], [value])
        self.slave.exitInitializationMode()

    def march(self, name: str, inputs: list[float], step_s: float = 1e-3) -> list[tuple[float, ...]]:
        """The outputs at each communication point, with the input that is set there."""
        wanted = [self.reference[output] for output in OUTPUTS]
        rows = []
        for k, value in enumerate(inputs):
            self.slave.setFloat64([self.reference[name]], [value])
            rows.append(tuple(self.slave.getFloat64(wanted)))
            self.slave.doStep(currentCommunicationPoint=k * step_s, communicationStepSize=step_s)
        return rows


def same(found: list[tuple[float, ...]], wanted: list[tuple[float, ...]], what: str) -> None:
    """Raises PackageError at the first row in which a bit differs."""
    expect(len(found) == len(wanted) == ROWS and len({row[0] for row in wanted}) > ROWS // 10, f"{what}: nothing moves")
    for k, (ours, theirs) in enumerate(zip(found, wanted, strict=True)):
        expect(ours == theirs, f"{what}, row {k}: the unit says {ours}, the library {theirs}")


def with_controller(unit: Path, ema: Path, work: Path) -> None:
    """Against the recording that `ema simulate` writes; states are put back; FMPy's own loop sees the same rod."""
    settings = [word for name, value in CHANGED.items() for word in ("--set", f"{name}={value}")]
    run([ema, "simulate", "reference", "--command", "chirp", "-o", "wanted.csv", *settings], work)
    with (work / "wanted.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))[:ROWS]
    wanted = [tuple(float(row[name]) for name in OUTPUTS) for row in rows]
    command = [float(row["command_mm"]) for row in rows]
    opened = Unit(unit, work / "actuator", CHANGED)
    half = opened.march("command_mm", command[: ROWS // 2])
    kept = opened.slave.getFMUState()
    later = [(k + ROWS // 2) * 1e-3 for k in range(ROWS // 2)]
    for again in range(2):
        found = []
        for now_s, value in zip(later, command[ROWS // 2 :], strict=True):
            opened.slave.setFloat64([opened.reference["command_mm"]], [value])
            found.append(tuple(opened.slave.getFloat64([opened.reference[name] for name in OUTPUTS])))
            opened.slave.doStep(currentCommunicationPoint=now_s, communicationStepSize=1e-3)
        same(half + found, wanted, f"plant with controller, {('first', 'again')[again]}")
        opened.slave.setFMUState(kept)
    opened.slave.freeFMUState(kept)
    for wrong in (1.5e-3, 0.0):
        try:
            opened.slave.doStep(currentCommunicationPoint=ROWS // 2 * 1e-3, communicationStepSize=wrong)
        except Exception as refused:
            expect("rror" in str(refused), f"a step of {wrong} s: {refused}")
        else:
            expect(False, f"a communication step of {wrong} s was taken")
    opened.slave.terminate()
    opened.slave.freeInstance()


def without_controller(unit: Path, python: Path, work: Path) -> None:
    """Against the library's model with a controller that passes its command on."""
    shares = [0.35 if (k // 400) % 2 == 0 else -0.2 for k in range(ROWS)]
    (work / "shares.txt").write_text("\n".join(map(repr, shares)), encoding="utf-8")
    passes = {"control.kp_per_m": 1e-8, "control.ki_per_m_s": 0.0, "control.kd_s_per_m": 0.0, "control.output_limit": 1.0}
    printed = run([python, "-I", "-c", PLANT, repr({**CHANGED, **passes}), work / "shares.txt"], work)
    wanted = [tuple(map(float.fromhex, line.split())) for line in printed.splitlines()]
    opened = Unit(unit, work / "plant", CHANGED)
    expect(not any(name.startswith("control.") for name in opened.reference), "the plant alone shows gains of a controller")
    same(opened.march("output_share", shares), wanted, "plant alone")
    expect(abs(wanted[300][3] - 0.35 * 24.0) < 1e-6, f"0.35 of 24 V is {wanted[300][3]} V")
    opened.slave.terminate()
    opened.slave.freeInstance()


def check(arguments: argparse.Namespace) -> str:
    """The whole way; says what was run."""
    root, work = arguments.root, arguments.work
    headers = Path(fmpy.__file__).parent / "c-code"
    build = work / "build"
    run(["cmake", "-S", root, "-B", build, "-DEMA_TESTS=OFF", "-DEMA_HOST=OFF", "-DEMA_FMI=ON", f"-DEMA_FMI_HEADERS={headers}"], work)
    run(["cmake", "--build", build, "--target", "ema_actuator_fmu", "ema_plant_fmu", "-j2"], work)
    units = {}
    for name in ("ema_actuator", "ema_plant"):
        units[name] = (build / f"fmi/{name}.fmu").rename(work / f"{name}.fmu")
    tools = Path(arguments.tools).absolute() / "bin"
    with_controller(units["ema_actuator"], tools / "ema", work)
    without_controller(units["ema_plant"], tools / "python", work)
    ran = fmpy.simulate_fmu(
        str(units["ema_actuator"]), stop_time=0.5, step_size=1e-3, start_values={"command_mm": 1.0}, output=list(OUTPUTS)
    )
    by_hand = Unit(units["ema_actuator"], work / "by_hand", {}).march("command_mm", [1.0] * 501)
    expect([tuple(map(float, row[list(OUTPUTS)])) for row in ran] == by_hand, "FMPy's own loop has other numbers")
    expect(by_hand[-1][0] > 0.5, "a command of 1 mm does not move the rod")
    return f"{ROWS} steps of both units in FMPy {fmpy.__version__}, the library's bits"


if __name__ == "__main__":
    sys.exit(main("fmi", check, "--tools"))
