"""Identification through the onboard session, from Python."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ema_tools.base.errors import InputError
from ema_tools.data.actuator import read_actuator, reference_actuator
from ema_tools.data.records import Record, read_record, write_record
from ema_tools.plant.native import SearchSettings
from ema_tools.results.codec import to_json
from ema_tools.tasks.identify import identify
from ema_tools.tasks.onboard_search import weight_of
from ema_tools.words.answers.identification import identification
from ema_tools.words.sentences.identification import sentence
from support import RECORDINGS, REFERENCE, chirp_record, complaint, run_ema


@settings(max_examples=15)
@given(csj=st.floats(0.05, 0.5), blk=st.floats(0.01, 0.09))
def test_what_was_simulated_is_identified(csj: float, blk: float) -> None:
    record = chirp_record(reference_actuator().changed({"screw.csj_Nm": csj, "screw.blk_mm": blk}), bits=32)
    found = identify(reference_actuator(), record, guarding=False).answer
    assert found.identified[0].estimate == pytest.approx(csj, abs=1e-4 * 0.138)
    assert found.identified[1].estimate == pytest.approx(blk, abs=1e-4 * 0.033)
    assert found.evaluations <= 410


@pytest.mark.parametrize(
    ("case", "csj", "blk", "verdict"),
    [
        pytest.param("a", 0.3, 0.04125, "fault", marks=pytest.mark.slow),
        pytest.param("b", 0.1449, 0.066, "fault", marks=pytest.mark.slow),
        ("c", 0.13938, 0.03333, "healthy"),
    ],
)
def test_independent_records_are_identified(case: str, csj: float, blk: float, verdict: str) -> None:
    record = read_record(RECORDINGS / f"case_{case}.csv", reference_actuator())
    found = identify(reference_actuator(), record)
    answer = found.answer
    assert found.verdict == verdict
    assert answer.identified[0].estimate == pytest.approx(csj, abs=5e-4 * 0.138)
    assert answer.identified[1].estimate == pytest.approx(blk, abs=5e-3 * 0.033)
    assert answer.verdict == verdict
    assert answer.adequate


@pytest.mark.slow
def test_result_has_the_keys_that_programs_read(tmp_path: Path) -> None:
    ran = run_ema(
        "identify",
        REFERENCE,
        RECORDINGS / "case_a_noisy.csv",
        "--json",
        tmp_path / "i.json",
        "--fitted",
        tmp_path / "f.toml",
        "--seeds",
        "3",
    )
    assert ran.code == 0, ran.err
    assert ran.out.startswith("Fault: CSJ +117.")
    assert "over 3 seeds" in ran.out
    result = json.loads((tmp_path / "i.json").read_text(encoding="utf-8"))
    for key in ("csj_Nm", "blk_mm"):
        assert {"estimate", "std", "shift_percent", "bias"} <= set(result[key])
        # of a model that is adequate, what lasts in the residual is small beside the noise
        assert 0.0 <= result[key]["bias"] < 3.0 * result[key]["std"]
    assert result["csj_Nm"]["shift_percent"] == pytest.approx(117.39, abs=0.2)
    assert result["blk_mm"]["shift_percent"] == pytest.approx(25.0, abs=3.0 * 100.0 * result["blk_mm"]["std"] / 0.033)
    assert result["objective_before_mm2s"] == pytest.approx(0.675, abs=0.005)
    assert result["objective_after_mm2s"] < 3e-4
    assert result["verdict"] == "fault"
    assert result["adequate"] is True
    assert result["reasons"] == []
    assert len(result["seeds"]) == 2
    assert min(result["search"]["cost_mm2s"]) == pytest.approx(result["objective_after_mm2s"], rel=1e-3)
    fitted = read_actuator(tmp_path / "f.toml")
    # today's wear is a finding, and no healthy value
    assert fitted["screw.csj_Nm"] == reference_actuator()["screw.csj_Nm"]
    assert dict(fitted.findings[-1].values)["screw.csj_Nm"] == result["csj_Nm"]["estimate"]


@pytest.mark.slow
def test_healthy_records_take_the_models_own_error_away() -> None:
    """A winding warmer than the model knows reads as a fault; against a healthy record of the same machine it does not."""
    # A user who allows for what the model misses: the module takes it for sensor noise.
    known = reference_actuator().changed({"verdict.position_noise_mm": 0.03})
    machine = known.changed({"motor.resistance_ohm": 1.03})
    healthy = chirp_record(machine).with_noise({"position_mm": 0.001}, 1)
    again = chirp_record(machine).with_noise({"position_mm": 0.001}, 2)
    alone = identify(known, again)
    beside = identify(known, again, [healthy])
    assert max(abs(estimate.shift_percent) for estimate in alone.answer.identified) > 3.0
    assert max(abs(estimate.shift_percent) for estimate in beside.answer.identified) < 1.0
    assert beside.baseline is not None
    assert beside.baseline.records == 1
    seized = chirp_record(machine.changed({"screw.csj_Nm": 0.2})).with_noise({"position_mm": 0.001}, 3)
    fault = identify(known, seized, [healthy, again])
    assert fault.answer.identified[0].shift_percent == pytest.approx(100.0 * (0.2 - 0.138) / 0.138, abs=5.0)


def test_healthy_records_of_two_states_are_refused(tmp_path: Path) -> None:
    """Of two that differ by a winding of +30 %, one is not healthy; which one, nobody knows."""
    for name, resistance, seed in (("warm.csv", 1.3, 1), ("cold.csv", 1.0, 2)):
        noise = {"position_mm": 0.002, "motor_position_mm": 0.002, "current_A": 0.03, "voltage_V": 0.01}
        write_record(
            tmp_path / name, chirp_record(reference_actuator().changed({"motor.resistance_ohm": resistance})).with_noise(noise, seed)
        )
    said = complaint(
        run_ema("identify", REFERENCE, RECORDINGS / "case_a.csv", "--healthy", tmp_path / "cold.csv", "--healthy", tmp_path / "warm.csv")
    )
    assert said.startswith("warm.csv: not of the same state as cold.csv: ")
    assert said.endswith(": leave out what is not healthy, or calibrate on one of them and diagnose the other")


def test_one_healthy_record_that_the_model_does_not_explain_is_refused(tmp_path: Path) -> None:
    write_record(tmp_path / "warm.csv", chirp_record(reference_actuator().changed({"motor.resistance_ohm": 1.3})))
    said = complaint(run_ema("identify", REFERENCE, RECORDINGS / "case_a.csv", "--healthy", tmp_path / "warm.csv"))
    assert said.startswith(
        "warm.csv: cannot serve as a healthy record: the residual is larger than the sensor noise explains: an effect is missing from the model"
    )
    assert said.endswith(
        ": one healthy run does not show what this unit always has: record two more under today's command and give all with --healthy"
    )


def stuck() -> Record:
    """A rod that does not move under a command too small to move it: the values of play and friction leave no trace."""
    record = chirp_record()
    return replace(record, position_mm=np.zeros(record.rows), command_mm=0.014 * record.command_mm)


def test_what_the_record_does_not_determine_has_no_standard_error(tmp_path: Path) -> None:
    write_record(tmp_path / "stuck.csv", stuck())
    ran = run_ema("identify", REFERENCE, tmp_path / "stuck.csv", "--json", tmp_path / "i.json")
    assert ran.code == 0, ran.err
    result = json.loads((tmp_path / "i.json").read_text(encoding="utf-8"))
    assert "the record does not determine the parameters" in result["reasons"]
    assert result["csj_Nm"]["std"] is None and result["blk_mm"]["std"] is None
    row = next(line.split() for line in ran.out.splitlines() if line.startswith("CSJ "))
    assert "-" in row and "0" not in row
    assert run_ema("report", tmp_path / "i.json", "-o", tmp_path / "p.html").code == 0
    assert "cannot serve as a healthy record" in complaint(
        run_ema("identify", REFERENCE, RECORDINGS / "case_a.csv", "--healthy", tmp_path / "stuck.csv")
    )


@pytest.mark.slow
def test_missing_effect_is_not_called_a_fault() -> None:
    machine = reference_actuator().changed({"motor.resistance_ohm": 1.3})
    found = identify(reference_actuator(), chirp_record(machine))
    assert not found.answer.adequate
    assert found.answer.verdict == "undecided"
    assert ", which does not stand, because the residual is larger than the sensor noise explains" in sentence(found)


def test_seed_decides_the_path_and_nothing_else() -> None:
    record = read_record(RECORDINGS / "case_a.csv", reference_actuator())
    first, second, third = (
        identify(reference_actuator(), record, search=SearchSettings(seed=seed, search="annealer"), guarding=False) for seed in (5, 5, 6)
    )
    assert first.answer == second.answer
    assert first.costs == second.costs
    assert third.costs != first.costs


@pytest.mark.slow
def test_value_that_is_healthy_at_zero_is_left_out() -> None:
    machine = reference_actuator().changed({"screw.blk_mm": 0.0})
    found = identify(machine, chirp_record(machine.changed({"screw.csj_Nm": 0.2})))
    assert [estimate.name for estimate in found.answer.identified] == ["screw.csj_Nm"]
    assert found.answer.identified[0].estimate == pytest.approx(0.2, rel=1e-4)
    told = to_json(identification(found, "", {}))
    assert told["blk_mm"]["estimate"] is None
    assert "healthy value is zero" in told["blk_mm"]["reason"]
    with pytest.raises(InputError, match=r"screw.csj_Nm = 0: the healthy value is zero"):
        identify(machine.changed({"screw.csj_Nm": 0.0}), chirp_record())


def test_healthy_value_outside_its_bounds_is_named() -> None:
    with pytest.raises(InputError, match=r"screw.blk_mm = 0.2: outside the search's bounds 0 .. 0.1 mm: widen them"):
        identify(reference_actuator().changed({"screw.blk_mm": 0.2}), chirp_record())
    with pytest.raises(InputError, match=r"search.csj_lower_Nm = 2: not below search.csj_upper_Nm = 1.5: correct the bounds"):
        identify(reference_actuator().changed({"search.csj_lower_Nm": 2.0}), chirp_record())


@pytest.mark.slow
def test_weights_bring_in_other_channels() -> None:
    assert weight_of(None) is None
    assert weight_of("current_A=0.5,position_mm=1") == (1.0, 0.0, 0.5, 0.0)
    for text, message in (
        ("amps=1", "unknown column"),
        ("current_A=x", "not a number"),
        ("current_A=-1", "not weights"),
        ("current_A=0", "not weights"),
    ):
        with pytest.raises(InputError, match=message):
            weight_of(text)
    record = chirp_record(reference_actuator().changed({"screw.csj_Nm": 0.2}))
    found = identify(reference_actuator(), record, search=SearchSettings(weight=(0.0, 0.0, 1.0, 0.0)))
    assert found.answer.identified[0].estimate == pytest.approx(0.2, rel=1e-4)
    assert "mm2 s" not in sentence(found)
    with pytest.raises(InputError, match="current_A: weighted but not recorded"):
        identify(reference_actuator(), replace(record, current_A=None), search=SearchSettings(weight=(0.0, 0.0, 1.0, 0.0)))


@pytest.mark.slow
def test_simulate_then_identify_on_the_command_line(tmp_path: Path) -> None:
    record = tmp_path / "r.csv"
    ran = run_ema(
        "simulate",
        REFERENCE,
        "--command",
        "chirp",
        "-o",
        record,
        "--set",
        "screw.csj_Nm=0.2",
        "--set",
        "screw.blk_mm=0.05",
        "--noise",
        "position_mm=0.002",
        "--seed",
        "4",
    )
    assert ran.code == 0, ran.err
    again = tmp_path / "s.csv"
    run_ema(
        "simulate",
        REFERENCE,
        "--command",
        "chirp",
        "-o",
        again,
        "--set",
        "screw.csj_Nm=0.2",
        "--set",
        "screw.blk_mm=0.05",
        "--noise",
        "position_mm=0.002",
        "--seed",
        "4",
    )
    assert record.read_bytes() == again.read_bytes()
    ran = run_ema("identify", REFERENCE, record, "--json", tmp_path / "i.json")
    assert ran.code == 0, ran.err
    result = json.loads((tmp_path / "i.json").read_text(encoding="utf-8"))
    for key, true in (("csj_Nm", 0.2), ("blk_mm", 0.05)):
        assert abs(result[key]["estimate"] - true) < 4.0 * result[key]["std"]


def test_record_of_another_machine_is_refused(tmp_path: Path) -> None:
    record = chirp_record()
    write_record(tmp_path / "m.csv", replace(record, position_mm=1e-3 * record.position_mm))
    assert "looks like metres" in complaint(run_ema("identify", REFERENCE, tmp_path / "m.csv"))
    write_record(tmp_path / "h.csv", replace(record, period_s=0.01))
    assert "time_s" in complaint(run_ema("identify", REFERENCE, RECORDINGS / "case_a.csv", "--healthy", tmp_path / "h.csv"))
    write_record(tmp_path / "z.csv", replace(record, command_mm=np.zeros(record.rows)))
    assert "command_mm" in complaint(run_ema("compare", REFERENCE, tmp_path / "z.csv"))
