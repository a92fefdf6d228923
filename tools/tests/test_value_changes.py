"""What has changed of a machine without a controller, on records written down here: one value at a time, all of the drive at once, nothing where other motion
is all that differs, and one effect that began instead of the several values that it looks like."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest

from ema_tools.base.arrays import Reals
from ema_tools.base.errors import InputError
from ema_tools.data.actuator import Actuator, read_actuator
from ema_tools.data.motion_records import MotionRecord, read_motion_record, same_samples
from ema_tools.select.healthy_balance import HealthyByBalance, healthy_machine
from ema_tools.tasks.diagnose_by_balance import BalanceAnswer, answer_against, answer_by_balance, gates_of
from ema_tools.words.sentences.balance import sentence
from shared_results import shared_result

PERIOD_S = 0.002
INERTIA, VISCOUS, DRY, CONSTANT = 3e-4, 5e-4, 0.2, 0.5
FRICTION_SCATTER, NOISE_A = 0.01, 0.02
SLOW_RAD_S = 12.0


def speed(seed: int, steady: bool) -> Reals:
    """Moves both ways at several speeds, rad/s, or at one speed alone: what friction and drag do there is the same."""
    random = np.random.default_rng(seed)
    asked: list[Reals] = []
    one = float(random.uniform(30.0, 60.0))
    for k in range(14):
        fast = one if steady else float(random.uniform(8.0, 80.0))
        asked.append(np.full(int(random.integers(250, 400)), fast if k % 2 else -fast))
    smooth = np.hanning(61)
    return np.convolve(np.concatenate(asked), smooth / smooth.sum(), mode="same")


def record(
    folder: Path,
    seed: int,
    *,
    steady: bool = False,
    dry: float = DRY,
    viscous: float = VISCOUS,
    constant: float = CONSTANT,
    load: float = 0.0,
    rise: float = 0.0,
    scatter: float = FRICTION_SCATTER,
) -> MotionRecord:
    """One record of the machine, whose friction differs from record to record, and which may carry a load, or stick more the slower it is."""
    random = np.random.default_rng(1000 + seed)
    moves = speed(seed, steady)
    level = dry * (1.0 + scatter * random.normal()) * (1.0 + rise * np.exp(-((moves / SLOW_RAD_S) ** 2)))
    torque = INERTIA * np.gradient(moves, PERIOD_S) + viscous * moves + level * np.sign(moves) + load
    current = torque / constant + NOISE_A * random.normal(size=moves.size)
    path = folder / f"run_{seed}.csv"
    rows = np.column_stack([PERIOD_S * np.arange(moves.size), moves, current])
    np.savetxt(path, rows, delimiter=",", header="time_s,motor_speed_rad_s,current_A", comments="")
    return read_motion_record(path)


@pytest.fixture
def sheet(tmp_path: Path) -> Actuator:
    return stated(tmp_path)


def stated(folder: Path) -> Actuator:
    """What is known of the machine."""
    path = folder / "actuator.toml"
    path.write_text(
        f"[motor]\ntorque_constant_Nm_per_A = {CONSTANT}\n\n[screw]\ninertia_kgm2 = {INERTIA}\nviscous_Nm_s_per_rad = 4e-4\ncsj_Nm = 0.18\n",
        encoding="utf-8",
    )
    return read_actuator(path, complete=False)


@shared_result
def healthy() -> HealthyByBalance:
    """The machine by five healthy records, once for all tests."""
    with TemporaryDirectory() as name:
        return healthy_machine(stated(Path(name)), [record(Path(name), seed) for seed in range(5)])


def answered(sheet: Actuator, today: list[MotionRecord]) -> BalanceAnswer:
    return answer_against(healthy(), today, (), gates_of(sheet, today))


def shares(found: BalanceAnswer) -> dict[str, float]:
    return {one.name: one.today / one.healthy - 1.0 for one in found.changed}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("changed", "name", "share"),
    [
        ({"dry": 1.25 * DRY}, "screw.csj_Nm", 0.25),
        ({"viscous": 1.8 * VISCOUS}, "screw.viscous_Nm_s_per_rad", 0.8),
        ({"constant": 0.9 * CONSTANT}, "motor.torque_constant_Nm_per_A", -0.1),
    ],
)
def test_the_value_that_changed_is_told_and_no_other(
    tmp_path: Path, sheet: Actuator, changed: dict[str, float], name: str, share: float
) -> None:
    found = answered(sheet, [record(tmp_path, seed, **changed) for seed in (50, 51, 52)])
    assert (found.verdict, set(shares(found))) == ("adequate", {name})
    # three records of a friction that scatters by 1 %
    assert shares(found)[name] == pytest.approx(share, abs=0.03 if name != "screw.viscous_Nm_s_per_rad" else 0.15)


@pytest.mark.slow
def test_a_standing_load_that_doubles_is_a_value_that_changed(tmp_path: Path, sheet: Actuator) -> None:
    """It was an effect of today, beside which friction, inertia and drive had all changed."""
    healthy = [record(tmp_path, seed, load=0.08) for seed in range(5)]
    found = answer_by_balance(sheet, [record(tmp_path, seed, load=0.16) for seed in (50, 51, 52)], healthy=healthy)
    assert (found.verdict, [step.effect for step in found.forces.steps]) == ("adequate", [])
    assert shares(found) == {"constant_load.torque_Nm": pytest.approx(1.0, abs=0.05)}
    # a load scatters by less than friction, which hid a fifth of it
    found = answer_by_balance(sheet, [record(tmp_path, seed, load=0.096) for seed in (53, 54, 55)], healthy=healthy)
    assert shares(found) == {"constant_load.torque_Nm": pytest.approx(0.2, abs=0.05)}
    found = answer_by_balance(sheet, [record(tmp_path, seed, load=0.08) for seed in (56, 57, 58)], healthy=healthy)
    assert (found.verdict, shares(found)) == ("adequate", {})
    # a motor that makes less torque changes the load by the same share as all else, which alone lies below its limit
    found = answer_by_balance(
        sheet, [record(tmp_path, seed, load=0.08, constant=0.92 * CONSTANT) for seed in (59, 60, 61)], healthy=healthy
    )
    assert "constant_load.torque_Nm" not in shares(found)


@pytest.mark.release
def test_a_motor_that_makes_less_torque_is_no_effect_beside_standing_ones(tmp_path: Path, sheet: Actuator) -> None:
    """What sticks and what loads is as much more of the drive as all the rest."""
    standing = {"load": 0.06, "rise": 0.8}
    healthy = [record(tmp_path, seed, **standing) for seed in range(5)]
    found = answer_by_balance(
        sheet, [record(tmp_path, seed, constant=0.9 * CONSTANT, **standing) for seed in (50, 51, 52)], healthy=healthy
    )
    assert found.healthy is not None and len(found.healthy.standing) == 2
    assert (found.verdict, [step.effect for step in found.forces.steps]) == ("adequate", [])
    assert shares(found) == {"motor.torque_constant_Nm_per_A": pytest.approx(-0.1, abs=0.02)}
    # by the healthy machine a tenth of the drive is left, whatever the drive is taken for afterwards
    assert found.forces.given.training == pytest.approx(10.0, abs=2.0)


@pytest.mark.slow
def test_an_unchanged_machine_is_told_unchanged(tmp_path: Path, sheet: Actuator) -> None:
    found = answered(sheet, [record(tmp_path, seed) for seed in (60, 61, 62)])
    assert (found.verdict, shares(found)) == ("adequate", {})
    assert not found.untold


@pytest.mark.slow
def test_motion_that_the_healthy_records_do_not_tell_is_no_change(tmp_path: Path, sheet: Actuator) -> None:
    healthy = [record(tmp_path, seed, steady=True) for seed in range(5)]
    found = answer_by_balance(sheet, [record(tmp_path, seed) for seed in (70, 71, 72)], healthy=healthy)
    assert shares(found) == {}
    assert not found.untold
    # at one speed friction and drag are one: a tenth of the drag is not known, and the torque of faster motion by as much less
    assert found.healthy is not None
    assert found.doubt_Nm > 0.2 * found.healthy.error_Nm


@pytest.mark.release
def test_what_the_machine_has_anyhow_is_no_new_effect_when_it_grows(tmp_path: Path, sheet: Actuator) -> None:
    """The bump at standstill of twice the size: a value that changed, and the error falls with it."""
    healthy = [record(tmp_path, seed, rise=0.8) for seed in range(5)]
    found = answer_by_balance(sheet, [record(tmp_path, seed, rise=1.6) for seed in (50, 51, 52)], healthy=healthy)
    assert (found.verdict, [step.effect for step in found.forces.steps]) == ("adequate", [])
    assert shares(found) == {"stribeck_friction.rise": pytest.approx(1.0, abs=0.15)}
    assert found.last.training < 0.5 * found.forces.given.training


@pytest.mark.slow
def test_two_percent_of_friction_are_another_day_however_alike_few_records_are(tmp_path: Path, sheet: Actuator) -> None:
    healthy = [record(tmp_path, seed, scatter=0.0005) for seed in range(5)]
    found = answer_by_balance(sheet, [record(tmp_path, seed, scatter=0.0005, dry=1.02 * DRY) for seed in (50, 51)], healthy=healthy)
    assert (found.verdict, shares(found), found.untold) == ("adequate", {}, False)


@pytest.mark.slow
def test_what_is_nearest_is_told_where_too_few_records_tell_a_change(tmp_path: Path, sheet: Actuator) -> None:
    healthy = [record(tmp_path, seed, dry=share * DRY) for seed, share in enumerate((0.95, 1.0, 1.05))]
    found = answer_by_balance(sheet, [record(tmp_path, 50, dry=1.2 * DRY)], healthy=healthy)
    assert shares(found) == {}
    assert found.nearest == "screw.csj_Nm"
    assert "friction (CSJ) comes nearest, +" in sentence(found)


@pytest.mark.release
def test_what_stays_beside_a_change_is_told_where_it_is_much(tmp_path: Path, sheet: Actuator) -> None:
    quiet, humming = record(tmp_path, 70, dry=1.4 * DRY), record(tmp_path, 71, dry=1.4 * DRY)
    assert humming.current_A is not None
    hum = 0.03 * np.sin(2.0 * np.pi * 3.3 * humming.time_s)
    assert "stays, more than" not in sentence(answered(sheet, [quiet]))
    found = answered(sheet, [humming.with_columns({"current_A": humming.current_A + hum})])
    assert [one.name for one in found.changed] == ["screw.csj_Nm"]
    assert "stays, more than the healthy records leave" in sentence(found)


def test_much_that_only_an_estimate_calls_chance_is_not_called_adequate(tmp_path: Path, sheet: Actuator) -> None:
    """Where the drive's sensor leaves a tenth, what is missing may hide in it."""
    coarse = []
    for seed in (80, 81):
        fine = record(tmp_path, seed)
        assert fine.current_A is not None
        noise = 0.12 * np.random.default_rng(seed).normal(size=fine.rows)
        coarse.append(replace(fine, current_A=fine.current_A + np.repeat(noise[::25], 25)[: fine.rows]))
    found = answer_by_balance(sheet, coarse)
    assert (found.verdict, found.untellable) == ("unknown", True)
    assert "do not tell whether what is left is chance" in sentence(found)


@pytest.mark.slow
@pytest.mark.parametrize(("share", "little"), [(0.01, True), (0.05, False)])
def test_what_every_lap_has_and_hardly_matters_is_said_and_asks_for_nothing(
    tmp_path: Path, sheet: Actuator, share: float, little: bool
) -> None:
    """A hum that goes with the lap's own time, of no effect's form."""
    lap = speed(90, steady=False)
    moves = np.tile(lap, 5)
    time_s = PERIOD_S * np.arange(moves.size)
    hum = np.tile(np.sin(2.0 * np.pi * 2.3 * time_s[: lap.size]), 5)
    torque = INERTIA * np.gradient(moves, PERIOD_S) + VISCOUS * moves + DRY * np.sign(moves) + share * DRY * hum
    noise = 1e-4 * np.random.default_rng(90).normal(size=moves.size)
    path = tmp_path / "laps.csv"
    rows = np.column_stack([time_s, moves, torque / CONSTANT + noise])
    np.savetxt(path, rows, delimiter=",", header="time_s,motor_speed_rad_s,current_A", comments="")
    found = answer_by_balance(sheet, [read_motion_record(path)])
    assert found.floor_from == "laps" and found.beyond_chance
    assert (found.verdict == "adequate") is little
    assert ("less than 1 % of the drive, too little to ask for" in sentence(found)) is little


@pytest.mark.slow
def test_a_torque_per_current_that_no_magnet_makes_is_another_machines(tmp_path: Path, sheet: Actuator) -> None:
    found = answered(sheet, [record(tmp_path, seed, constant=2.6 * CONSTANT) for seed in (95, 96)])
    assert found.verdict == "unknown"
    assert "as if these were records of another machine" in found.unseen


def test_records_with_no_column_in_common_are_not_one() -> None:
    speed_rad_s, current_A = np.sin(np.arange(100.0)), np.cos(np.arange(100.0))
    one = MotionRecord(PERIOD_S, "one").with_columns({"motor_speed_rad_s": speed_rad_s})
    assert not same_samples(one, MotionRecord(PERIOD_S, "other").with_columns({"current_A": current_A}))
    assert same_samples(one, MotionRecord(PERIOD_S, "copy").with_columns({"motor_speed_rad_s": speed_rad_s, "current_A": current_A}))


_FAST_RAD_S = 80.0
# Friction and drag of one machine on two days, standard deviation relative.
_SCATTER_DRY, _SCATTER_DRAG = 0.01, 0.03


def _record(folder: Path, seed: int, *, dry: float = 1.0, drag: float = 1.0, bends: float = 0.0, bearing: float = 0.0) -> MotionRecord:
    """One record of a machine with a load. `bends`: drag that grows as the square of the speed, `bearing`: friction by what the screw transmits, shares of the friction, and of that."""
    random = np.random.default_rng(2000 + seed)
    moves = speed(seed, steady=False)
    side = np.tanh(moves / 0.05)
    level = dry * DRY * (1.0 + _SCATTER_DRY * random.normal())
    viscous = drag * VISCOUS * (1.0 + _SCATTER_DRAG * random.normal())
    # what the screw transmits moves the load and overcomes what rubs there; friction that grows with it is behind that again
    transmitted: Reals = 0.15 + 0.9 * INERTIA * np.gradient(moves, PERIOD_S) + viscous * moves + level * side
    torque = transmitted + 0.1 * INERTIA * np.gradient(moves, PERIOD_S) + bearing * np.abs(transmitted) * side
    torque += bends * DRY * moves * np.abs(moves) / _FAST_RAD_S**2
    path = folder / f"day_{seed}.csv"
    rows = np.column_stack([PERIOD_S * np.arange(moves.size), moves, torque / CONSTANT + NOISE_A * random.normal(size=moves.size)])
    np.savetxt(path, rows, delimiter=",", header="time_s,motor_speed_rad_s,current_A", comments="")
    return read_motion_record(path)


@shared_result
def _healthy() -> HealthyByBalance:
    """The machine by four healthy records, once for all tests."""
    with TemporaryDirectory() as name:
        return healthy_machine(stated(Path(name)), [_record(Path(name), seed) for seed in range(4)])


def _answered(known: Actuator, folder: Path, **today: float) -> BalanceAnswer:
    records = [_record(folder, seed, **today) for seed in (50, 51)]
    return answer_against(_healthy(), records, (), gates_of(known, records))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("today", "effect"),
    [pytest.param({"bends": 0.5}, "quadratic_viscous", marks=pytest.mark.release), ({"bearing": 0.25}, "load_dependent_friction")],
)
def test_an_effect_that_began_is_not_told_as_the_values_that_it_looks_like(
    tmp_path: Path,
    sheet: Actuator,
    today: dict[str, float],
    effect: str,
) -> None:
    """Base values that are free beside nothing take most of it up: more drag and less friction, or inertia, friction and load."""
    found = _answered(sheet, tmp_path, **today)
    assert ([step.effect for step in found.accepted], found.changed) == ([effect], ())


@pytest.mark.slow
def test_several_values_that_changed_are_no_effect(tmp_path: Path, sheet: Actuator) -> None:
    found = _answered(sheet, tmp_path, dry=1.3, drag=1.8)
    assert found.accepted == ()
    assert {one.name for one in found.changed} == {"screw.csj_Nm", "screw.viscous_Nm_s_per_rad"}


@pytest.mark.slow
def test_one_of_the_healthy_records_that_is_not_is_named(tmp_path: Path, sheet: Actuator) -> None:
    """Its friction was scatter, and hid as much in today's."""
    healthy = [*(_record(tmp_path, seed) for seed in range(3)), _record(tmp_path, 7, dry=1.3)]
    with pytest.raises(
        InputError, match=r"^day_7\.csv: not of the same state as day_0\.csv, day_1\.csv, day_2\.csv: friction \(CSJ\) differs by \+\d\d %"
    ):
        answer_by_balance(sheet, [_record(tmp_path, 50, dry=1.3)], healthy=healthy)
    even = [_record(tmp_path, 10 + place, dry=share) for place, share in enumerate((0.9, 0.97, 1.04, 1.11))]
    assert answer_by_balance(sheet, [_record(tmp_path, 51)], healthy=even).changed == ()
