"""The module's least squares from Python, on records of the truth plant; and `ema identify --values`."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.searches import problems
from ema_tools.base.errors import InputError
from ema_tools.base.recording import Recording
from ema_tools.data.actuator import reference_actuator
from ema_tools.data.records import Record, write_record
from ema_tools.plant.least_squares import Searched, SquaresFound, SquaresSettings, least_squares
from ema_tools.plant.native import CHANNELS
from ema_tools.results.identification import IdentificationResult
from ema_tools.results.reading import read_result
from ema_tools.tasks.several_values import searched_of, several_values
from stored_records import worn_in_eight
from support import RECORDINGS, REFERENCE, chirp_record, complaint, run_ema

EIGHT = ",".join(one.names[0] for one in problems.EIGHT)
NOISE = (problems.NOISE[0], problems.NOISE[1], problems.NOISE[2], problems.NOISE[3])


@pytest.fixture(scope="module")
def exact() -> Recording:
    """Worn and out of tune in eight values, of the truth plant, without noise."""
    return worn_in_eight()


def _searched(start: np.ndarray) -> tuple[Searched, ...]:
    objective = zip(problems.EIGHT, start, strict=True)
    return tuple(
        Searched(one.names[0], one.lower, one.upper, float(at), one.names[1] if len(one.names) > 1 else None) for one, at in objective
    )


def _found(recording: Recording, start: np.ndarray, bits: int = 32, slice_steps: int = 1000) -> SquaresFound:
    values, options = reference_actuator().arrays()
    channels = np.column_stack([getattr(recording, name) for name in CHANNELS])
    settings = SquaresSettings(_searched(start), NOISE, slice_steps=slice_steps)
    return least_squares(values, options, recording.command_mm, channels, settings, bits)


@pytest.mark.slow
def test_eight_values_to_the_noise_limit_from_every_start(exact: Recording) -> None:
    recording = problems.noisy(exact, 5)
    objective = problems.objective_of(recording, 8)
    truth = problems.truth_of(8)
    costs = []
    for unit in (*problems.starts(8, 8), None):
        start = objective.healthy if unit is None else objective.inside(unit)
        found = _found(recording, start)
        estimates = np.array([one.estimate for one in found.values])
        costs.append(objective.cost(estimates))
        assert found.adequate and found.outcome == "tolerance" and found.runs <= 600
        assert found.misfit_after == pytest.approx(1.0, abs=0.02)
        assert all(one.determined == "yes" for one in found.values)
        off = np.abs(estimates - truth) / [one.std for one in found.values]
        assert np.max(off) < 4.0
    # what one standard error of one value adds
    level = problems.NOISE[0] ** 2 * problems.PERIOD_S
    assert max(costs) <= min(costs) + level
    assert max(costs) <= objective.cost(truth)


def test_intervals_hold_the_truth(exact: Recording) -> None:
    truth = problems.truth_of(8)
    held = 0
    for seed in range(10):
        found = _found(problems.noisy(exact, 100 + seed), problems.objective_of(exact, 8).healthy)
        held += sum(abs(one.estimate - true) <= 1.96 * np.hypot(one.std, one.bias) for one, true in zip(found.values, truth, strict=True))
    # 76 of 80 on average; fewer than 68 by chance once in 1500
    assert held >= 68


def test_answer_depends_neither_on_slices_nor_much_on_precision(exact: Recording) -> None:
    recording = problems.noisy(exact, 5)
    start = problems.objective_of(recording, 8).healthy
    first = _found(recording, start)
    assert _found(recording, start, slice_steps=170) == first
    double = _found(recording, start, bits=64)
    for one, other in zip(first.values, double.values, strict=True):
        assert one.estimate == pytest.approx(other.estimate, abs=0.5 * one.std)
        assert one.noise_std == pytest.approx(other.noise_std, rel=0.1)


def test_values_that_do_the_same_are_named(exact: Recording) -> None:
    recording = problems.noisy(exact, 5)
    record = Record(
        0.001, recording.command_mm, recording.position_mm, recording.motor_position_mm, recording.current_A, recording.voltage_V
    )
    worn = reference_actuator().changed({name: value for name, value in problems.TRUTH[8].items() if name != "control.kp_per_m"})
    for bits in (32, 64):
        several = several_values(worn, record, "gain_drift.drift,control.kp_per_m,screw.csj_Nm", bits)
        drift, gain, csj = several.found.values
        assert (drift.determined, drift.alike) == ("together", gain.name)
        assert (gain.determined, gain.alike) == ("together", drift.name)
        assert csj.determined == "yes"
        assert several.interval95(drift) is None
        low, high = several.interval95(csj) or (None, None)
        assert low is not None and high is not None and low < 0.2 < high
        assert several.before["control.kp_per_m"] == 400.0
        assert (1.0 + drift.estimate) * gain.estimate == pytest.approx(420.0, abs=0.1)


def test_bounds_come_from_the_value_or_from_the_user() -> None:
    actuator = reference_actuator()
    found = {one.name: one for one in searched_of(actuator, f"{EIGHT},")}
    assert len(found) == 8
    assert (found["screw.csj_Nm"].lower, found["screw.csj_Nm"].upper) == (0.01, 1.5)
    assert found["screw.dynamic_ratio"].upper == 1.0
    assert found["motor.torque_constant_Nm_per_A"].companion == "motor.back_emf_V_s_per_rad"
    assert found["screw.load_torque_Nm"].lower == -0.138
    assert all(one.lower <= one.start <= one.upper for one in found.values())
    (one,) = searched_of(actuator, "encoder.rod_offset_mm = -0.1..0.2")
    assert (one.lower, one.upper, one.start) == (-0.1, 0.2, 0.0)
    # asked for by themselves, each moves alone
    both = searched_of(actuator, "motor.torque_constant_Nm_per_A,motor.back_emf_V_s_per_rad")
    assert [one.companion for one in both] == [None, None]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("screw.csj_Nm,screw.csj_Nm", "stands there twice"),
        ("screw.csj", "did you mean"),
        ("search.seed", "no value of the machine"),
        ("verdict.position_noise_mm", "no value of the machine"),
        ("timing.step_s", "no value of the machine"),
        ("learned_torque.gain", "learned table"),
        ("encoder.rod_offset_mm", "it is zero"),
        ("screw.csj_Nm=0.3", "not bounds"),
        ("screw.csj_Nm=0.3..0.2", "not bounds"),
        ("screw.csj_Nm=-1..2", "outside 0 .. 100"),
        ("", "0 values"),
        (f"{EIGHT},screw.inertia_kgm2", "9 values"),
    ],
)
def test_values_that_cannot_be_searched(text: str, says: str) -> None:
    with pytest.raises(InputError, match=says):
        searched_of(reference_actuator(), text)


def test_module_refuses_what_it_cannot_search(exact: Recording) -> None:
    values, options = reference_actuator().arrays()
    channels = np.column_stack([getattr(exact, name) for name in CHANNELS])
    settings = SquaresSettings((Searched("screw.csj_Nm", 0.01, 1.5, 0.138),), NOISE)

    def searched(settings: SquaresSettings, channels: np.ndarray = channels) -> SquaresFound:
        return least_squares(values, options, exact.command_mm, channels, settings)

    assert searched(settings).values[0].estimate > 0.0
    for wrong in (
        replace(settings, searched=(Searched("screw.csj_Nm", 0.01, 1.5, 1.6),)),
        replace(settings, searched=(Searched("screw.csj_Nm", 0.2, 0.1, 0.15),)),
        replace(settings, noise=(0.0, 0.0, 0.0, 0.0)),
        replace(settings, run_budget=1),
        replace(settings, restarts=-1),
        replace(settings, slice_steps=0),
        replace(settings, searched=()),
    ):
        with pytest.raises(InputError, match="least squares: "):
            searched(wrong)
    spoilt = channels.copy()
    spoilt[41, 2] = np.nan
    with pytest.raises(InputError, match="sample 42 of the record"):
        searched(settings, spoilt)
    with pytest.raises(ValueError, match="channels: shape"):
        searched(settings, channels[:, :3])

    def stop(_runs: int, _misfit: float, _lowest: np.ndarray) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        least_squares(values, options, exact.command_mm, channels, settings, progress=stop)


def test_identify_writes_and_shows_them(tmp_path: Path) -> None:
    out = tmp_path / "i.json"
    record = RECORDINGS / "case_a_noisy.csv"
    ran = run_ema("identify", REFERENCE, record, "--no-guard", "--values", "screw.csj_Nm,screw.blk_mm,motor.resistance_ohm", "--json", out)
    assert ran.code == 0, ran.err
    assert "Of 3 values searched at once by rod position, motor position, current, voltage the record determines 3" in ran.out
    written = json.loads(out.read_text(encoding="utf-8"))
    assert list(written["values"]) == ["screw.csj_Nm", "screw.blk_mm", "motor.resistance_ohm"]
    csj = written["values"]["screw.csj_Nm"]
    assert csj["determined"] == "yes" and csj["before"] == 0.138
    assert csj["interval95"][0] < 0.3 < csj["interval95"][1]
    assert written["csj_Nm"]["estimate"] == pytest.approx(0.3, rel=0.01)
    assert written["values_search"]["adequate"] and written["values_search"]["runs"] < 200
    read = read_result(out)
    assert isinstance(read, IdentificationResult) and read.values is not None
    assert read.values["screw.csj_Nm"].interval95 == tuple(csj["interval95"])
    plain = tmp_path / "plain.json"
    run_ema("identify", REFERENCE, record, "--no-guard", "--json", plain)
    assert not {"values", "values_search"} & set(json.loads(plain.read_text(encoding="utf-8")))


def test_identify_says_what_a_record_does_not_determine(tmp_path: Path) -> None:
    # never beyond its first quarter of a wave, the rod is pushed one way alone
    record = chirp_record(reference_actuator(), bits=64)
    start = replace(record, **{name: getattr(record, name)[:700] for name in ("command_mm", "position_mm")})
    alone = replace(start, motor_position_mm=None, current_A=None, voltage_V=None, speed_mm_s=None).with_noise({"position_mm": 0.005}, 1)
    path = tmp_path / "short.csv"
    write_record(path, alone)
    ran = run_ema("identify", REFERENCE, path, "--no-guard", "--values", "screw.blk_mm,screw.csj_Nm,screw.load_torque_Nm")
    assert ran.code == 0, ran.err
    told = ran.out[ran.out.index("Of 3 values") :]
    assert "not by this record" in told and "only together with" in told


def test_identify_complains_before_it_searches() -> None:
    ran = run_ema("identify", REFERENCE, RECORDINGS / "case_a.csv", "--values", "screw.nothing")
    assert complaint(ran).startswith("screw.nothing: unknown value")
