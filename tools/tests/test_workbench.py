"""The workbench's scripts in Node: the module against the host's library, bit for bit; fits and rankings against a diagnosis; texts and the reader against Python's."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ema_tools.data.actuator import Actuator, actuator_of, read_actuator, reference_actuator
from ema_tools.data.records import Record, read_record
from ema_tools.design.typical import typical_change
from ema_tools.fit.whitening import Whitener, counted, lines_of
from ema_tools.library.definitions import Effect, load_definitions
from ema_tools.plant.native import OUTPUTS, library
from ema_tools.results.diagnosis import DiagnosisResult
from ema_tools.results.reading import read_result
from ema_tools.tasks.export import header_text
from ema_tools.tasks.several_values import noise_of_signals
from ema_tools.tasks.workbench import bench
from ema_tools.words.page import workbench
from support import RECORDINGS, ROOT, run_ema
from workbench_support import columns, in_node, model, needs_module, needs_node, packed, page_data, unpacked

TODAY = RECORDINGS / "story" / "today.csv"
UNIT = RECORDINGS / "unit" / "unit.toml"
_ROWS = 3000
_PEAK_A = 3.0


def _actuators() -> dict[str, Actuator]:
    reference = reference_actuator()
    cascade = {
        "control.structure": 1.0, "control.position_gain_per_s": 30.0, "control.speed_gain_s_per_m": 40.0, "control.speed_integral_per_m": 200.0,
        "control.every_steps": 2.0, "drive.mode": 1.0, "drive.current_scale_A": 12.0, "drive.current_loop_s": 0.002, "encoder.side": 1.0,
        "encoder.resolution_mm": 0.001, "encoder.delay_s": 0.002, "screw.load_torque_Nm": 0.02, "screw.dynamic_ratio": 0.8,
    }  # fmt: skip
    return {"reference": reference, "unit": read_actuator(UNIT), "cascade": reference.changed(cascade)}


def _with_effect(actuator: Actuator, effect: Effect) -> Actuator:
    """The actuator with three times the usual size of an effect, or with a learned table of some shape."""
    if effect.is_learned:
        nodes = {f"effects.{row.name}": 0.01 * np.sin(1.7 * place) for place, row in enumerate(effect.nodes)}
        return actuator.changed({**nodes, f"effects.{effect.size.name}": 1.0})
    values = typical_change(actuator, effect.name, _PEAK_A)
    assert values is not None
    size = f"effects.{effect.size.name}"
    return actuator.changed({**values, size: values[size] * (1.0 if effect.name == "current_limit" else 3.0)})


@needs_node
@needs_module
def test_every_effect_has_the_bits_of_the_host_library() -> None:
    command = read_record(TODAY).command_mm[:_ROWS]
    record = Record(period_s=0.001, command_mm=command, position_mm=command)
    cases = []
    for name, actuator in _actuators().items():
        cases.append((name, "none", actuator))
        cases += [(name, effect.name, _with_effect(actuator, effect)) for effect in load_definitions().effects]
    jobs: list[dict[str, Any]] = [{"kind": "simulate", "model": model(actuator), "start_mm": 0.25} for _, _, actuator in cases]
    jobs[0]["record"] = columns(record)
    plain: dict[str, bytes] = {}
    same = []
    for (name, effect, actuator), found in zip(cases, in_node(jobs), strict=True):
        host = library(32).simulate(*actuator.arrays(), command, 0.25)
        for output in OUTPUTS:
            assert unpacked(found["answer"][output]).tobytes() == getattr(host, output).tobytes(), (name, effect, output)
        bits = b"".join(getattr(host, output).tobytes() for output in OUTPUTS)
        if plain.setdefault(name, bits) == bits and effect != "none":
            same.append((name, effect))
    # an effect that were left out would have the bits of the model without it
    assert [effect for name, effect in same if name == "reference"] == []


@needs_node
@needs_module
def test_a_bad_model_is_named() -> None:
    actuator = reference_actuator()
    bad = model(actuator)
    place = load_definitions().ids["motor.resistance_ohm"]
    bad["values"][place] = -1.0
    jobs: list[dict[str, Any]] = [
        {"kind": "simulate", "model": bad, "start_mm": 0.0, "record": columns(read_record(RECORDINGS / "case_a.csv", actuator))},
        {"kind": "simulate", "model": model(actuator), "start_mm": 0.0},
        {"kind": "noise"},
    ]
    refused, after, heard = in_node(jobs)
    assert refused["offender"] == place and refused["error"] == library(32).status_text(2)
    assert "answer" in after
    assert heard["answer"] == pytest.approx(noise_of_signals(read_record(RECORDINGS / "case_a.csv", actuator)), rel=1e-12)


# Effects away from their usual values, as `ema simulate --set` takes them.
_HIDDEN = {
    "jam_spot": {"amplitude_Nm": 0.1, "place_mm": 0.4, "width_mm": 0.3},
    "stribeck_friction": {"rise": 0.3, "speed_rad_s": 20.0},
    "source_resistance": {"resistance_ohm": 0.1},
    "cogging_torque": {"amplitude_Nm": 0.02, "periods": 12.0, "phase_rad": 1.0},
    "pitch_ripple": {"ratio": 0.3, "phase_rad": 1.0},
}


def _simulated(folder: Path, effect: str) -> Path:
    noise = "position_mm=0.002,current_A=0.03,motor_position_mm=0.0005,voltage_V=0.02"
    sets = [part for field, value in _HIDDEN[effect].items() for part in ("--set", f"effects.{effect}.{field}={value}")]
    made = run_ema("simulate", "reference", "--command", "chirp", "-o", folder / "today.csv", *sets, "--noise", noise)
    assert made.code == 0, made.err
    return folder / "today.csv"


@needs_node
@needs_module
@pytest.mark.slow
@pytest.mark.parametrize("effect", ["jam_spot", "cogging_torque"])
def test_a_fit_finds_all_values_of_an_effect_from_its_usual_ones(effect: str, tmp_path: Path) -> None:
    entry = bench(reference_actuator(), read_record(_simulated(tmp_path, effect)))
    assert entry is not None
    job = page_data(entry)
    (sought,) = (one for one in job["effects"] if one["name"] == effect)
    values = list(job["data"]["model"]["values"])
    for row in sought["rows"]:
        values[row["id"]] = row["on"]
    (found,) = in_node([{**job, "kind": "fit", "rows": [*job["rows"], *sought["rows"]], "effects": [sought], "values": values}])
    fit = found["answer"]
    assert fit["error"] < 1.01 and fit["errors"] == sorted(fit["errors"], reverse=True) and fit["errors"][-1] == fit["error"]
    known = {row["field"]: fit["values"][row["id"]] for row in sought["rows"]}
    assert known == {field: pytest.approx(value, rel=0.03) for field, value in _HIDDEN[effect].items()}


@needs_node
@needs_module
@pytest.mark.slow
@pytest.mark.parametrize("effect", _HIDDEN)
def test_the_ranking_agrees_with_a_diagnosis_of_the_same_record(effect: str, tmp_path: Path) -> None:
    """In first place and error; a jam spot among all effects, the others among those that the diagnosis looked at most closely."""
    asked = run_ema("diagnose", "reference", _simulated(tmp_path, effect), "--json", tmp_path / "found.json")
    assert asked.code == 0, asked.err
    found = read_result(tmp_path / "found.json")
    assert isinstance(found, DiagnosisResult)
    assert found.workbench is not None and [one.name for one in found.effects if one.accepted] == [effect]
    job = page_data(found.workbench)
    if effect != "jam_spot":
        close = {one.name for one in found.effects[:6]}
        job["effects"] = [one for one in job["effects"] if one["name"] in close]
    (answer,) = in_node([{**job, "kind": "rank"}])
    first = answer["answer"]["ranked"][0]
    assert len(answer["answer"]["ranked"]) >= 4
    assert (first["name"], first["edge"]) == (effect, [])
    assert first["error"] == pytest.approx(found.error.after, rel=1e-4)


_CHANGES: list[dict[str, float]] = [
    {},
    {"screw.csj_Nm": 0.2, "screw.blk_mm": 0.06590185314416885},
    {"screw.csj_Nm": 0.2017943412065506, "effects.stribeck_friction.rise": 0.3, "effects.stribeck_friction.speed_rad_s": 5.0},
    {"effects.cogging_torque.amplitude_Nm": 1e-07, "effects.cogging_torque.phase_rad": -0.5, "effects.stribeck_friction.rise": 1e-5},
    {"effects.pitch_ripple.ratio": 0.0, "effects.quadratic_viscous.drag_Nm_s2_per_rad2": -1.25e-7, "motor.resistance_ohm": 1.0},
]


@needs_node
@needs_module
@pytest.mark.parametrize("file", [ROOT / "actuators" / "reference.toml", UNIT])
def test_downloads_are_what_ema_writes(file: Path) -> None:
    actuator = read_actuator(file)
    entry = bench(actuator, read_record(TODAY))
    assert entry is not None
    given = workbench.payload(entry)
    rows = [*given["rows"], *(row for effect in given["effects"] for row in effect["rows"])]
    # rows stand in the order of the lists, as they are written
    order = {name: place for place, name in enumerate(load_definitions().ids)}
    jobs = [{"kind": "texts", "toml": entry.actuator, "header": entry.header, "rows": rows, "values": changes} for changes in _CHANGES]
    for changes, found in zip(_CHANGES, in_node(jobs, module=False), strict=True):
        changed = actuator.changed(changes)
        assert found["answer"]["header"] == header_text(changed)
        text = found["answer"]["toml"]
        assert actuator_of(text, file.name) == changed
        assert text == changed.written_text(), sorted(changes, key=lambda name: order[name.removeprefix("effects.")])


@needs_node
@pytest.mark.parametrize(("rows", "channels"), [(2000, 4), (2 * 3 * 5 * 7 * 11 + 1, 3), (1155, 1)])
def test_residuals_are_weighed_as_a_diagnosis_weighs_them(rows: int, channels: int) -> None:
    """Whatever number of rows and signals: even, odd, and one of which the last row is not turned into lines."""
    draw = np.random.default_rng(rows)
    target, simulated = draw.normal(0.0, 1.0, (2, channels, rows))
    whiten = Whitener.of(draw.uniform(0.5, 2.0, (channels, lines_of(rows))), rows)
    names = ("position_mm", "motor_position_mm", "current_A", "voltage_V")[:channels]
    sent = [{name: packed(values) for name, values in zip(names, of, strict=True)} for of in (target, whiten.weights, simulated)]
    job = {"kind": "weighed", "rows": counted(rows), "target": sent[0], "weights": sent[1], "simulated": sent[2]}
    (found,) = in_node([job], module=False)
    expected = float(np.sqrt(np.sum(whiten(target - simulated) ** 2) / (channels * counted(rows))))
    assert found["answer"] == pytest.approx(expected, rel=1e-12)


@needs_node
def test_numbers_are_written_as_python_writes_them() -> None:
    numbers = [
        0.1,
        1.0,
        -2.5,
        1e-5,
        1.5e-300,
        123456789.125,
        1e16,
        123456.0,
        0.00012345678901,
        999999.9996,
        9999999995.0,
        1e22,
        5e-5,
        -0.3,
        1e5,
        1e6,
    ]
    numbers += np.random.default_rng(1).normal(0.0, 1.0, 200).tolist()
    (found,) = in_node([{"kind": "numbers", "numbers": packed(numbers)}], module=False)
    from ema_tools.tasks.export import literal

    assert found["answer"] == [[repr(value), literal(value)] for value in numbers]


def _csv(rows: int = 120, header: str = "time_s,command_mm,position_mm,current_A,note_1", change: tuple[int, str] | None = None) -> str:
    lines = [f"{0.001 * k:.3f},{0.01 * k:.6f},{0.01 * k - 0.001:.6f},{0.1 * k},7" for k in range(rows)]
    if change is not None:
        lines[change[0]] = change[1]
    return "\n".join(["# a record", header, *lines]) + "\n"


@needs_node
def test_csv_is_read_as_python_reads_it_and_refused_with_a_line_that_helps(tmp_path: Path) -> None:
    good = _csv()
    bad = {
        _csv(header="time_s,command_mm,rod,current_A,note"): "column position_mm is missing",
        _csv(header="time_s,command_mm,position_mm,position_mm,note"): "column position_mm stands there twice",
        _csv(change=(50, "0.050,x,1,2,7")): "line 53: command_mm = x: not a number",
        _csv(change=(50, "0.050,1,,2,7")): "line 53: position_mm = (empty): not a number",
        _csv(change=(50, "0.050,1,2")): "line 53: 3 fields where the header has 5",
        _csv(change=(50, "0.0555,1,1,2,7")): "line 53: time_s = 0.0555: not one period",
        _csv(rows=40): "40 rows: give at least 100",
        "": "holds no rows",
        _csv().replace("0.001,", "0.002,", 1): "not one period",
    }
    jobs: list[dict[str, Any]] = [
        {"kind": "csv", "text": text, "file": "dropped.csv", "period_s": 0.001}
        for text in (good, "\ufeff" + good.replace("\n", "\r\n"), *bad)
    ]
    jobs.append({"kind": "csv", "text": good, "file": "dropped.csv", "period_s": 0.002})
    first, second, *refused, other_rate = in_node(jobs, module=False)
    path = tmp_path / "good.csv"
    path.write_text(good, encoding="utf-8")
    record = read_record(path)
    for found in (first["answer"], second["answer"]):
        for name in record.present:
            assert unpacked(found[name]).tobytes() == record.recorded(name).tobytes(), name
        assert "note_1" not in found and "motor_position_mm" not in found
    for words, found in zip(bad.values(), refused, strict=True):
        assert found["error"].startswith("dropped.csv: ") and words in found["error"] and found["error"].count(": ") >= 2
    assert "every 0.001000 s where the actuator records every 0.002000 s" in other_rate["error"]


def test_section_holds_all_that_it_needs_or_says_why_not(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    entry = bench(reference_actuator(), read_record(TODAY))
    assert entry is not None and not re.search(r"verdict is|healthy|faulty", workbench.section(entry).split("<style>")[0])
    monkeypatch.setattr(workbench, "module_path", lambda: tmp_path / "ema.wasm")
    left_out = workbench.section(entry)
    assert "ema.wasm was not built" in left_out and "<script" not in left_out
    assert bench(replace(reference_actuator(), absent=frozenset({"control.kp_per_m"})), read_record(TODAY)) is None


@needs_module
def test_every_slider_reaches_what_is_usual_and_the_size_of_the_page_stays_small() -> None:
    actuator = reference_actuator()
    entry = bench(actuator, read_record(TODAY))
    assert entry is not None
    given = workbench.payload(entry)
    assert {effect["name"] for effect in given["effects"]} == {effect.name for effect in load_definitions().physical}
    for effect in given["effects"]:
        assert effect["ranked"] and not effect["active"]
        assert effect["rows"][0]["on"] != effect["rows"][0]["zero"], effect["name"]
        for row in effect["rows"]:
            known = load_definitions().by_name[row["name"].removeprefix("effects.")]
            assert known.lower <= row["bounds"][0] <= row["on"] <= row["bounds"][1] <= known.upper, row["name"]
    assert len(workbench.section(entry)) < 400_000
