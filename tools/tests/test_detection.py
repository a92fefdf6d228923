"""The smallest shifts that a ground test finds: factors hold for days drawn at random, the scatter is that of the searches, and what is set in a unit's file has the rate that stands there."""

from __future__ import annotations

import json
import re
import xml.etree.ElementTree
from pathlib import Path

import numpy as np
import pytest

from benchmarks.detection import document, trials
from ema_tools.base.errors import InputError
from ema_tools.data.actuator import read_actuator, reference_actuator
from ema_tools.data.records import write_record
from ema_tools.design.detection import Detection, detection, moved_chirps, scatter_given
from ema_tools.design.menu import limits_of
from ema_tools.fit.detection import USUAL_WEIGHT, Scatter, ShiftTest, false_alarms, rate_text, scatter_by_search
from ema_tools.fit.nuisance import FROM_RUN_TO_RUN
from ema_tools.plant.native import SearchSettings
from ema_tools.results.detection import DetectionResult
from ema_tools.results.reading import result_of
from ema_tools.tasks.healthy_runs import least_shift
from ema_tools.tasks.onboard_search import run
from ema_tools.words.sentences.detection import sentence
from shared_results import shared_result
from support import REFERENCE, chirp_record, complaint, run_ema

NAMES = ("screw.csj_Nm", "screw.blk_mm")
OWN = {name: 100.0 * FROM_RUN_TO_RUN.get(name, 0.0) for name in NAMES}
NOISE = {"position_mm": 0.002, "motor_position_mm": 0.002, "current_A": 0.03, "voltage_V": 0.01}


@pytest.mark.parametrize("runs", [2, 3, 5, 20])
def test_thresholds_have_their_rates_on_days_drawn_at_random(runs: int) -> None:
    """By what a user would do: take the runs' mean and scatter, set the threshold, ask one day more."""
    random = np.random.default_rng(5)
    test, draws = ShiftTest(runs=runs), 40_000
    days = random.standard_normal((draws, runs, 2))
    mean = days.mean(axis=1)
    apart = np.sum((days - mean[:, None, :]) ** 2, axis=1)
    shown = np.sqrt((USUAL_WEIGHT + apart) / (USUAL_WEIGHT + runs - 1.0))
    today = random.standard_normal((draws, 2))
    exceeded = np.mean(np.any(today - mean > test.threshold() * shown, axis=1))
    assert exceeded == pytest.approx(test.usual_false_alarms(), abs=3.0 * np.sqrt(0.01 / draws) + 1e-4)
    assert exceeded <= test.false_alarm
    found = np.mean(today[:, 0] + test.found() - mean[:, 0] > test.threshold() * shown[:, 0])
    assert found == pytest.approx(test.power, abs=0.005)
    # an interval of 95 %, where the scatter is learned from these very runs
    assert 0.94 < np.mean(np.abs(today - mean) < 1.96 * test.spread() * shown) < 0.98
    # both together, whose scatter is one size
    size = np.sqrt((2.0 * USUAL_WEIGHT + apart.sum(axis=1)) / (2.0 * (USUAL_WEIGHT + runs - 1.0)))
    far = np.linalg.norm(today - mean + test.found_together() * np.array([0.6, 0.8]), axis=1)
    assert np.mean(far > test.threshold_together() * size) >= test.power - 0.005
    assert np.mean(np.linalg.norm(today - mean, axis=1) > test.threshold_together() * size) <= test.false_alarm


def test_a_known_scatter_is_the_limit_of_many_runs() -> None:
    known, many, few = ShiftTest(), ShiftTest(runs=2000), ShiftTest(runs=3)
    assert known.threshold() == pytest.approx(2.5758, abs=1e-3)
    assert known.found() == pytest.approx(2.5758 + 1.6449, abs=1e-3)
    assert many.threshold() == pytest.approx(known.threshold(), rel=0.01) and many.found() == pytest.approx(known.found(), rel=0.01)
    assert many.found_together() == pytest.approx(known.found_together(), rel=0.01)
    assert few.threshold() > known.threshold() and few.found() > known.found()
    assert ShiftTest(0.001).threshold() > known.threshold() and ShiftTest(power=0.99).found() > known.found()
    # both together cost little more than one alone, and find any direction
    assert 1.0 < known.found_together() / known.found() < 1.1


def test_the_rate_that_is_stated_is_the_one_that_was_chosen() -> None:
    for runs in (2, 3, 10):
        assert false_alarms(ShiftTest(0.02, runs=runs).threshold(), runs) == pytest.approx(0.02, rel=1e-6)
    assert rate_text(0.005) == "at most 0.5 %" and rate_text(1e-9) == "less than 0.01 %"


def test_thresholds_stay_as_stated_and_grow_with_the_scatter_unless_a_rate_is_chosen() -> None:
    factor = ShiftTest(runs=5).threshold()
    assert least_shift(5.0, 0.4, 5) == 5.0
    assert least_shift(5.0, 2.0, 5) == pytest.approx(2.0 * factor)
    assert least_shift(5.0, 20.0, 5) == 10.0
    assert least_shift(5.0, 0.4, 5, 0.01) == pytest.approx(0.4 * factor)
    assert least_shift(5.0, 0.4, 5, 0.001) > least_shift(5.0, 0.4, 5, 0.01)


@pytest.mark.slow
@pytest.mark.parametrize("day_searched", [False, True])
def test_the_scatter_is_that_of_the_searches(day_searched: bool) -> None:
    """On records of other days with sensor noise; thirty of them know a standard deviation to 13 %."""
    actuator = reference_actuator().changed({"search.day_values": float(day_searched)})
    random = np.random.default_rng(11)
    read = []
    for day in range(30):
        moved = {name: actuator[name] * (1.0 + std * float(random.normal())) for name, std in FROM_RUN_TO_RUN.items()}
        answer = run(actuator, chirp_record(actuator.changed(moved)).with_noise({"position_mm": 0.005}, day), SearchSettings(), 32)
        read.append([one.shift_percent for one in answer.identified])
    stated = scatter_by_search(actuator, chirp_record(actuator), NAMES, 0.005, OWN, day_searched)
    assert np.std(read, axis=0, ddof=1) == pytest.approx([stated.std(name) for name in NAMES], rel=0.4)
    answer = run(actuator, chirp_record(actuator).with_noise({"position_mm": 0.005}, 1), SearchSettings(), 32)
    noise = [100.0 * one.std / actuator[one.name] for one in answer.identified]
    assert noise == pytest.approx([stated.noise_std(name) for name in NAMES], rel=0.1)


@pytest.fixture(scope="module")
@shared_result
def found() -> Detection:
    return detection(reference_actuator(), ShiftTest(runs=3))


@pytest.mark.slow
def test_the_present_test_and_better_ones(found: Detection) -> None:
    assert found.present.command.startswith("chirp:amplitude_mm=2,start_hz=0.1,end_hz=4")
    # nothing finds less of the friction than what friction itself differs by from day to day
    assert all(one.onboard["csj"].alone >= 0.4 * found.test.found() * 0.999 for one in (found.present, *found.options))
    assert [one.over_wanted for one in found.options] == sorted(one.over_wanted for one in found.options)
    best = found.best
    assert best is not None and best.over_wanted < found.present.over_wanted and best.duration_s <= found.present.duration_s
    assert best.onboard["blk"].alone < 0.5 * found.present.onboard["blk"].alone
    assert best.command in sentence(found)
    for one in (found.present, best):
        assert all(limit.alone < limit.together for limit in one.onboard.values())
        assert all(one.signals[name].alone <= limit.alone for name, limit in one.onboard.items())
        assert all(limit.threshold < limit.alone for limit in one.onboard.values())


@pytest.mark.slow
def test_what_is_not_safe_or_shows_no_play_is_left_out(found: Detection) -> None:
    limits = limits_of(reference_actuator())
    assert all(one.peak_current_A <= limits.current_A and one.peak_speed_mm_s <= limits.speed_mm_s for one in found.options)
    assert any("sweep x 2" in command for command in found.unsafe)
    assert any(command.startswith("step:") for command in found.one_way)
    assert not {one.command for one in found.options} & set(found.one_way)


@pytest.mark.release
def test_noise_scatter_and_runs_move_it() -> None:
    def alone(*, runs: int = 3, noise: float = 0.005, scatter: dict[str, float] | None = None) -> dict[str, float]:
        seen = detection(
            reference_actuator().changed({"search.day_values": 1.0}),
            ShiftTest(runs=runs),
            noise={"position_mm": noise},
            scatter_percent=scatter,
        )
        return {name: one.alone for name, one in seen.present.onboard.items()}

    usual = alone()
    assert alone(noise=0.01)["blk"] == pytest.approx(2.0 * usual["blk"], rel=0.02)
    assert alone(runs=10)["csj"] < 0.7 * usual["csj"]
    wide = alone(scatter={"csj": 2.0})
    assert wide["csj"] == pytest.approx(2.0 * ShiftTest(runs=3).found(), rel=1e-6) and wide["blk"] == pytest.approx(usual["blk"])


def test_a_chirp_is_moved_in_what_it_has() -> None:
    moved = moved_chirps("chirp:amplitude_mm=1,end_hz=8", 1e-3)
    assert moved["amplitude x 2, sweep x 0.5"] == "chirp:amplitude_mm=2,start_hz=0.1,end_hz=4,duration_s=10"
    assert "chirp:amplitude_mm=1,start_hz=0.1,end_hz=8,duration_s=10" not in moved.values()
    assert moved_chirps("triangle:amplitude_mm=2", 1e-3) == {}
    with pytest.raises(InputError, match=r"--scatter cjs=1: no such value .did you mean csj"):
        scatter_given("cjs=1")
    with pytest.raises(InputError, match="--scatter csj=-1: not a scatter"):
        scatter_given("csj=-1")


@pytest.mark.slow
def test_command_says_it_and_programs_read_it(tmp_path: Path) -> None:
    ran = run_ema("next", REFERENCE, "--detect", "--runs", 5, "--json", tmp_path / "d.json")
    assert ran.code == 0, ran.err
    data = json.loads((tmp_path / "d.json").read_text(encoding="utf-8"))
    read = result_of(data, "d.json")
    assert isinstance(read, DetectionResult)
    assert (read.false_alarm, read.power, read.runs) == (0.01, 0.95, 5)
    assert read.sentence in ran.out
    assert all(len(line) <= 100 for line in ran.out.splitlines() if re.match(r"(chirp|triangle|multisine) ", line))
    page = run_ema("report", tmp_path / "d.json", "-o", tmp_path / "d.html")
    assert page.code == 1 and "has no page" in complaint(page)


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ((), "give one of --between EFFECT EFFECT... and --detect"),
        (("--detect", "--between", "csj", "blk"), "give one of --between"),
        (("--between", "csj", "blk", "--runs", "5"), "--runs belongs to --detect"),
        (("--detect", "--set", "screw.csj_Nm=1"), "belong to --between"),
    ],
)
def test_one_question_at_a_time(arguments: tuple[str, ...], told: str) -> None:
    ran = run_ema("next", REFERENCE, *arguments)
    assert ran.code == 2 and told in ran.err


@pytest.mark.slow
def test_a_chosen_rate_goes_into_the_units_file_and_the_firmware(tmp_path: Path) -> None:
    files = []
    for seed in (1, 2):
        files.append(tmp_path / f"{seed}.csv")
        write_record(files[-1], chirp_record().with_noise(NOISE, seed))
    ran = run_ema("calibrate", REFERENCE, *files, "--false-alarm", "0.02", "-o", tmp_path / "unit.toml", "--json", tmp_path / "c.json")
    assert ran.code == 0, ran.err
    own = json.loads((tmp_path / "c.json").read_text(encoding="utf-8"))["own_machine"]
    unit = read_actuator(tmp_path / "unit.toml")
    for name, field in (("screw.csj_Nm", "csj_min_shift_percent"), ("screw.blk_mm", "blk_min_shift_percent")):
        # of friction every factor of scatter counts that two runs allow, whose tail is test_temperature's
        computed = ShiftTest(0.02, runs=2).threshold() * own["scatter_percent"][name]
        assert unit[f"verdict.{field}"] == (pytest.approx(computed) if name == "screw.blk_mm" else pytest.approx(computed, rel=0.5))
        assert own["exceeded"][name] == pytest.approx(0.01)
        assert own["found_percent"][name] > own["least_percent"][name]
        assert "by its 2 healthy runs a healthy unit exceeds it in at most 1 % of ground tests" in unit.remark(f"verdict.{field}")
    assert reference_actuator().remark("verdict.csj_min_shift_percent") == ""
    assert run_ema("export", tmp_path / "unit.toml", "-o", tmp_path / "unit.h").code == 0
    assert (tmp_path / "unit.h").read_text(encoding="utf-8").count("in at most 1 % of ground tests") == 2
    # written once more, the comments stay
    again = read_actuator(tmp_path / "unit.toml").changed({"screw.csj_Nm": 0.2}).written_text()
    assert again.count("in at most 1 % of ground tests") == 2
    alone = run_ema("calibrate", REFERENCE, files[0], "--false-alarm", "0.02", "-o", tmp_path / "none.toml")
    assert alone.code == 1 and "no two of the records run the same command" in complaint(alone)


def test_the_benchmark_counts_what_is_drawn() -> None:
    """Readings that lie as computed have the computed rates, and the figure shows every verdict."""
    known = Scatter(NAMES, np.diag([0.01, 0.8]), np.array([[0.2, 0.05], [0.05, 0.9]]), np.zeros(2))
    random, test = np.random.default_rng(3), ShiftTest(runs=3)
    drawn = {name: random.multivariate_normal([0.0, 0.0], known.whole, 4000) for name in ("", "csj", "blk")}
    moves = {fault: (test.found() * known.std(name), test.found_together() * known.alone(name)) for fault, name in trials.FAULTS.items()}
    rates = trials.tested(drawn, known, 3, moves, 4000)
    assert max(rates[""]) <= 0.01
    assert [rates[fault][0] for fault in moves] == pytest.approx([0.95, 0.95], abs=0.015)
    assert all(rates[fault][1] >= 0.94 for fault in moves)
    rows = [
        {
            "kind": kind,
            "unit": 1,
            "fault": fault,
            "percent": percent,
            "verdict": verdict,
            "threshold": {"csj": 5.0, "blk": 10.0},
            "computed": {"csj": 6.0, "blk": 14.0},
            "limit": {"csj": 3.0, "blk": 7.0},
        }
        for kind in ("flight", "unit")
        for fault, percent, verdict in (("csj", 0.0, "healthy"), ("csj", 5.0, "undecided"), ("csj", 8.0, "fault"), ("blk", 20.0, "fault"))
    ]
    drawing = document.figure(rows)
    assert xml.etree.ElementTree.fromstring(drawing).tag.endswith("svg") and drawing.count("<polyline") == 12
    assert "| +5 % | 0 | 0 | 100 | 0 | 0 | 100 |" in document.curves(rows, "")
