"""Accuracy of the identification with few seeds; the full trials write docs/RESULTS.md."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from benchmarks import accuracy, document
from benchmarks.__main__ import run
from benchmarks.speed import measure
from ema_tools.base.errors import InputError
from ema_tools.data.actuator import reference_actuator
from ema_tools.data.cases import CASES

pytestmark = pytest.mark.slow

RECORDINGS = Path(__file__).resolve().parents[2] / "recordings"
ACTUATOR = reference_actuator()


@pytest.fixture(scope="module")
def records() -> dict[str, object]:
    """The shipped recordings of the cases."""
    return accuracy.truth_records(RECORDINGS)


@pytest.fixture(scope="module")
def chirp_mm(records: dict[str, object]) -> np.ndarray:
    """The reference chirp, [rows]."""
    return records["A"].command_mm


def test_cases_agree_with_the_papers_shifts() -> None:
    assert [case.shift_percent("csj_Nm") for case in CASES] == pytest.approx([117.39, 5.0, 1.0], abs=5e-3)
    assert [case.shift_percent("blk_mm") for case in CASES] == pytest.approx([25.0, 100.0, 1.0], abs=5e-3)
    # The paper's own reading of case C: +9.33 % of backlash for +1 %.
    assert CASES[2].paper_shift_percent("blk_mm") == pytest.approx(9.33, abs=5e-3)
    assert (ACTUATOR["screw.csj_Nm"], ACTUATOR["screw.blk_mm"]) == pytest.approx((0.138, 0.033))


def test_own_records_are_met_from_every_start(chirp_mm: np.ndarray) -> None:
    for trial in accuracy.own(ACTUATOR, chirp_mm, seeds=3):
        assert trial.errors_percent.shape == (15, 2)
        assert np.all(trial.worst_percent() <= accuracy.OWN_LIMIT_PERCENT), trial.letter
        assert np.max(trial.evaluations) <= accuracy.EVALUATION_BUDGET


def test_truth_plants_records_are_met(records: dict[str, object]) -> None:
    for trial in accuracy.truth(ACTUATOR, records, seeds=3):
        assert np.all(trial.worst_percent() <= accuracy.TRUTH_LIMIT_PERCENT), trial.letter


def test_noise_scatters_as_the_bound_says(records: dict[str, object], chirp_mm: np.ndarray) -> None:
    seeds = 12
    for case, trial in zip(CASES, accuracy.noise(ACTUATOR, records, seeds), strict=True):
        bound = accuracy.cramer_rao_percent(ACTUATOR, case, chirp_mm)
        ratio = trial.rms_percent() / bound
        # Twelve records know the ratio to 20 %; three standard errors on both sides.
        assert np.all(ratio < 1.0 + 3.0 / np.sqrt(2 * seeds)) and np.all(ratio > 1.0 - 3.0 / np.sqrt(2 * seeds)), (case.letter, ratio)
        assert np.sqrt(np.mean(trial.std_percent**2, axis=0)) == pytest.approx(bound, rel=0.1)
        assert np.all(trial.covered() >= 0.7)


def test_bound_does_not_hang_on_the_difference(chirp_mm: np.ndarray) -> None:
    for case in CASES:
        coarse, fine = (accuracy.cramer_rao_percent(ACTUATOR, case, chirp_mm, share) for share in (1e-3, 1e-5))
        assert coarse == pytest.approx(fine, rel=2e-3)


def _trial(letter: str, error: float, evaluations: float = 200.0) -> accuracy.SearchTrial:
    return accuracy.SearchTrial(letter, np.full((2, 2), error), np.full((2, 2), error), np.full(2, evaluations))


def test_missed_limits_are_named() -> None:
    good = [_trial(case.letter, 1e-3) for case in CASES]
    bounds = [np.full(2, 1e-3)] * len(CASES)
    assert document.missed(good, good, good, bounds) == []
    problems = document.missed([_trial("A", 0.02)], [_trial("B", 0.1)], [_trial("C", 1.3e-3)], bounds[:1])
    assert [problem.split(":")[0] for problem in problems] == ["case A, own record"] * 2 + [
        "case B, truth plant's record",
        "case C, noise",
        "case C, noise",
    ]
    assert document.missed([replace(good[0], evaluations=np.array([401.0]))], good, good, bounds) == [
        "case A: 401 model runs, limit 400: look at the budget"
    ]


def test_command_writes_the_document(tmp_path: Path) -> None:
    program = tmp_path / "speed"
    program.write_text("#!/bin/sh\necho 'one line of figures'\n", encoding="utf-8")
    program.chmod(0o755)
    target = tmp_path / "RESULTS.md"
    arguments = ["--seeds", "1", "--noise-seeds", "4", "--recordings", str(RECORDINGS), "--speed", str(program), "-o", str(target)]
    # Four noisy records may scatter past the limit; the document is written either way.
    assert CliRunner().invoke(run, arguments).exit_code in (0, 1)
    text = target.read_text(encoding="utf-8")
    assert text.count("| A | CSJ |") == 2 and "one line of figures" in text and "5 searches per case" in text


def test_absent_benchmark_program_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"absent: cannot be run .*: build the tests first"):
        measure(tmp_path / "absent")
