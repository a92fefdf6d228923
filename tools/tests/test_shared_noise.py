"""A sensor whose noise neighbouring rows share: known from healthy runs, at the desk and in the unit's own model, and no reason to stay undecided."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest
from scipy import signal

from benchmarks.hidden.machines import machine, measured
from benchmarks.hidden.sealed import record_of
from ema_tools.base.arrays import Reals
from ema_tools.data.actuator import reference_actuator
from ema_tools.data.records import Record
from ema_tools.fit.shared_noise import shared_noise
from ema_tools.plant.native import SearchSettings
from ema_tools.tasks.calibrate import calibrate
from ema_tools.tasks.identify import identify
from ema_tools.tasks.onboard_search import SHARED_NOISE, run
from ema_tools.tasks.own_machine import OwnMachine, own_machine
from shared_results import shared_result

ROWS, RUNS, RMS = 10_000, 3, 0.005


def coloured(share: float, seed: int) -> Reals:
    """Noise of RMS whose neighbouring rows share so much, [RUNS, ROWS]."""
    white = np.random.default_rng(seed).normal(size=(RUNS, ROWS + 200))
    return np.asarray(RMS * math.sqrt(1.0 - share**2) * signal.lfilter([1.0], [1.0, -share], white, axis=1)[:, 200:])


def test_white_noise_shares_nothing() -> None:
    assert [shared_noise(coloured(0.0, seed)) for seed in range(20)] == [0.0] * 20


@pytest.mark.parametrize("share", [0.3, 0.83, 0.97])
def test_what_is_shared_is_found_and_another_record_shows_no_more(share: float) -> None:
    true = RMS * math.sqrt(share)
    for seed in range(10):
        found = shared_noise(coloured(share, seed))
        # three standard errors of one record's correlation are added, at most a fifth here
        assert 0.97 * true < found < 1.2 * true
        other = coloured(share, 100 + seed)[0]
        assert math.sqrt(float(np.mean(other[1:] * other[:-1]))) < found


def test_what_comes_and_goes_with_the_motion_is_no_noise() -> None:
    time = np.arange(ROWS) / 1000.0
    bursts = np.where(np.sin(2.0 * np.pi * 0.15 * time) > 0.95, 0.02, 0.0)
    assert shared_noise(coloured(0.0, 1) + bursts) < 0.1 * math.sqrt(float(np.mean(bursts**2)))


def test_few_rows_say_nothing() -> None:
    assert shared_noise(coloured(0.9, 1)[:, :300]) == 0.0


@cache
def runs(worn: bool, count: int, first: int) -> tuple[Record, ...]:
    """Runs of a machine of the truth plant whose position sensors have a filter of 30 Hz."""
    unit = machine(2_501, setting="coloured")
    changes = {"screw.csj_Nm": 1.2 * unit.values["screw.csj_Nm"]} if worn else {}
    return tuple(record_of(measured(unit, changes, "chirp", first + k), k) for k in range(count))


@shared_result
def flown_machine() -> OwnMachine:
    """What its healthy runs make of it, whatever today is."""
    healthy = runs(False, 3, 700)
    own = own_machine(calibrate(reference_actuator(), healthy).actuator, healthy)
    assert own is not None
    return own


@pytest.mark.release
@pytest.mark.parametrize(("worn", "verdict"), [(False, "healthy"), (True, "fault")])
def test_a_unit_with_such_a_sensor_is_judged(worn: bool, verdict: str) -> None:
    healthy, today = runs(False, 3, 700), runs(worn, 1, 750)[0]
    found = identify(reference_actuator(), today, healthy)
    assert found.verdict == verdict
    assert found.healthy[SHARED_NOISE] > 0.0
    own = flown_machine()
    assert own.actuator[SHARED_NOISE] > 0.0
    flown = run(own.actuator, today, SearchSettings(), 32)
    assert (flown.verdict, flown.reasons) == (verdict, ())
    assert run(own.actuator.changed({SHARED_NOISE: 0.0}), today, SearchSettings(), 32).verdict == "undecided"
