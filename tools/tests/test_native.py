"""The C module behind Python: both precisions, its complaints, progress, threads."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ema_tools.base.errors import InputError
from ema_tools.base.parallel import each
from ema_tools.data.actuator import reference_actuator
from ema_tools.library.definitions import load_definitions
from ema_tools.plant.native import Library, LibraryError, SearchSettings, library
from support import chirp_record

VALUES, OPTIONS = reference_actuator().arrays()


def test_library_that_is_not_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("EMA_LIBRARY_DIR", str(tmp_path))
    library.cache_clear()
    with pytest.raises(LibraryError, match=r"ema_desk64.*build the project"):
        library(64)
    library.cache_clear()


def test_library_that_is_none(tmp_path: Path) -> None:
    path = tmp_path / "libema_desk64.so"
    path.write_bytes(b"no library")
    with pytest.raises(LibraryError, match="cannot be loaded"):
        Library(path, 64)
    with pytest.raises(LibraryError, match="calculates with 32 bits, 64 expected"):
        Library(library(32).path, 64)


def test_both_precisions_agree() -> None:
    command = chirp_record().command_mm
    wide = library(64).simulate(VALUES, OPTIONS, command)
    narrow = library(32).simulate(VALUES, OPTIONS, command)
    assert np.sqrt(np.mean((wide.position_mm - narrow.position_mm) ** 2)) < 2e-4
    assert not np.array_equal(wide.position_mm, narrow.position_mm)
    assert wide.unlocated_event_steps == 0


def test_objective_is_the_integral_of_the_squared_error() -> None:
    healthy = chirp_record()
    seized = chirp_record(reference_actuator().changed({"screw.csj_Nm": 0.3, "screw.blk_mm": 0.04125}))
    objective = library().objective(VALUES, OPTIONS, seized.command_mm, seized.table())
    assert objective == pytest.approx(np.sum((seized.position_mm - healthy.position_mm) ** 2) * 1e-3, rel=1e-9)
    # The paper's case A begins at 0.655 mm2 s.
    assert objective == pytest.approx(0.675, abs=0.005)
    weighted = library().objective(VALUES, OPTIONS, seized.command_mm, seized.table(), (0.0, 0.0, 2.0, 0.0))
    assert weighted == pytest.approx(2.0 * np.sum((seized.current_A - healthy.current_A) ** 2) * 1e-3, rel=1e-9)


def test_refused_actuator_is_named() -> None:
    values = VALUES.copy()
    values[load_definitions().ids["screw.csj_Nm"]] = np.nan
    for call in (
        lambda: library().simulate(values, OPTIONS, np.zeros(100)),
        lambda: library().check(values, OPTIONS),
        lambda: library().objective(values, OPTIONS, np.zeros(100), np.zeros((100, 4))),
        lambda: library().identify(values, OPTIONS, np.zeros(100), np.zeros((100, 4))),
    ):
        with pytest.raises(InputError, match=r"screw.csj_Nm: a value is NaN or infinite"):
            call()
    stiff, _ = reference_actuator().changed({"motor.inductance_H": 1e-9}).arrays()
    with pytest.raises(InputError, match=r"simulate: motor.inductance_H: so small that .* the step is too long for a time constant"):
        library().simulate(stiff, OPTIONS, np.zeros(100))


def test_sample_that_cannot_be_taken_is_counted() -> None:
    record = chirp_record()
    channels = record.table()
    channels[41, 0] = np.nan
    with pytest.raises(InputError, match="identify: sample 42 of the record: a value is NaN or infinite"):
        library(32).identify(VALUES, OPTIONS, record.command_mm, channels)
    with pytest.raises(InputError, match="identify: the record is too short"):
        library(32).identify(VALUES, OPTIONS, record.command_mm[:50], record.table()[:50])


def test_progress_sees_the_search_and_can_end_it() -> None:
    record = chirp_record(reference_actuator().changed({"screw.csj_Nm": 0.2}))
    seen: list[tuple[int, float, float, tuple[float, ...]]] = []
    annealer = SearchSettings(search="annealer")
    answer = library(32).identify(VALUES, OPTIONS, record.command_mm, record.table(), annealer, lambda *what: seen.append(what))
    bests = [best for _, _, best, _ in seen]
    assert bests == sorted(bests, reverse=True)
    assert [run for run, *_ in seen] == sorted({run for run, *_ in seen})
    assert 0.95 * answer.evaluations <= len(seen) <= answer.evaluations
    # what was tried has the cost that was told, and the best of it is the answer
    known = {run: (cost, tried) for run, cost, _, tried in seen if tried}
    assert len(known) >= 0.95 * len(seen)
    assert known[1][1] == pytest.approx((reference_actuator()["screw.csj_Nm"], reference_actuator()["screw.blk_mm"]), rel=1e-6)
    best_cost, best = min(known.values())
    assert best == pytest.approx([one.estimate for one in answer.identified], rel=1e-6)
    again = reference_actuator().changed({one.name: value for one, value in zip(answer.identified, best, strict=True)})
    assert library(32).objective(*again.arrays(), record.command_mm, record.table()) == pytest.approx(best_cost, rel=0.2, abs=1e-12)

    class Enough(Exception):
        pass

    def stop(run: int, _cost: float, _best: float, _tried: tuple[float, ...]) -> None:
        if run >= 10:
            raise Enough

    with pytest.raises(Enough):
        library(32).identify(VALUES, OPTIONS, record.command_mm, record.table(), None, stop)


def test_progress_sees_the_best_points_of_the_least_squares() -> None:
    record = chirp_record(reference_actuator().changed({"screw.csj_Nm": 0.2}))
    seen: list[tuple[int, float, float, tuple[float, ...]]] = []
    answer = library(32).identify(VALUES, OPTIONS, record.command_mm, record.table(), None, lambda *what: seen.append(what))
    assert answer.stage == "least_squares"
    # three model runs side by side
    assert [run for run, *_ in seen] == list(range(3, answer.evaluations + 1, 3))
    costs = [cost for _, cost, _, _ in seen]
    assert costs == sorted(costs, reverse=True) and costs[-1] == pytest.approx(answer.objective_after)
    assert seen[-1][3] == pytest.approx([one.estimate for one in answer.identified], rel=1e-6)


def test_slices_and_threads_change_nothing() -> None:
    record = chirp_record(reference_actuator().changed({"screw.csj_Nm": 0.2}))
    answers = each(
        lambda steps: library(32).identify(VALUES, OPTIONS, record.command_mm, record.table(), SearchSettings(slice_steps=steps)),
        [1, 777, 100_000, 777],
    )
    assert len(set(answers)) == 1


def test_search_takes_its_settings() -> None:
    record = chirp_record(reference_actuator().changed({"screw.csj_Nm": 0.2}))
    answer = library().identify(
        VALUES,
        OPTIONS,
        record.command_mm,
        record.table(),
        SearchSettings(identified=("screw.csj_Nm",), lower=(0.1,), upper=(0.3,), start=(0.25,), evaluation_budget=150),
    )
    assert [estimate.name for estimate in answer.identified] == ["screw.csj_Nm"]
    assert answer.identified[0].estimate == pytest.approx(0.2, abs=1e-5)
    assert answer.evaluations <= 155
    short = library().identify(VALUES, OPTIONS, record.command_mm, record.table(), SearchSettings(evaluation_budget=5))
    assert short.outcome == "budget"
    assert short.verdict == "undecided"
    assert any("used up" in reason for reason in short.reasons)


def test_first_exception_of_parallel_work_is_raised_and_order_is_kept() -> None:
    counted: list[int] = []
    assert each(lambda item: item * item, list(range(20)), counted.append) == [item * item for item in range(20)]
    assert counted == list(range(1, 21))
    with pytest.raises(ZeroDivisionError):
        each(lambda item: 1 // item, [1, 0, 2])


def test_many_runs_are_single_runs_and_a_refused_one_leaves_the_others_alone() -> None:
    command = chirp_record().command_mm
    values = np.array([VALUES, VALUES, VALUES])
    values[1, load_definitions().ids["screw.csj_Nm"]] = np.nan
    values[2, load_definitions().ids["screw.csj_Nm"]] *= 1.5
    first, refused, last = library().simulate_many(values, OPTIONS, command, ("current_A", "position_mm"))
    with pytest.raises(InputError) as single:
        library().simulate(values[1], OPTIONS, command)
    assert isinstance(refused, InputError)
    assert str(refused) == str(single.value)
    for many, row in ((first, values[0]), (last, values[2])):
        alone = library().simulate(row, OPTIONS, command)
        assert isinstance(many, np.ndarray)
        assert many.tobytes() == np.array([alone.current_A, alone.position_mm]).tobytes()
