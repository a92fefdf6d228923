"""The play between motor and rod by both positions, or by the rod's and the motor's speed, on records written down here: where friction decides the side, where a load does, and what has changed."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from itertools import product
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ema_tools.base.arrays import Reals
from ema_tools.base.interval import WIDTH_95
from ema_tools.base.lag import lagged
from ema_tools.data.actuator import Actuator, read_actuator
from ema_tools.data.motion_records import MotionRecord
from ema_tools.select.play_changes import lag_remarks, play_changes, play_seen, play_value, plays_seen
from ema_tools.tasks.diagnose_by_balance import BalanceAnswer, answer_by_balance
from ema_tools.words.sentences.balance import sentence

PERIOD_S, NOISE_MM = 0.002, 0.002
MM_PER_RAD = 0.8
INERTIA, VISCOUS, DRY, CONSTANT = 2e-3, 2e-3, 0.4, 0.5


def moves(seed: int) -> tuple[Reals, Reals]:
    """Motor position in mm and its rate, with rests."""
    random = np.random.default_rng(seed)
    asked: list[Reals] = []
    for k in range(16):
        speed = float(random.uniform(8.0, 40.0)) * (1.0 if k % 2 else -1.0)
        asked += [np.full(int(random.integers(200, 320)), speed), np.zeros(60)]
    smooth = np.hanning(41)
    rate = np.convolve(np.concatenate(asked), smooth / smooth.sum(), mode="same")
    place = np.cumsum(rate) * PERIOD_S
    return place - np.mean(place), rate


def behind(motor: Reals, width: float) -> Reals:
    """A rod that stays until the play is used up."""
    rod = np.empty_like(motor)
    here = float(motor[0])
    for k, place in enumerate(motor.tolist()):
        here = min(max(here, place - 0.5 * width), place + 0.5 * width)
        rod[k] = here
    return rod


def record(seed: int, width: float, *, by_load: bool = False, dry: float = DRY) -> MotionRecord:
    """One record of both positions and the current; `by_load`: a spring at the rod holds it against one side, on either side of its middle."""
    random = np.random.default_rng(1000 + seed)
    motor, rate = moves(seed)
    rod = motor - 0.5 * width * np.sign(motor) if by_load else behind(motor, width)
    speed = rate / MM_PER_RAD
    torque = INERTIA * np.gradient(speed, PERIOD_S) + VISCOUS * speed + dry * (1.0 + 0.01 * random.normal()) * np.sign(np.round(speed, 3))
    return MotionRecord(
        PERIOD_S,
        f"run_{seed}.csv",
        position_mm=1.0005 * rod + 0.3 + NOISE_MM * random.normal(size=rod.size),
        motor_position_mm=motor,
        current_A=torque / CONSTANT + 0.01 * random.normal(size=rod.size),
    )


@pytest.fixture
def sheet(tmp_path: Path) -> Actuator:
    path = tmp_path / "actuator.toml"
    lead = 2.0 * np.pi * MM_PER_RAD
    path.write_text(
        f"[motor]\ntorque_constant_Nm_per_A = {CONSTANT}\n\n[gearbox]\nratio = 1.0\n\n[screw]\nlead_mm = {lead}\ninertia_kgm2 = {INERTIA}\n"
        "viscous_Nm_s_per_rad = 2e-3\ncsj_Nm = 0.4\n",
        encoding="utf-8",
    )
    return read_actuator(path, complete=False)


@pytest.mark.parametrize("by_load", [False, True], ids=["friction", "load"])
@pytest.mark.parametrize("width", [0.015, 0.03, 0.1])
def test_width_is_seen_whatever_decides_the_side(sheet: Actuator, width: float, by_load: bool) -> None:
    found = play_seen(sheet, record(1, width, by_load=by_load))
    assert found is not None
    # a tenth of the sensor's noise, which thousands of rows average
    assert found.width_mm == pytest.approx(width, abs=0.0006, rel=0.02)
    assert found.left_mm == pytest.approx(NOISE_MM, rel=0.1)


def test_no_play_is_told_of_other_signals(sheet: Actuator) -> None:
    there = record(1, 0.03)
    alone = MotionRecord(PERIOD_S, "alone.csv", position_mm=there.position_mm, current_A=there.current_A)
    assert play_seen(sheet, alone) is None
    assert there.motor_position_mm is not None
    # of another axis
    other = MotionRecord(PERIOD_S, "other.csv", position_mm=there.motor_position_mm[::-1].copy(), motor_position_mm=there.motor_position_mm)
    assert play_seen(sheet, other) is None


def answered(sheet: Actuator, today: list[MotionRecord]) -> BalanceAnswer:
    return answer_by_balance(sheet, today, healthy=[record(seed, 0.03) for seed in range(4)])


@pytest.mark.slow
def test_a_play_that_has_grown_is_told_and_nothing_else(sheet: Actuator) -> None:
    found = answered(sheet, [record(seed, 0.06) for seed in (50, 51)])
    (change,) = found.changed
    assert (found.verdict, change.name) == ("adequate", "screw.blk_mm")
    assert (change.healthy, change.today) == (pytest.approx(0.03, rel=0.03), pytest.approx(0.06, rel=0.03))
    assert abs(change.today - change.healthy - 0.03) < 1.96 * change.std
    assert any(one.name == "screw.blk_mm" and one.by_import and one.value == pytest.approx(0.03, rel=0.03) for one in found.base)


@pytest.mark.release
def test_a_play_that_is_the_same_is_no_change_beside_more_friction(sheet: Actuator) -> None:
    found = answered(sheet, [record(seed, 0.031, dry=1.3 * DRY) for seed in (60, 61)])
    assert [one.name for one in found.changed] == ["screw.csj_Nm"]


RPM = 2.0 * np.pi / 60.0
KINDS = ("sine", "sweep", "pick and place")


def rate_of(kind: str, random: np.random.Generator) -> Reals:
    """The motor's rate in mm/s; at `one speed` a lag of it and a play behind friction look alike."""
    time, scale = np.arange(0.0, 16.0, PERIOD_S), float(random.uniform(0.7, 1.3))
    if kind == "sine":
        return 25.0 * scale * np.cos(2.0 * np.pi * float(random.uniform(0.3, 0.6)) * time)
    if kind == "sweep":
        return 11.0 * scale * np.cos(2.0 * np.pi * (0.15 * time + 0.5 * 2.85 * time**2 / 16.0))
    asked: list[Reals] = []
    for k in range(16):
        speed = 20.0 * scale if kind == "one speed" else float(random.uniform(8.0, 40.0))
        asked += [np.full(int(random.integers(200, 320)), speed if k % 2 else -speed), np.zeros(0 if kind == "one speed" else 60)]
    smooth = np.hanning(41)
    return np.convolve(np.concatenate(asked), smooth / smooth.sum(), mode="same")


def of_speed(
    seed: int,
    width: float,
    kind: str,
    *,
    rpm: float = 0.1,
    lag_s: float = 0.002,
    offset_rpm: float = 0.0,
    by_load: bool = False,
    poles: int = 1,
    noise_rad_s: float = 0.02,
) -> MotionRecord:
    """One record of the rod's position and the motor's speed, which the drive filters, rounds to `rpm` and reads wrongly by an offset."""
    random = np.random.default_rng(seed)
    rate = rate_of(kind, random)
    motor = np.cumsum(rate) * PERIOD_S
    motor -= np.mean(motor)
    rod = motor - 0.5 * width * np.sign(motor) if by_load else behind(motor, width)
    speed = rate / MM_PER_RAD
    for _ in range(poles):
        speed = lagged(speed, PERIOD_S, lag_s / poles)
    speed = speed + offset_rpm * RPM + noise_rad_s * random.normal(size=speed.size)
    return MotionRecord(
        PERIOD_S,
        f"speed_{seed}.csv",
        position_mm=1.0005 * rod + 0.3 + NOISE_MM * random.normal(size=rod.size),
        motor_speed_rad_s=np.round(speed / (rpm * RPM)) * (rpm * RPM),
        current_A=0.1 * np.sign(rate),
    )


def some(cases: Iterable[tuple[Any, ...]], quick: Collection[tuple[Any, ...]]) -> list[Any]:
    """All cases, those that are not `quick` for the long suite."""
    return [pytest.param(*case, marks=() if case in quick else pytest.mark.slow) for case in cases]


@pytest.mark.parametrize(
    ("width", "kind"), some(product((0.0, 0.024, 0.08), KINDS), [(0.0, "pick and place"), (0.024, "sweep"), (0.08, "pick and place")])
)
def test_interval_of_the_width_holds_beside_an_integrated_speed(sheet: Actuator, width: float, kind: str) -> None:
    cases = product((0.1, 1.0), (0.002, 0.01), (0.0, 0.5), (False, True))
    for number, (rpm, lag_s, offset_rpm, by_load) in enumerate(cases, 1):
        seen = play_seen(sheet, of_speed(number, width, kind, rpm=rpm, lag_s=lag_s, offset_rpm=offset_rpm, by_load=by_load))
        assert seen is not None
        (told,) = play_value(sheet, [seen])
        # a play of none cannot be read as less, so that all its error is to one side
        assert abs(told.value - width) < WIDTH_95 * told.std, (rpm, lag_s, offset_rpm, by_load, told)
        # a turn a minute is 0.04 mm in half a second that noise hardly blurs
        assert told.std < (0.003 if rpm < 1.0 else 0.009) + 0.1 * width, (rpm, lag_s, offset_rpm, by_load, told)


def test_speed_without_noise_that_is_rounded_coarsely_is_told_with_more_doubt(sheet: Actuator) -> None:
    fine, coarse = (play_seen(sheet, of_speed(3, 0.024, "pick and place", rpm=rpm, noise_rad_s=0.0)) for rpm in (0.1, 1.0))
    assert fine is not None and coarse is not None
    assert coarse.drift_mm > 3.0 * fine.drift_mm
    assert abs(coarse.width_mm - 0.024) < WIDTH_95 * play_value(sheet, [coarse])[0].std


@pytest.mark.parametrize("lag_s", [0.002, 0.01])
@pytest.mark.parametrize("width", [0.0, 0.024, 0.08])
def test_nothing_is_told_where_a_lag_looks_like_a_play(sheet: Actuator, width: float, lag_s: float) -> None:
    # the motor runs at one speed both ways
    assert play_seen(sheet, of_speed(7, width, "one speed", lag_s=lag_s)) is None


def test_speed_of_the_rod_is_none_of_the_motor(sheet: Actuator) -> None:
    there = of_speed(1, 0.03, "sine")
    at_rod = there.with_columns({"motor_speed_rad_s": None, "speed_mm_s": MM_PER_RAD * there.recorded("motor_speed_rad_s")})
    assert play_seen(sheet, at_rod) is None
    # a recorded position counts more than an integral
    both = play_seen(sheet, there.with_columns({"motor_position_mm": there.recorded("position_mm")}))
    assert both is not None and (both.width_mm, both.drift_mm) == (pytest.approx(0.0, abs=1e-6), 0.0)


def late(seed: int, width: float, lag_s: float, kind: str) -> MotionRecord:
    """One record of both positions, of which the rod's is read late."""
    random = np.random.default_rng(seed)
    rate = rate_of(kind, random)
    motor = np.cumsum(rate) * PERIOD_S
    motor -= np.mean(motor)
    time = np.arange(motor.size) * PERIOD_S
    rod = np.interp(time - lag_s, time, behind(motor, width))
    return MotionRecord(
        PERIOD_S,
        f"late_{seed}.csv",
        position_mm=1.0005 * rod + 0.3 + NOISE_MM * random.normal(size=rod.size),
        motor_position_mm=motor + 0.25 * NOISE_MM * random.normal(size=rod.size),
        current_A=0.1 * np.sign(rate),
    )


@pytest.mark.parametrize(
    ("kind", "width"),
    some(product(("sweep", "pick and place"), (0.0, 0.02, 0.1, 0.5)), [("sweep", 0.0), ("pick and place", 0.02), ("sweep", 0.5)]),
)
def test_a_lag_between_two_encoders_is_no_play_and_both_are_read(sheet: Actuator, kind: str, width: float) -> None:
    for number, lag_s in enumerate((-0.003, 0.0, 0.001, 0.003, 0.005)):
        seen = play_seen(sheet, late(number, width, lag_s, kind))
        assert seen is not None
        (told,) = play_value(sheet, [seen])
        assert abs(told.value - width) < WIDTH_95 * told.std and told.std < 0.001 + 0.1 * width, (lag_s, told)
        assert abs(seen.lag_s - lag_s) < WIDTH_95 * seen.lag_std_s < 0.0003, (lag_s, seen)
        assert bool(lag_remarks([seen])) == (lag_s != 0.0)


def test_a_play_is_not_told_from_a_lag_at_one_speed_but_its_change_is(sheet: Actuator) -> None:
    before, after = (plays_seen(sheet, [late(seed, width, 0.002, "one speed") for seed in range(3)]) for width in (0.02, 0.05))
    assert play_value(sheet, before) == ()
    assert np.mean([one.width_mm for one in after]) - np.mean([one.width_mm for one in before]) == pytest.approx(0.03, rel=0.1)


def changed(sheet: Actuator, before: float, today: float, seed: int, **drive: Any) -> Any:
    """What is told of one machine with plays of `before` and `today`, motions of all kinds and a drive that filters otherwise today; None where nothing is."""
    machine: Any = SimpleNamespace(actuator=sheet, times=3.0)
    healthy = plays_seen(sheet, [of_speed(seed + k, before, kind, **drive) for k, kind in enumerate((*KINDS, "sine"))])
    otherwise = {**drive, "lag_s": 0.01, "poles": 2}
    after = plays_seen(sheet, [of_speed(seed + 10 + k, today, kind, **otherwise) for k, kind in enumerate(("sweep", "pick and place"))])
    found = play_changes(machine, healthy, after)
    return found[0] if found else None


@pytest.mark.parametrize(
    ("width", "rpm", "by_load"),
    some(product((0.0, 0.024, 0.08), (0.1, 1.0), (False, True)), [(0.0, 0.1, False), (0.024, 1.0, True), (0.08, 0.1, True)]),
)
def test_only_a_play_that_has_grown_is_a_change_by_the_speed(sheet: Actuator, width: float, rpm: float, by_load: bool) -> None:
    same = changed(sheet, width, width, 100, rpm=rpm, by_load=by_load)
    assert same is not None and not same.counts
    grown = changed(sheet, width, width + 0.056, 100, rpm=rpm, by_load=by_load)
    assert grown is not None and grown.counts
    assert abs(grown.today - grown.healthy - 0.056) < WIDTH_95 * grown.std


@pytest.mark.slow
def test_a_play_that_nobody_stated_is_said_with_the_verdict(sheet: Actuator) -> None:
    said = [sentence(answer_by_balance(sheet, [record(seed, width) for seed in range(2)])) for width in (0.12, 0.0)]
    assert "show a play (BLK) of 0.12 mm" in said[0] and "write screw.blk_mm = 0.12" in said[0], said[0]
    assert "BLK" not in said[1], said[1]
