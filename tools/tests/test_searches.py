"""The comparison of searches with one start of each; the whole writes docs/SEARCHES.md."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ema_tools.base.errors import InputError
from ema_tools.base.recording import Recording
from ema_tools.data.actuator import reference_actuator
from ema_tools.data.records import read_record
from ema_tools.plant.native import AnnealerSettings, library
from support import RECORDINGS

pytest.importorskip("nlopt", reason="a search of the comparison is not installed: its wheels end before this Python")
from benchmarks.optimum import optimum
from benchmarks.searches import baseline, document, problems, rivals, trials

pytestmark = pytest.mark.release


@pytest.fixture(scope="module")
def recording() -> Recording:
    """Case A with sensor noise, of the truth plant."""
    record = read_record(RECORDINGS / "case_a_noisy.csv")
    columns = {name: record.recorded(name) for name in ("position_mm", "motor_position_mm", "current_A", "voltage_V")}
    return Recording(record.time_s, record.command_mm, speed_mm_s=np.zeros(record.rows), **columns)


@pytest.fixture(scope="module")
def problem(recording: Recording) -> problems.Problem:
    """CSJ and BLK of it."""
    objective = problems.objective_of(recording, 2)
    lowest = optimum(objective, [objective.healthy], cells=6)
    assert lowest.theta == pytest.approx([0.3, 0.04125], rel=0.02)
    return problems.Problem("2 noise", objective, lowest, 2.5e-8 + lowest.rounding, recording)


def test_rivals_arrive_and_are_counted(problem: problems.Problem) -> None:
    for name, most in (
        ("this annealer", 200),
        ("SciPy least_squares (sees residuals)", 100),
        ("SciPy dual_annealing", 600),
        ("CMA-ES", 600),
    ):
        found = rivals.search(problem, name, np.array([0.3, 0.7]), 1)
        assert set(found.when) == {"close", "noise"}, name
        assert max(runs for runs, _ in found.when.values()) == found.runs <= most, name
        assert problem.objective.cost(found.theta) <= problem.lowest.cost + problem.level


def test_a_search_ends_with_its_model_runs(problem: problems.Problem, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(rivals.CAP, 2, 12)
    for name in rivals.RIVALS:
        found = rivals.search(problem, name, np.array([0.9, 0.9]), 1)
        assert found.runs <= 12 and not found.when, name


def _row(rival: str, runs: int, there: bool, **more: object) -> dict[str, object]:
    when = {"noise": [runs, 0.1], "close": [runs, 0.1]} if there else {}
    return {"values": 2, "kind": "noise", "rival": rival, "runs": runs, "when": when, **more}


def test_ranks_count_the_searches_that_failed() -> None:
    rows = (
        [_row("this annealer", 100, True)] * 2
        + [_row("NLopt BOBYQA", 40, True), _row("NLopt BOBYQA", 90, False)]
        + [_row("CMA-ES", 300, False)]
    )
    assert document.expected_runs(rows[2:4], "noise") == pytest.approx(130.0)
    assert document.ranked(rows, 2, "noise") == [("this annealer", 100.0), ("NLopt BOBYQA", 130.0), ("CMA-ES", math.inf)]
    text = document.written(rows, "command")
    assert "this annealer is **1 of 3**, 100 runs expected. Before it: none. After it: NLopt BOBYQA (130), CMA-ES (never)." in text
    rows[2:4] = [_row("NLopt BOBYQA", 40, True)] * 2
    assert "this annealer is **2 of 3**" in document.written(rows, "command")


def test_trials_of_every_rival_and_of_what_belongs_to_a_problem() -> None:
    made = trials.trials(30, 2)
    assert len({trial.key for trial in made}) == len(made)
    counts = {
        name: sum((trial.values, trial.kind, trial.rival) == (2, "noise", name) for trial in made)
        for name in (*rivals.RIVALS, "session", "data")
    }
    assert counts["NLopt DIRECT"] == counts["data"] == 1 and counts["textbook annealer"] == 25
    assert all(count == 30 for name, count in counts.items() if name not in ("NLopt DIRECT", "data", "textbook annealer"))
    assert not any(trial.values == 8 and trial.kind == "exact" for trial in made)


def test_eight_values_are_not_determined_by_the_rod_position_alone(recording: Recording) -> None:
    at = np.array([0.3, 0.95, 1e-4, 0.04125, 0.99, 0.0612, 400.0, 0.0])
    alone = problems.identifiable(problems.objective_of(recording, 8, (1.0, 0.0, 0.0, 0.0)), at)
    every = problems.identifiable(problems.objective_of(recording, 8), at)
    assert np.max(alone[0]) > 50.0 and np.max(every[0]) < 2.0
    assert np.all(every[0] <= alone[0]) and np.all(np.diff(every[1]) <= 0.0)
    # what is known of CSJ and BLK alone is what their own sensitivities say
    two = problems.objective_of(recording, 2)
    slopes = two.jacobian(at[[0, 3]]) / (0.005 * np.sqrt(0.001))
    expected = 100.0 * np.sqrt(np.diag(np.linalg.inv(slopes.T @ slopes)))
    assert problems.identifiable(two, at[[0, 3]])[0] == pytest.approx(expected, rel=1e-6)


def test_recursive_least_squares_is_least_squares_and_reads_the_record(recording: Recording) -> None:
    rng = np.random.default_rng(1)
    columns = rng.standard_normal((200, 3)) * [1.0, 100.0, 1e-3]
    target = columns @ [2.0, -0.03, 500.0] + 0.1 * rng.standard_normal(200)
    assert baseline.recursive(columns, target) == pytest.approx(np.linalg.lstsq(columns, target)[0], rel=1e-4)
    found, _ = baseline.estimates(recording)
    assert found["screw.csj_Nm"] == pytest.approx(0.3, rel=0.1)
    assert found["screw.blk_mm"] == pytest.approx(0.04125, rel=0.1)
    assert found["motor.resistance_ohm"] == pytest.approx(0.99, rel=0.05)


def test_annealer_alone_searches_costs_of_the_callers_own() -> None:
    settings = AnnealerSettings((0.9,) * 3, 1.0, 0.9, 1e-12, 2000, stall_evaluations=60)
    seen: list[np.ndarray] = []

    def bowl(x: np.ndarray, limit: float) -> float:
        assert limit > 0.0
        seen.append(x)
        return float(np.sum((x - [0.2, 0.4, 0.6]) ** 2))

    found = library(64).anneal(settings, bowl)
    assert found.outcome == "tolerance" and found.evaluations == len(seen)
    assert found.x == pytest.approx([0.2, 0.4, 0.6], abs=1e-4)
    assert seen[0] == pytest.approx([0.9] * 3)
    with pytest.raises(InputError, match="anneal: "):
        library(64).anneal(AnnealerSettings((1.5,), 1.0, 0.9, 0.0, 10), bowl)
    with pytest.raises(ZeroDivisionError):
        library(64).anneal(settings, lambda _x, _limit: 1.0 / 0.0)


def test_reference_actuator_is_the_problems_healthy_one() -> None:
    actuator = reference_actuator()
    for one in problems.EIGHT:
        assert one.healthy == actuator[one.names[0]] and one.lower <= one.healthy <= one.upper
