"""The stored reference vectors are what the reference model makes today, to the last bit."""

from __future__ import annotations

import json
import re
import struct
from pathlib import Path

import numpy as np
import pytest

from ema_tools.base.compiled import HAS_NUMBA
from ema_tools.library.definitions import load_definitions
from reference_model.random import Pcg32
from reference_model.vectors import __main__ as generator
from reference_model.vectors import parts, text
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
    per_vector = sum(map(len, made.values())) / len(made)
    assert per_vector < 64_000, f"{per_vector:.0f} bytes a file: write shorter records"
    assert max(map(len, made.values())) < 1 << 20


def stored_rows(case: Case) -> np.ndarray:
    """The float64 table of a stored file, [rows, channels]; that the reference model makes it is the test above."""
    body = (STORED / f"ema_vec_{case.name}.inc").read_text(encoding="utf-8")
    words = [int(word, 16) for word in re.findall(r"0x([0-9A-F]{16})U", body)]
    return np.array(words, dtype=np.uint64).view(np.float64).reshape(-1, len(CHANNELS))


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
    assert struct.unpack("<d", struct.pack("<Q", int(text.bits64(value)[:-1], 16)))[0] == value
    assert np.uint32(int(text.bits32(value)[:-1], 16)).view(np.float32) == np.float32(value)


def test_manifest_names_every_case_with_its_tolerance_and_why() -> None:
    manifest = json.loads((STORED / "manifest.json").read_text())
    assert [entry["name"] for entry in manifest["records"]] == [case.name for case in CASES]
    for entry in manifest["records"]:
        for precision in ("f64", "f32"):
            allowed = entry["tolerance"][precision]
            assert set(allowed["largest"]) == set(CHANNELS)
            assert all(allowed["rms"][channel] <= allowed["largest"][channel] for channel in CHANNELS)
            assert len(allowed["why"]) > 30
        body = (STORED / entry["file"]).read_text()
        assert body.count("0x") == 2 * 5 * entry["samples"]
    for entry in manifest["parts"]:
        assert "why" in json.dumps(entry), entry["name"]


def test_every_effect_and_every_block_has_a_record() -> None:
    names = {case.name for case in CASES}
    assert {f"effect_{effect.name}" for effect in load_definitions().effects} <= names
    for block in ("pid", "drive", "motor", "gearbox", "screw", "encoder", "whole"):
        assert any(name.startswith(block + "_") for name in names)


def test_settings_are_split_by_kind() -> None:
    lines = text.settings("X1", {"screw.csj_Nm": 0.3, "control.structure": 1, "spring_load.stiffness_Nm_per_mm": 2.0})
    assert lines == [
        "#define X1_OVERRIDES(X) X(screw, csj_Nm, 0.3)",
        "#define X1_OPTIONS(X) X(control, structure, 1)",
        "#define X1_EFFECTS(X) X(spring_load, stiffness_Nm_per_mm, 2.0)",
    ]
    # each literal takes the suffix of a float
    for path in STORED.glob("*.inc"):
        for literal in re.findall(r"EMA_R\(([^)]*)\)", path.read_text()):
            assert re.fullmatch(r"-?(\d+\.\d+(e[-+]\d+)?|\d+e[-+]\d+)", literal), f"{path.name}: {literal}"


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
    rows = stored_rows(case)
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
