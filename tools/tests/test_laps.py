"""Laps of a record: found by its command, divided into parts of which each is held out once."""

from __future__ import annotations

import numpy as np
import pytest

from ema_tools.data.records import Record
from ema_tools.fit.laps import difference, laps_of, period_of
from support import chirp_record


def record_of(command: np.ndarray) -> Record:
    return Record(period_s=1e-3, command_mm=command, position_mm=command)


@pytest.mark.parametrize("laps", [2.0, 3.4, 3.9, 7.0])
def test_period_is_that_of_the_command(laps: float) -> None:
    time = np.arange(round(laps * 1700)) / 1700.0
    command = 20.0 * np.sin(2.0 * np.pi * time) + 5.0 * np.sin(6.0 * np.pi * time + 1.0)
    assert period_of(command) == 1700
    found = laps_of(record_of(command))
    assert found.period_rows == 1700
    assert found.count == {2.0: 2, 3.4: 3, 3.9: 4, 7.0: 7}[laps]
    assert found.folds == min(4, found.count)
    assert found.fold[0] == 0
    assert found.fold[-1] == found.folds - 1
    whole = found.complete(command)
    assert whole.shape == (int(laps), 1700)
    assert whole[0] == pytest.approx(whole[-1], abs=1e-9)


def test_sweep_has_no_laps_but_parts() -> None:
    record = chirp_record()
    found = laps_of(record)
    assert found.period_rows == 0
    assert np.array_equal(np.bincount(found.fold), np.full(4, record.rows // 4))
    assert found.complete(record.command_mm).size == 0
    assert period_of(np.ones(100)) == 0


def test_difference_is_the_plain_sum() -> None:
    values = np.random.default_rng(1).normal(size=200)
    found = difference(values)
    centred = values - values.mean()
    for lag in (0, 1, 17, 100):
        expected = np.mean((centred[lag:] - centred[: values.size - lag]) ** 2) / (2.0 * np.mean(centred**2))
        assert found[lag] == pytest.approx(expected, abs=1e-9)
