"""The stored reference vectors are what the reference model makes today, to the last bit."""

from __future__ import annotations

import re
import shutil
import struct
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from ema_tools.base.compiled import HAS_NUMBA
from ema_tools.library.definitions import load_definitions
from reference_model.random import Pcg32
from reference_model.vectors import __main__ as generator
from reference_model.vectors import parts, tables
from reference_model.vectors.cases import CASES, CHANNELS, Case
from reference_model.vectors.records import samples_of

STORED = Path(__file__).parents[2] / "tests" / "vectors"
needs_numba = pytest.mark.skipif(not HAS_NUMBA, reason="numba has no wheel here: the vectors would take many minutes")


@pytest.mark.slow
@needs_numba
def test_stored_files_are_reproduced(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.argv", ["vectors", str(tmp_path)])
    assert generator.main() == 0
    made = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    stored = {path.name: path.read_bytes() for path in STORED.iterdir()}
    assert sorted(made) == sorted(stored)
    different = [name for name in made if made[name] != stored[name]]
    assert not different, f"{different}: run python -m reference_model.vectors tests/vectors"


@cache
def stored() -> tables.Stored:
    """The stored vectors; that the reference model makes them is the test above."""
    return tables.read(STORED)


def test_stored_files_are_small() -> None:
    assert (STORED / tables.NUMBERS).stat().st_size < 1 << 19, "write shorter records"
    assert (STORED / tables.MANIFEST).read_text(encoding="utf-8").count("\n") < 500


@pytest.mark.parametrize(("offset", "message"), [(-1, "trend_beyond_said differs"), (0, "whole_healthy differs")])
def test_a_changed_number_is_refused(
    tmp_path: Path, offset: int, message: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in (tables.MANIFEST, tables.NUMBERS):
        shutil.copyfile(STORED / name, tmp_path / name)
    content = bytearray((tmp_path / tables.NUMBERS).read_bytes())
    content[offset] ^= 1
    (tmp_path / tables.NUMBERS).write_bytes(content)
    monkeypatch.setattr("sys.argv", ["tables", str(tmp_path), str(tmp_path / "made")])
    assert tables.main() == 1
    assert message in capsys.readouterr().err
    assert not (tmp_path / "made").exists()


def test_a_number_too_many_is_refused(tmp_path: Path) -> None:
    for name in (tables.MANIFEST, tables.NUMBERS):
        shutil.copyfile(STORED / name, tmp_path / name)
    with (tmp_path / tables.NUMBERS).open("ab") as numbers:
        numbers.write(bytes(8))
    with pytest.raises(ValueError, match=f"{8 + (STORED / tables.NUMBERS).stat().st_size} bytes"):
        tables.read(tmp_path)


def test_published_random_numbers() -> None:
    # O'Neill's demonstration program, seed 42 on stream 54
    random = Pcg32(42, 54)
    published = [0xA15C02B7, 0x7B47F409, 0xBA1D3330, 0x83D2F293, 0xBFA4784B, 0xCBED606E]
    assert [random.u32() for _ in published] == published


def test_uniforms_and_normals() -> None:
    uniforms = parts.uniform_draws(42, 54)
    assert uniforms[0] == ((0xA15C02B7 >> 9) + 0.5) / 2**23
    assert parts.normal_draws(42, 54)[0] == pytest.approx(sum(uniforms[:12]) - 6.0, abs=1e-15)


@pytest.mark.parametrize("value", [0.0, 1.0, -2.5, 0.1, 1e-40, 3.4e38, -1e-3])
def test_bits(value: float) -> None:
    assert struct.unpack("<d", struct.pack("<Q", int(tables.bits64(value)[:-1], 16)))[0] == value
    assert np.uint32(int(tables.bits32(value)[:-1], 16)).view(np.float32) == np.float32(value)


def test_manifest_names_every_case_with_its_tolerance_and_why() -> None:
    manifest = stored().manifest
    assert [entry["name"] for entry in manifest["records"]] == [case.name for case in CASES]
    for entry in manifest["records"]:
        for precision in ("f64", "f32"):
            allowed = manifest["tolerances"][entry["tolerance"][precision]]
            assert len(allowed["largest"]) == len(allowed["rms"]) == len(CHANNELS)
            assert all(rms <= largest for rms, largest in zip(allowed["rms"], allowed["largest"], strict=True))
            assert len(allowed["why"]) > 30
        assert len(stored().rows[entry["name"]]) == -(
            -entry["steps"] // (entry["every_rows"] * entry.get("options", {}).get("timing.record_every_steps", 1))
        )
        assert {len(row) for row in stored().rows[entry["name"]]} == {len(CHANNELS)}
    for part in ("pid", "random", "trend"):
        assert manifest[part]["why"]
    assert all(case["why"] for case in manifest["command_cases"])


@pytest.mark.parametrize("name", ["whole_healthy", "trend_even_said"])
def test_tables_hold_the_stored_numbers_in_both_precisions(name: str) -> None:
    rows = np.array(stored().rows[name])
    written = tables.texts(stored())["ema_vectors.inc" if name in {case.name for case in CASES} else "ema_vec_trend.inc"]
    array = rf"ema_vec_{name}(?:_bits)?\[{rows.shape[0]}\]\[{rows.shape[1]}\] = {{(.*?)}};"
    wide, narrow = ([int(word, 16) for word in re.findall("0x([0-9A-F]+)U", body)] for body in re.findall(array, written, re.DOTALL))
    assert np.array_equal(np.array(wide, dtype=np.uint64).view(np.float64).reshape(rows.shape), rows)
    assert np.array_equal(np.array(narrow, dtype=np.uint32).view(np.float32).reshape(rows.shape), rows.astype(np.float32))


def test_every_effect_and_every_block_has_a_record() -> None:
    names = {case.name for case in CASES}
    assert {f"effect_{effect.name}" for effect in load_definitions().effects} <= names
    for block in ("pid", "drive", "motor", "gearbox", "screw", "encoder", "whole"):
        assert any(name.startswith(block + "_") for name in names)


def test_settings_are_split_by_kind() -> None:
    kinds = generator.settings({"screw.csj_Nm": 0.3, "control.structure": 1, "spring_load.stiffness_Nm_per_mm": 2})
    assert tables.settings("X1", kinds) == [
        "#define X1_OVERRIDES(X) X(screw, csj_Nm, 0.3)",
        "#define X1_OPTIONS(X) X(control, structure, 1)",
        "#define X1_EFFECTS(X) X(spring_load, stiffness_Nm_per_mm, 2.0)",
    ]
    assert tables.settings("X1", {})[1] == "#define X1_OPTIONS(X)"
    # each literal takes the suffix of a float
    for name, content in tables.texts(stored()).items():
        for literal in re.findall(r"EMA_R\(([^)]*)\)", content):
            assert re.fullmatch(r"-?(\d+\.\d+(e[-+]\d+)?|\d+e[-+]\d+)", literal), f"{name}: {literal}"


@pytest.mark.slow
def test_control_law_inputs_are_exact_in_float32_and_saturate_sometimes() -> None:
    for case in parts.PID_CASES:
        rows = parts.pid_rows(case)
        assert np.array_equal(rows[:, :2], rows[:, :2].astype(np.float32))
        assert np.mean(np.abs(rows[:, 2]) < 0.999 * np.abs(rows[:, 2]).max()) > 0.01
    saturated = parts.pid_rows(next(case for case in parts.PID_CASES if case.name == "anti_windup"))[:, 2]
    assert 0.1 < np.mean(np.abs(saturated) == 0.5) < 0.9


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_records_show_what_they_are_for(case: Case) -> None:
    rows = np.array(stored().rows[case.name])
    position, motor, current, voltage, speed = rows.T
    name = case.name
    command = np.abs(samples_of(case)).max()
    assert np.isfinite(rows).all()
    assert np.abs(current).max() > 0.5
    stuck = name in ("motor_locked", "screw_stays")
    assert (np.abs(motor).max() == 0.0) == stuck
    if name == "pid_anti_windup":
        assert np.mean(voltage == 0.6 * 24.0) > 0.3
    if name == "drive_current_saturated":
        assert np.any(np.abs(voltage) == 24.0) and not np.all(np.abs(voltage) == 24.0)
    if name == "drive_current_limit":
        assert np.abs(current).max() == 6.0
    if name == "motor_torque_saturation":
        assert np.mean(np.abs(current) * 0.0612 > 0.35) > 0.05
    if name == "screw_coast_down":
        assert speed.max() > 0.05 and speed[-1] == 0.0 and position[-1] == position[-10]
    if name == "screw_stick_slip":
        moving = speed != 0.0
        assert np.count_nonzero(moving[1:] != moving[:-1]) > 10
    if name == "screw_backlash":
        assert np.abs(motor - position).max() == pytest.approx(0.15, abs=1e-12)
    if name == "screw_ends":
        assert np.count_nonzero(np.isclose(np.abs(motor), 1.25, atol=1e-9)) > 20
    if name.startswith(("whole", "effect")):
        assert np.abs(position).max() > 0.7 * command
