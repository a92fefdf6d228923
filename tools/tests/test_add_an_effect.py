"""docs/ADD_AN_EFFECT.md is followed, place by place, for a new effect at each of four sites; then each is simulated, named first in a record that hides it, added and exported."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

from ema_tools.base.compiled import HAS_NUMBA
from support import ROOT, ema_elsewhere

PAGE = ROOT / "docs" / "ADD_AN_EFFECT.md"
SHOWN = "quadratic_viscous"
LIST = "include/ema/ema_effects.def"
SITE_FILE = {
    "FRICTION": "src/effects/ema_effects_friction.c",
    "TORQUE": "src/effects/ema_effects_torque.c",
    "VOLTAGE": "src/effects/ema_effects_drive.c",
    "READING": "src/effects/ema_effects_sensor.c",
}
UNIT_NAMES = "tests/checks/unit_names.txt"
NOISE = "position_mm=0.002,motor_position_mm=0.002,current_A=0.03,voltage_V=0.02"
COMMAND = "chirp:duration_s=3"
LEVELS_NM = (0.1375, 0.1383, 0.1386)
TODAY_NM = 0.1381
# What holds in C, in Python and on the page of the vectors for an effect that is smooth.
AGREES = 1e-3
LONGEST_S = 1200


@dataclass(frozen=True)
class New:
    """A new effect: what is written at each place, and the values that are hidden and found again."""

    name: str
    row: str
    c: str
    reference: str
    record: str
    hidden: dict[str, float]
    plain_names: tuple[str, ...] = ()


def c_file(name: str, arguments: str, body: str) -> str:
    """The function of an effect as the page shows it."""
    return f"""/* An effect that the tests add. */
#include "base/ema_math.h"
#include "effects/ema_effect_sites.h"

ema_real ema_effect_{name}(const ema_effect_{name}_t* effect, const ema_site_t* site{arguments})
{{
{body}
}}
"""


def reference(example: dict[str, float], function: str, arguments: str, body: str) -> str:
    """A file of `reference/effects` as the page shows it."""
    return f'''"""An effect that the tests add."""

from typing import Any

from ema_tools.base.compiled import compiled
from reference_model.point import Point

EXAMPLE = {example!r}


@compiled
def {function}(effect: Any, {arguments}point: Point) -> float:
    """What it does."""
    return {body}
'''


FRICTION = New(
    "bent_guide",
    """EMA_EFFECT(bent_guide, FRICTION, 0, 2,
           "level + drag * abs(x)",
           "a guide that binds the more, the farther the rod is from the middle",
           "jam_spot, spring_load",
           EMA_P(drag_Nm_per_mm, 0.0, 0.0, 0.5, "dry friction on top per distance from the middle"))
""",
    c_file("bent_guide", ", ema_real level_Nm", "    (void)level_Nm;\n    return effect->drag_Nm_per_mm * ema_abs(site->position_mm);"),
    reference({"drag_Nm_per_mm": 0.02}, "level_change_Nm", "level_Nm: float, ", "effect.drag_Nm_per_mm * abs(point.motor_mm)"),
    # nothing but the sentence: what the defaults give
    """from ema_tools.library.record import EffectRecord

EFFECT = EffectRecord(shows="mechanical balance: friction that grows with the distance from the middle")
""",
    {"drag_Nm_per_mm": 0.02},
)
TORQUE = New(
    "brush_drag",
    """EMA_EFFECT(brush_drag, TORQUE, 0, 4,
           "- drag * w / (abs(w) + knee)",
           "a torque that grows with speed and then no more",
           "concave_viscous, viscous_rise",
           EMA_P(drag_Nm, 0.0, 0.0, 1.0, "torque at high speed")
           EMA_P(knee_rad_s, 20.0, 1.0, 200.0, "speed of half the torque"))
""",
    c_file("brush_drag", "", "    return -effect->drag_Nm * site->speed_rad_s / (ema_abs(site->speed_rad_s) + effect->knee_rad_s);"),
    reference(
        {"drag_Nm": 0.05, "knee_rad_s": 20.0},
        "torque_Nm",
        "",
        "-effect.drag_Nm * point.speed_rad_s / (abs(point.speed_rad_s) + effect.knee_rad_s)",
    ),
    """import numpy as np

from ema_tools.library import measurements
from ema_tools.library.record import EffectRecord, Onboard, Slight, Typical
from ema_tools.library.torques import LocalTorque, shares_of_speed

EFFECT = EffectRecord(
    shows="mechanical balance: torque that grows with speed and then no more; middle speeds",
    typical=Typical({"drag_Nm": 0.01, "knee_rad_s": 20.0}, "estimate"),
    slight=Slight(0.002, of_friction=True),
    independent_shapes=4,
    local=LocalTorque(
        torque=lambda states, shape: -states.speed_rad_s / (np.abs(states.speed_rad_s) + shape["knee_rad_s"]),
        tried={"knee_rad_s": (2.0, 5.0, 10.0, 20.0, 40.0, 80.0)},
        in_balance={"knee_rad_s": shares_of_speed((0.05, 0.1, 0.2, 0.4))},
    ),
    separated_by=(measurements.CONSTANT_SPEEDS,),
    onboard=Onboard({"knee_rad_s": (5.0, 20.0, 60.0)}),
)
""",
    {"drag_Nm": 0.05, "knee_rad_s": 15.0},
)
VOLTAGE = New(
    "soft_bridge",
    """EMA_EFFECT(soft_bridge, VOLTAGE, 0, 2,
           "- softness * V * abs(V) / Vdc",
           "a bridge that gives less of a large output",
           "supply_sag",
           EMA_P(softness, 0.0, 0.0, 0.5, "share of the bus voltage that is missing at full output"))
""",
    c_file(
        "soft_bridge",
        "",
        "    return -effect->softness * site->voltage_V * ema_abs(site->voltage_V) / site->plant->drive.supply_V;",
    ),
    reference({"softness": 0.1}, "voltage_change_V", "", "-effect.softness * point.voltage_V * abs(point.voltage_V) / point.data.supply_V"),
    """from ema_tools.library import measurements
from ema_tools.library.record import EffectRecord, Typical

EFFECT = EffectRecord(
    shows="electrical balance: a share of the voltage that grows with the voltage",
    typical=Typical({"softness": 0.05}, "estimate"),
    separated_by=(measurements.BUS_AND_WINDING,),
)
""",
    {"softness": 0.1},
    ("plain softness share of the bus voltage",),
)
READING = New(
    "bowed_scale",
    """EMA_EFFECT(bowed_scale, READING, 0, 1,
           "rod sensor reads x + bow * x^2",
           "a scale that is not straight",
           "sensor_gain",
           EMA_P(bow_per_mm, 0.0, -0.1, 0.1, "error per squared distance from the middle"))
""",
    c_file("bowed_scale", "", "    return effect->bow_per_mm * site->position_mm * site->position_mm;"),
    reference({"bow_per_mm": 0.01}, "reading_mm", "", "effect.bow_per_mm * point.motor_mm * point.motor_mm"),
    """from ema_tools.library import measurements
from ema_tools.library.record import EffectRecord, Typical

EFFECT = EffectRecord(
    shows="kinematic balance: rod minus motor position with the square of the position",
    typical=Typical({"bow_per_mm": 0.002}, "estimate"),
    separated_by=(measurements.GAUGE,),
)
""",
    {"bow_per_mm": 0.01},
)
NEW = (FRICTION, TORQUE, VOLTAGE, READING)


def test_the_page_shows_the_files_as_they_are() -> None:
    text = PAGE.read_text(encoding="utf-8")
    rows = (ROOT / LIST).read_text(encoding="utf-8")
    row = rows[rows.index(f"EMA_EFFECT({SHOWN}") :]
    assert row[: row.index("\n\n")] in text
    assert SITE_FILE["TORQUE"] in text
    law = re.search(r"/\* Turbulent drag[^}]*\n}\n", (ROOT / SITE_FILE["TORQUE"]).read_text(encoding="utf-8"))
    assert law is not None and law[0] in text
    for file in (
        f"tools/reference_model/effects/{SHOWN}.py",
        f"tools/ema_tools/library/effects/{SHOWN}.py",
    ):
        assert file in text, file
        assert (ROOT / file).read_text(encoding="utf-8") in text, file


def test_the_page_names_every_field_of_a_record() -> None:
    from dataclasses import fields

    from ema_tools.library.record import EffectRecord

    text = PAGE.read_text(encoding="utf-8")
    assert not [field.name for field in fields(EffectRecord) if f"| `{field.name}` |" not in text]


def run(command: list[object], folder: Path, environment: dict[str, str] | None = None) -> str:
    """What a command prints; its complaint when it fails."""
    ran = subprocess.run(
        [str(part) for part in command], cwd=folder, env=environment, capture_output=True, text=True, check=False, timeout=LONGEST_S
    )
    assert ran.returncode == 0, ran.stdout + ran.stderr
    return ran.stdout


def follow(tree: Path, new: New) -> None:
    """What the page says, for one effect."""
    rows = tree / LIST
    text = rows.read_text(encoding="utf-8")
    end = text.index("/* Effects of one's own")
    rows.write_text(text[:end] + new.row + "\n" + text[end:], encoding="utf-8")
    with (tree / SITE_FILE[new.row.split(", ")[1]]).open("a", encoding="utf-8") as laws:
        laws.write("\n" + new.c)
    (tree / "tools" / "reference_model" / "effects" / f"{new.name}.py").write_text(new.reference, encoding="utf-8")
    (tree / "tools" / "ema_tools" / "library" / "effects" / f"{new.name}.py").write_text(f'"""New."""\n\n{new.record}', encoding="utf-8")
    with (tree / UNIT_NAMES).open("a", encoding="utf-8") as names:
        names.writelines(line + "\n" for line in new.plain_names)


@dataclass(frozen=True)
class Tree:
    """A copy of the project with the new effects, built; `python` and `ema` run its tools."""

    folder: Path
    python: Callable[..., str]
    ema: Callable[..., list[str]]


@pytest.fixture(scope="module")
def tree(tmp_path_factory: pytest.TempPathFactory) -> Tree:
    """The project's files in another folder, the page followed for all new effects, the libraries built; before that Python reads nothing of it."""
    folder = tmp_path_factory.mktemp("grown")
    listed = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    if listed.returncode != 0:
        pytest.skip("the project's files are listed by git, which does not know this folder")
    for name in listed.stdout.splitlines():
        if (ROOT / name).is_file():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(ROOT / name, folder / name)
    for new in NEW:
        follow(folder, new)
    run([sys.executable, "-B", folder / "tests" / "checks" / "check_units.py", "--root", folder], folder)
    build = folder / "build"
    options = ("-DEMA_TESTS=OFF", "-DEMA_PYTHON=OFF", "-DEMA_WERROR=ON", "-DCMAKE_BUILD_TYPE=Release")
    run(["cmake", "-S", folder, "-B", build, *options], folder)
    run(["cmake", "--build", build, "--parallel", "2", "--target", "ema_desk32", "ema_desk64"], folder)
    # the reference model is compiled for a few records: half as much optimisation is quicker, and its bits are the same
    environment = {**os.environ, "EMA_LIBRARY_DIR": str(build / "lib"), "PYTHONPATH": str(folder / "tools"), "NUMBA_OPT": "1"}
    environment.pop("EMA_DEFINITIONS", None)

    def python(*arguments: object) -> str:
        return run([sys.executable, *arguments], folder, environment)

    return Tree(folder, python, lambda *commands: ema_elsewhere(commands, folder, environment))


VECTORS = """
import sys
import numpy as np
import ema_tools
from ema_tools.data.actuator import reference_actuator
from ema_tools.plant.native import library
from reference_model.vectors.__main__ import record_entry
from reference_model.vectors.cases import CASES, CHANNELS
from reference_model.vectors.records import rows_of, samples_of
folder, agrees, *names = sys.argv[1:]
assert ema_tools.__file__.startswith(folder), ema_tools.__file__
for name in names:
    case = next(case for case in CASES if case.name == "effect_" + name)
    rows = rows_of(case)
    entry = record_entry(case)
    assert entry["effects"] == case.values and entry["shows"], entry
    with_it = library(64).simulate(*reference_actuator().changed(case.values).arrays(), samples_of(case), case.start_mm)
    without = library(64).simulate(*reference_actuator().arrays(), samples_of(case), case.start_mm)
    assert not np.array_equal(with_it.position_mm, without.position_mm), name
    for place, channel in enumerate(CHANNELS):
        apart = np.max(np.abs(getattr(with_it, channel)[:: case.every_rows] - rows[:, place]))
        assert apart <= float(agrees) * np.max(np.abs(rows[:, place])), (name, channel, apart)
"""


@pytest.mark.release
@pytest.mark.skipif(not HAS_NUMBA, reason="the reference model takes minutes a record without Numba")
def test_the_references_make_their_vectors_and_the_c_agrees(tree: Tree) -> None:
    """In one process: the reference model is compiled once."""
    tree.python("-c", VECTORS, tree.folder, AGREES, *(new.name for new in NEW))


@pytest.mark.slow
@pytest.mark.parametrize("new", NEW, ids=lambda new: new.name)
def test_a_new_effect_is_listed_simulated_named_first_added_and_exported(tree: Tree, new: New, tmp_path: Path) -> None:
    actuator, today = tree.folder / "actuators" / "reference.toml", tmp_path / "today.csv"
    model, header = tmp_path / "with.toml", tmp_path / "machine.h"

    def simulate(file: Path, seed: int, level_Nm: float, hidden: dict[str, float]) -> tuple[object, ...]:
        settings = [f"screw.csj_Nm={level_Nm}", *(f"effects.{new.name}.{field}={value}" for field, value in hidden.items())]
        sets = [part for setting in settings for part in ("--set", setting)]
        return ("simulate", actuator, "--command", COMMAND, "--noise", NOISE, "--seed", seed, *sets, "-o", file)

    runs = [tmp_path / f"healthy{place}.csv" for place in range(len(LEVELS_NM))]
    healthy = [part for file in runs for part in ("--healthy", file)]
    listed, *_ = tree.ema(
        ("effects", new.name),
        *(simulate(file, place + 1, level, {}) for place, (file, level) in enumerate(zip(runs, LEVELS_NM, strict=True))),
        simulate(today, 99, TODAY_NM, new.hidden),
        ("diagnose", actuator, today, *healthy, "--json", tmp_path / "found.json"),
        ("add", actuator, new.name, "--fit", today, *healthy, "-o", model),
        ("export", model, "-o", header),
    )
    assert "not stated" not in listed
    found = json.loads((tmp_path / "found.json").read_text(encoding="utf-8"))
    assert found["verdict"] == "missing"
    first = found["effects"][0]
    assert (first["name"], first["accepted"]) == (new.name, True)
    size = next(iter(new.hidden))
    assert first["parameters"][size] == pytest.approx(new.hidden[size], rel=0.1)
    assert f"[effects.{new.name}]" in model.read_text(encoding="utf-8")
    assert new.name in header.read_text(encoding="utf-8")
