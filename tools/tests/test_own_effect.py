"""An effect of one's own: the documented example is built outside the project's files, listed, hidden in a record, named first, added, compared and exported."""

from __future__ import annotations

import json
import os
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from ema_tools.library.definitions import library_path, load_definitions, read_definitions
from support import REFERENCE, ROOT, ema_elsewhere

EXAMPLE = ROOT / "examples" / "own_effect"
HIDDEN = {"drag_Nm_per_mm": 0.008, "start_mm": 0.5}
NOISE = "position_mm=0.002,motor_position_mm=0.002,current_A=0.03,voltage_V=0.02"
# Dry friction of healthy runs and of today's: a usual scatter.
LEVELS_NM = (0.1375, 0.1383, 0.1377, 0.1386, 0.1379)
TODAY_NM = 0.1384
Run = Callable[..., list[str]]


def test_the_ordinary_library_does_not_know_the_example() -> None:
    assert not any(effect.is_own for effect in load_definitions().effects)
    assert not any(effect.is_own for effect in load_definitions().effects)


def test_a_name_that_the_library_has_is_refused(tmp_path: Path) -> None:
    rows = (EXAMPLE / "own_effects.def").read_text().replace("scored_rod", "jam_spot")
    (tmp_path / "own_effects.def").write_text(rows)
    (tmp_path / "reads.c").write_text('#include "ema/ema_actuator.h"\n')
    own = f'-DEMA_OWN_EFFECTS="{tmp_path / "own_effects.def"}"'
    compiler = ["cc", "-std=c11", "-fsyntax-only", "-I", str(ROOT / "include"), own, str(tmp_path / "reads.c")]
    ran = subprocess.run(compiler, capture_output=True, text=True, check=False)
    assert ran.returncode != 0
    assert "jam_spot" in ran.stderr


def test_the_document_shows_the_files_as_they_are() -> None:
    text = (ROOT / "docs" / "YOUR_OWN_EFFECT.md").read_text()
    for name in ("own_effects.def", "ema_effect_scored_rod.c"):
        assert (EXAMPLE / name).read_text() in text, name


def test_a_folder_without_a_list_is_refused(tmp_path: Path) -> None:
    ran = subprocess.run(
        ["cmake", "-S", ROOT, "-B", tmp_path / "build", "-DEMA_TESTS=OFF", "-DEMA_PYTHON=OFF", f"-DEMA_OWN_EFFECTS={tmp_path}"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert ran.returncode != 0
    assert "holds no own_effects.def" in ran.stderr


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of libraries that hold the example, built as a user builds them."""
    folder = tmp_path_factory.mktemp("own")
    options = ("-DEMA_TESTS=OFF", "-DEMA_PYTHON=OFF", "-DEMA_WERROR=ON", "-DCMAKE_BUILD_TYPE=Release", f"-DEMA_OWN_EFFECTS={EXAMPLE}")
    for command in (
        ["cmake", "-S", ROOT, "-B", folder, *options],
        ["cmake", "--build", folder, "--parallel", "2", "--target", "ema_desk32", "ema_desk64"],
    ):
        ran = subprocess.run(command, capture_output=True, text=True, check=False)
        assert ran.returncode == 0, ran.stdout + ran.stderr
    return folder / "lib"


def ema_with(libraries: Path, folder: Path) -> Run:
    """Commands of `ema` with these libraries in `folder`."""
    environment = {**os.environ, "EMA_LIBRARY_DIR": str(libraries), "PYTHONPATH": str(ROOT / "tools")}
    return lambda *commands: ema_elsewhere(commands, folder, environment)


@pytest.mark.slow
def test_the_list_of_ones_own_stands_behind_the_projects(built: Path) -> None:
    found = read_definitions(built / library_path(64).name)
    assert found.effects[:-1] == load_definitions().effects
    own = found.effects[-1]
    assert own.is_own
    assert (own.name, own.site, own.size.field) == ("scored_rod", "FRICTION", "drag_Nm_per_mm")


@pytest.fixture(scope="module")
def records(built: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with five healthy records and today's, which hides the example."""
    folder = tmp_path_factory.mktemp("records")
    hidden = [part for field, value in HIDDEN.items() for part in ("--set", f"effects.scored_rod.{field}={value}")]

    def simulate(file: str, seed: int, level_Nm: float, *more: str) -> tuple[object, ...]:
        return (
            "simulate",
            REFERENCE,
            "--command",
            "chirp",
            "--noise",
            NOISE,
            "--seed",
            seed,
            "--set",
            f"screw.csj_Nm={level_Nm}",
            *more,
            "-o",
            file,
        )

    healthy = [simulate(f"healthy{place}.csv", place + 1, level) for place, level in enumerate(LEVELS_NM)]
    ema_with(built, folder)(*healthy, simulate("today.csv", 99, TODAY_NM, *hidden))
    return folder


@pytest.mark.slow
def test_the_example_is_listed_and_named_first_and_added(built: Path, records: Path) -> None:
    healthy = [part for place in range(len(LEVELS_NM)) for part in ("--healthy", f"healthy{place}.csv")]
    listed, *_ = ema_with(built, records)(
        ("effects", "scored_rod"),
        ("diagnose", REFERENCE, "today.csv", *healthy, "--json", "found.json"),
        ("add", REFERENCE, "scored_rod", "--fit", "today.csv", *healthy, "-o", "with.toml"),
        ("compare", REFERENCE, "today.csv", "--json", "before.json"),
        ("compare", "with.toml", "today.csv", "--json", "after.json"),
        ("export", "with.toml", "-o", "machine.h"),
    )
    assert "drag_Nm_per_mm" in listed
    found = json.loads((records / "found.json").read_text())
    assert found["verdict"] == "missing"
    first = found["effects"][0]
    assert first["name"] == "scored_rod"
    assert first["accepted"]
    for field, value in HIDDEN.items():
        assert first["parameters"][field] == pytest.approx(value, rel=0.05)
    assert found["error"]["after"] < 1.05 * found["error"]["floor"]
    # it stands among the others, not alone
    others = {one["name"] for one in found["effects"][1:]}
    assert "jam_spot" in others and len(others) > 5
    assert "[effects.scored_rod]" in (records / "with.toml").read_text()
    before, after = (json.loads((records / name).read_text())["balances"]["mechanical"]["rms"] for name in ("before.json", "after.json"))
    # what is left is the noise of the recorded current and position
    assert after < 0.6 * before
    assert "scored_rod" in (records / "machine.h").read_text()


@pytest.mark.slow
def test_what_to_measure_next_knows_the_example(built: Path, records: Path) -> None:
    ema_with(built, records)(("next", REFERENCE, "--between", "scored_rod", "coulomb_asymmetry", "--json", "next.json"))
    found = json.loads((records / "next.json").read_text())
    assert found["best"]["separation"] > 3.0
    assert found["sizes"]["scored_rod"]["drag_Nm_per_mm"] > 0.0
