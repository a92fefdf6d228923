"""One effect that began, told as such and not as the several base values that it looks like; changes that are several stay so; and a healthy record that is not healthy is named."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest

from ema_tools.base.arrays import Reals
from ema_tools.base.errors import InputError
from ema_tools.data.actuator import Actuator
from ema_tools.data.motion_records import MotionRecord, read_motion_record
from ema_tools.select.healthy_balance import HealthyByBalance, healthy_machine
from ema_tools.tasks.diagnose_by_balance import BalanceAnswer, answer_against, answer_by_balance, gates_of
from shared_results import shared_result
from test_value_changes import CONSTANT, DRY, INERTIA, NOISE_A, PERIOD_S, VISCOUS, sheet, speed, stated  # noqa: F401 - a fixture

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
    sheet: Actuator,  # noqa: F811
    today: dict[str, float],
    effect: str,
) -> None:
    """Base values that are free beside nothing take most of it up: more drag and less friction, or inertia, friction and load."""
    found = _answered(sheet, tmp_path, **today)
    assert ([step.effect for step in found.accepted], found.changed) == ([effect], ())


def test_several_values_that_changed_are_no_effect(tmp_path: Path, sheet: Actuator) -> None:  # noqa: F811
    found = _answered(sheet, tmp_path, dry=1.3, drag=1.8)
    assert found.accepted == ()
    assert {one.name for one in found.changed} == {"screw.csj_Nm", "screw.viscous_Nm_s_per_rad"}


@pytest.mark.slow
def test_one_of_the_healthy_records_that_is_not_is_named(tmp_path: Path, sheet: Actuator) -> None:  # noqa: F811
    """Its friction was scatter, and hid as much in today's."""
    healthy = [*(_record(tmp_path, seed) for seed in range(3)), _record(tmp_path, 7, dry=1.3)]
    with pytest.raises(
        InputError, match=r"^day_7\.csv: not of the same state as day_0\.csv, day_1\.csv, day_2\.csv: friction \(CSJ\) differs by \+\d\d %"
    ):
        answer_by_balance(sheet, [_record(tmp_path, 50, dry=1.3)], healthy=healthy)
    even = [_record(tmp_path, 10 + place, dry=share) for place, share in enumerate((0.9, 0.97, 1.04, 1.11))]
    assert answer_by_balance(sheet, [_record(tmp_path, 51)], healthy=even).changed == ()
