"""The advised commands, one after the other: no file that they write takes today's wear for the healthy state."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from ema_tools.data.actuator import read_actuator, reference_actuator
from ema_tools.data.machine_state import RecordFinding
from ema_tools.library.faults import FAULTS
from ema_tools.tasks.baseline_records import by_sheet, known_by_sheet
from support import REFERENCE, ROOT, run_ema

NOISE = "position_mm=0.002,current_A=0.03"
WORN = ("--set", "effects.source_resistance.resistance_ohm=0.15", "--set", "screw.blk_mm=0.0528")  # BLK +60 %


def recorded(folder: Path, name: str, seed: int, *changes: str, command: str = "chirp") -> str:
    ran = run_ema("simulate", REFERENCE, "--command", command, "--noise", NOISE, "--seed", seed, *changes, "-o", folder / name)
    assert ran.code == 0, ran.err
    return str(folder / name)


def test_a_model_keeps_the_healthy_csj_and_blk() -> None:
    healthy = reference_actuator()
    today = healthy.changed({"screw.csj_Nm": 0.2, "screw.blk_mm": 0.06, "effects.source_resistance.resistance_ohm": 0.15})
    written = today.keeping(healthy, FAULTS.values())
    assert {name: written[name] for name in FAULTS.values()} == {name: healthy[name] for name in FAULTS.values()}
    assert written["source_resistance.resistance_ohm"] == 0.15


@pytest.mark.slow
@pytest.mark.parametrize("baseline", [True, False], ids=["beside healthy records", "without"])
def test_the_file_with_what_was_found_ends_at_the_true_wear(tmp_path: Path, baseline: bool) -> None:
    today, found, answer = recorded(tmp_path, "today.csv", 9, *WORN), tmp_path / "found.toml", tmp_path / "answer.json"
    healthy: list[str] = []
    for seed, level in enumerate(("0.1371", "0.1375", "0.1373") if baseline else (), start=1):
        healthy += ["--healthy", recorded(tmp_path, f"healthy_{seed}.csv", seed, "--set", f"screw.csj_Nm={level}")]
    command = (
        ("diagnose", REFERENCE, today, *healthy, "--fitted", found)
        if baseline
        else ("add", REFERENCE, "source_resistance", "--fit", today, "-o", found)
    )
    ran = run_ema(*command)
    assert ran.code == 0, ran.err
    assert read_actuator(str(found))["screw.blk_mm"] == pytest.approx(0.033, rel=0.01)
    assert run_ema("identify", found, today, "--json", answer).code == 0
    result = json.loads(answer.read_text(encoding="utf-8"))
    assert result["verdict"] == "fault"
    assert result["blk_mm"]["shift_percent"] == pytest.approx(60.0, abs=2.0)


@pytest.mark.slow
@pytest.mark.parametrize("command", ["diagnose", "identify"])
def test_a_spot_in_the_model_stands_beside_healthy_records(tmp_path: Path, command: str) -> None:
    spot = {"effects.jam_spot.amplitude_Nm": 0.08, "effects.jam_spot.place_mm": 0.5, "effects.jam_spot.width_mm": 0.3}
    reference_actuator().changed(spot).write(str(tmp_path / "spot.toml"), False)
    healthy = [word for seed in (1, 2) for word in ("--healthy", recorded(tmp_path, f"healthy_{seed}.csv", seed))]
    ran = run_ema(command, tmp_path / "spot.toml", recorded(tmp_path, "today.csv", 9), *healthy)
    assert ran.code == 0, ran.err


@pytest.mark.slow
def test_the_healthy_runs_of_a_calibrated_file_serve_every_command(tmp_path: Path) -> None:
    unit, today, answer = ROOT / "recordings" / "unit", tmp_path / "hidden.csv", tmp_path / "answer.json"
    shutil.copy(unit / "hidden.csv", today)
    assert run_ema("diagnose", unit / "unit.toml", today, "--json", answer).code == 0
    result = json.loads(answer.read_text(encoding="utf-8"))
    assert [one["name"] for one in result["effects"] if one["accepted"]] == ["inverter_dead_time"]
    assert "healthy_1.csv" in result["provenance"]["healthy"]
    ran = run_ema("add", unit / "unit.toml", "inverter_dead_time", "--fit", today, "-o", tmp_path / "new.toml")
    assert ran.code == 0, ran.err
    assert read_actuator(str(tmp_path / "new.toml"))["inverter_dead_time.drop_V"] == pytest.approx(0.3, abs=0.02)


def walked(command: list[str], folder: Path) -> tuple[str, dict[str, object], int]:
    """Runs the command, then what each result advises, until `ema identify` gives a verdict: the verdict, its result, and the number of commands."""
    for count in range(1, 7):
        answer = folder / f"answer_{count}.json"
        ran = run_ema(*command[1:], "--json", answer)
        assert ran.code == 0, ran.err
        assert "Traceback" not in ran.err
        result = json.loads(answer.read_text(encoding="utf-8"))
        if result["command"] == "identify" and result["verdict"] != "undecided":
            return result["verdict"], result, count
        assert len(result["next"]) == 1, result["sentence"]
        command = result["next"][0]
        assert f"{command[0]} {command[1]}" in ran.out
    raise AssertionError(f"no verdict after six commands; the last advice is {command}")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("changes", "verdict", "blk_percent"),
    [
        (WORN, "fault", 60.0),
        (("--set", "effects.stribeck_friction.rise=0.4", "--set", "screw.blk_mm=0.0594"), "fault", 80.0),
        ((), "healthy", 0.0),
    ],
    ids=["source resistance and backlash", "stribeck friction and backlash", "healthy"],
)
def test_the_advised_commands_end_at_the_true_verdict(tmp_path: Path, changes: tuple[str, ...], verdict: str, blk_percent: float) -> None:
    healthy = [
        recorded(tmp_path, f"healthy_{seed}.csv", seed, "--set", f"screw.csj_Nm={level}")
        for seed, level in ((1, 0.1371), (2, 0.1375), (3, 0.1373))
    ]
    command = ["ema", "diagnose", str(REFERENCE), recorded(tmp_path, "today.csv", 9, *changes), "--healthy", *healthy]
    found, result, _ = walked(command, tmp_path)
    blk = result["blk_mm"]
    assert found == verdict and isinstance(blk, dict)
    assert blk["shift_percent"] == pytest.approx(blk_percent, abs=3.0)


@pytest.mark.slow
def test_two_effects_are_added_at_once_with_the_wear_beside_them(tmp_path: Path) -> None:
    changes = (
        "--set",
        "effects.source_resistance.resistance_ohm=0.15",
        "--set",
        "effects.stribeck_friction.rise=0.3",
        "--set",
        "screw.csj_Nm=0.16",
    )
    healthy = [recorded(tmp_path, f"healthy_{seed}.csv", seed) for seed in (1, 2, 3)]
    today, new, answer = recorded(tmp_path, "today.csv", 9, *changes), tmp_path / "new.toml", tmp_path / "answer.json"
    effects = ("source_resistance", "stribeck_friction")
    ran = run_ema("add", REFERENCE, *effects, "--fit", today, "--healthy", *healthy, "-o", new, "--json", answer)
    assert ran.code == 0, ran.err
    result = json.loads(answer.read_text(encoding="utf-8"))
    assert tuple(result["effects"]) == effects and result["recommended"]
    assert all(error > 2.0 * result["error"]["after"] for error in result["error_without"].values())
    assert result["parameters"]["screw.csj_Nm"]["value"] == pytest.approx(0.16, rel=0.01)
    assert read_actuator(str(new))["screw.csj_Nm"] == pytest.approx(0.138, rel=0.02)


@pytest.mark.slow
def test_the_error_after_adding_is_the_error_of_the_new_file(tmp_path: Path) -> None:
    story, new = ROOT / "recordings" / "story", tmp_path / "new.toml"
    healthy = [str(story / f"healthy_{k}.csv") for k in range(1, 4)]
    before, added, after = (tmp_path / f"{name}.json" for name in ("before", "added", "after"))
    assert run_ema("compare", REFERENCE, story / "today.csv", "--healthy", *healthy, "--json", before).code == 0
    ran = run_ema("add", REFERENCE, "stribeck_friction", "--fit", story / "today.csv", "--healthy", *healthy, "-o", new, "--json", added)
    assert ran.code == 0, ran.err
    assert run_ema("compare", new, story / "today.csv", "--json", after).code == 0
    first, told, last = (json.loads(file.read_text(encoding="utf-8"))["error"] for file in (before, added, after))
    assert last["after"] == told["after"] < 1.1 * last["floor"]
    # with today's CSJ and BLK, and all that varies, the error of the model without the effect is far above the noise
    assert first["after"] > 3.0 * told["after"]
    assert json.loads(after.read_text(encoding="utf-8"))["today"]["screw.blk_mm"] == pytest.approx(0.069, rel=0.01)


def test_what_a_data_sheet_alone_tells_is_written_as_open_beside_the_finding() -> None:
    sheet = reference_actuator()
    found = replace(sheet.changed({}), findings=(RecordFinding("today.csv", "0", "add", (("screw.csj_Nm", 0.2),)),))
    machine = by_sheet(found)
    assert machine.findings == found.findings and known_by_sheet(machine) and not known_by_sheet(found)
    assert (machine["verdict.csj_scatter_percent"], machine["screw.csj_Nm"]) == (10.0, sheet["screw.csj_Nm"])
    # what the file states stays
    stated = sheet.changed({"verdict.csj_scatter_percent": 1.0})
    assert by_sheet(stated) is stated


@pytest.mark.slow
def test_the_loop_ends_at_the_true_wear_and_leaves_what_it_did(tmp_path: Path) -> None:
    story, folder, answer = ROOT / "recordings" / "story", tmp_path / "found", tmp_path / "answer.json"
    healthy = [str(story / f"healthy_{k}.csv") for k in range(1, 4)]
    ran = run_ema("loop", REFERENCE, story / "today.csv", "--healthy", *healthy, "-o", folder, "--json", answer)
    assert ran.code == 0, ran.err
    result = json.loads(answer.read_text(encoding="utf-8"))
    assert (result["verdict"], [command[1] for command in result["commands"]]) == ("fault", ["compare", "diagnose", "add", "identify"])
    assert result["sentence"].startswith("Fault: CSJ +39.") and "BLK +100." in result["sentence"]
    machine = read_actuator(str(folder / "machine.toml"))
    assert machine.baseline is not None and machine.baseline.since == ("stribeck_friction",)
    assert (folder / "commands.txt").read_text(encoding="utf-8").count("ema ") == 4
    assert "<title>" in (folder / "report.html").read_text(encoding="utf-8")


def test_the_loop_of_a_model_that_holds_reads_the_sizes(tmp_path: Path) -> None:
    folder = tmp_path / "found"
    ran = run_ema("loop", REFERENCE, ROOT / "recordings" / "healthy.csv", "-o", folder)
    assert ran.code == 0, ran.err
    assert "Verdict after 2 commands: healthy." in ran.out and not (folder / "machine.toml").exists()
    again = run_ema("loop", REFERENCE, ROOT / "recordings" / "healthy.csv", "-o", folder)
    assert again.code == 1 and "exists already" in again.err
