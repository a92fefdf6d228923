"""Friction behind a load that is several times larger: an arm's weight over a part of its turn, on machines whose controller nobody knows."""

from __future__ import annotations

import itertools
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.machines.trials import ALWAYS, MachineTrial, actuator_of, perform
from ema_tools.base.progress import untold
from ema_tools.data.actuator import Actuator
from ema_tools.data.motion_records import MotionRecord
from ema_tools.select.balance_bench import Bench, floor_of
from ema_tools.select.force_balance import NOT_SIMULATED, UNSOUGHT, ForceSearch, _in_model, improve_by_forces
from ema_tools.select.force_refit import add_by_forces
from ema_tools.select.force_steps import ForceStep, ForceSteps, Tried
from ema_tools.tasks.diagnose_by_balance import BalanceAnswer, answer_by_balance
from ema_tools.tasks.method import diagnosed
from ema_tools.words.sentences.balance import sentence
from shared_results import shared_result

INERTIA, VISCOUS, CSJ, LOAD = "screw.inertia_kgm2", "screw.viscous_Nm_s_per_rad", "screw.csj_Nm", "screw.load_torque_Nm"
RATIO, DRY_NM, WEIGHT_NM = 80.0, 0.05, 0.2


def joint() -> Actuator:
    """An arm behind a gear, as its data sheet has it."""
    named = actuator_of("lead screw", 0).changed({INERTIA: 2e-4, VISCOUS: 3e-4, CSJ: 0.06, LOAD: 0.0})
    return named.changed({"gearbox.ratio": RATIO, "screw.lead_mm": 360.0}).with_drive_lag(0.0)


def swung(
    seed: int,
    rise: float = 0.0,
    share: float = 0.0,
    load_Nm: float = 0.0,
    dry_Nm: float = DRY_NM,
    hum_Nm: float = 0.0,
    phase_rad: float = 0.4,
    heavier: float = 1.0,
) -> MotionRecord:
    """Sixteen seconds of an arm whose weight is four times its dry friction. `heavier`: its weight, of the healthy one's; `share`: of the motor's torque that is friction; `rise`: of dry friction at
    standstill."""
    random, time = np.random.default_rng(seed), np.arange(4000) * 4e-3
    angle = sum(
        size * np.sin(2.0 * np.pi * hz * (1.0 + 0.05 * seed) * time + random.uniform(0.0, 6.0))
        for hz, size in ((0.15, 40.0), (0.4, 14.0), (0.9, 5.0), (1.7, 1.5))
    )
    speed = np.gradient(angle, 4e-3)
    way = np.sign(speed)
    asked = 2e-4 * np.gradient(speed, 4e-3) + heavier * WEIGHT_NM * np.sin(angle / RATIO + phase_rad) + load_Nm
    level = dry_Nm * (1.0 + rise * np.exp(-np.abs(speed) / 8.0))
    torque = asked + 3e-4 * speed + level * way
    for _ in range(30 if share else 0):
        torque = asked + 3e-4 * speed + (level + share * np.abs(torque)) * way
    torque = torque + hum_Nm * np.sin(2.0 * np.pi * 1.3 * time + seed)
    return MotionRecord(4e-3, f"arm_{seed}.csv").with_columns(
        {"motor_angle_rad": angle, "motor_speed_rad_s": speed, "torque_Nm": torque + random.normal(0.0, 2e-3, time.size)}
    )


@shared_result
def found(**made: float) -> ForceSteps:
    return improve_by_forces(joint(), [swung(seed, **made) for seed in range(4)])


@pytest.mark.slow
def test_a_weight_alone_is_one_and_nothing_is_accused() -> None:
    steps = found().steps
    (weight,) = steps
    assert weight.values[f"{weight.effect}.amplitude_Nm"] == pytest.approx(WEIGHT_NM, rel=0.03)
    assert weight.values[f"{weight.effect}.periods"] == pytest.approx(1.0 / RATIO)
    # and the inertia, which the weight hid
    assert weight.values[INERTIA] == pytest.approx(2e-4, rel=0.02)


@pytest.mark.slow
def test_friction_that_rises_at_standstill_is_found_behind_a_weight() -> None:
    """It takes off less than a hundredth of what the first model leaves, which is the weight."""
    answer = found(rise=0.5)
    assert [step.effect for step in answer.steps] == ["cogging_torque", "stribeck_friction"]
    before, after = (step.errors.training for step in answer.steps)
    assert before**2 - after**2 < 0.02 * answer.refitted.training**2
    assert answer.steps[-1].values["stribeck_friction.rise"] == pytest.approx(0.5, rel=0.2)


@pytest.mark.slow
def test_friction_of_the_torque_that_is_transmitted_is_found_behind_a_weight() -> None:
    """The weight is most of that torque, which a drive foretold from inertia and friction alone does not hold; and with the stated inertia the effect stands in for another one."""
    answer = improve_by_forces(joint().changed({INERTIA: 2.3e-4}), [swung(seed, share=0.15) for seed in range(4)])
    assert [step.effect for step in answer.steps] == ["cogging_torque", "load_dependent_friction"]
    last = answer.steps[-1].values
    assert last["load_dependent_friction.ratio"] == pytest.approx(0.15, rel=0.1)
    assert last["cogging_torque.amplitude_Nm"] == pytest.approx(WEIGHT_NM, rel=0.05)
    assert last[INERTIA] == pytest.approx(2e-4, rel=0.05)
    # and asked for alone it is counted as there
    model = joint().changed(
        {"cogging_torque.amplitude_Nm": WEIGHT_NM, "cogging_torque.periods": 1.0 / RATIO, "cogging_torque.phase_rad": 0.4}
    )
    one = add_by_forces(model, "load_dependent_friction", [swung(seed, share=0.15) for seed in range(4)])
    assert not one.reason
    assert one.errors.training == pytest.approx(answer.steps[-1].errors.training, rel=1e-3)
    assert one.values["load_dependent_friction.ratio"] == pytest.approx(last["load_dependent_friction.ratio"], rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("heavier", [1.0, pytest.param(1.2, marks=pytest.mark.release), pytest.param(1.4, marks=pytest.mark.release)])
def test_a_heavier_arm_is_one_value_and_not_three(heavier: float) -> None:
    """It was a motor with less torque, and less inertia and friction by the same share, which does as much."""
    healthy, sheet = [swung(seed) for seed in range(4)], joint()
    answer = answer_by_balance(sheet, [swung(seed, heavier=heavier) for seed in (10, 11)], healthy=healthy)
    changed = {one.name: one.today / one.healthy - 1.0 for one in answer.changed}
    assert answer.verdict == "adequate"
    assert len(changed) == (heavier > 1.0) and all(name.endswith("amplitude_Nm") for name in changed)
    assert list(changed.values()) == [pytest.approx(heavier - 1.0, abs=0.03)] * len(changed)


@pytest.mark.slow
def test_a_constant_torque_is_asked_again_beside_a_weight() -> None:
    """Friction that is larger one way is the same torque at any motion; a weight over a part of its turn hides it at first."""
    steps = found(load_Nm=0.01, phase_rad=0.0).steps
    assert [step.effect for step in steps] == ["cogging_torque", "constant_load"]
    assert "coulomb_asymmetry" in steps[-1].alike
    assert steps[-1].values["constant_load.torque_Nm"] == pytest.approx(0.01, abs=3.0 * steps[-1].std["constant_load.torque_Nm"])


@pytest.mark.slow
def test_a_constant_torque_that_stood_in_for_a_spring_is_gone_beside_it() -> None:
    accepted = perform(MachineTrial("ball screw", 0, "start and stop", "spring_load", "large"))["accepted"]
    assert [name for name in accepted if name not in ALWAYS] == ["spring_load"]


@pytest.mark.slow
def test_a_torque_of_no_effect_stands_before_the_lesser_part_that_is_named() -> None:
    """What comes at any time, whatever the machine does, is most of what is left beside a Stribeck effect that is there."""
    plain = actuator_of("bare motor", 0).changed({INERTIA: 2e-4, VISCOUS: 3e-4, CSJ: 0.06, LOAD: 0.0}).with_drive_lag(0.0)
    answer = diagnosed(plain, [hummed(seed) for seed in range(4)])
    assert isinstance(answer, BalanceAnswer) and answer.accepted
    assert answer.unexplained is not None and answer.unexplained > 0.5
    said, share = sentence(answer), f"{100.0 * answer.unexplained:.0f} %"
    assert f"most of what the base values leave ({share}) is explained by nothing in the library; missing is" in said
    assert "stays unexplained" not in said
    less = replace(
        answer,
        forces=replace(
            answer.forces, steps=(replace(answer.forces.steps[-1], errors=replace(answer.last, training=0.6 * answer.last.training)),)
        ),
    )
    assert less.unexplained is not None and less.unexplained < 0.5
    assert "most of what" not in sentence(less)


def hummed(seed: int) -> MotionRecord:
    """A shaft with a rise of its friction at standstill, and a torque that swings in time."""
    run = swung(seed, rise=0.9, phase_rad=0.0)
    angle = run.recorded("motor_angle_rad")
    hum = 0.018 * np.sin(2.0 * np.pi * 1.3 * run.time_s + 2.0 * seed)
    return run.with_columns({"torque_Nm": run.recorded("torque_Nm") - WEIGHT_NM * np.sin(angle / RATIO) + hum})


def again(seed: int, laps: int = 4) -> MotionRecord:
    """A contact that yields, lap after lap, with rests between; not twice the same motion."""
    random, period, rows = np.random.default_rng(seed), 1000, 4000
    time = np.arange(rows) * 4e-3
    lap = np.tile(np.repeat([1.0, 0.0, -1.0, 0.0], period // 4), laps)
    window = np.hanning(61)
    speed = 25.0 * np.convolve(np.pad(lap, 30, mode="edge"), window / window.sum(), "valid")[:rows] * (1.0 + 0.01 * np.sin(0.7 * time))
    stretch = np.zeros(rows)
    for row, way in enumerate(speed[1:] * 4e-3 / 0.3, start=1):
        stretch[row] = np.sign(way) - (np.sign(way) - stretch[row - 1]) * np.exp(-abs(way))
    held = 0.04 * np.sin(0.3 * time + seed) * (np.abs(speed) < 1e-9)  # what holds it at rest is another torque every time
    torque = 2e-4 * np.gradient(speed, 4e-3) + 3e-4 * speed + DRY_NM * stretch + held + random.normal(0.0, 5e-4, rows)
    return MotionRecord(4e-3, f"laps_{seed}.csv").with_columns({"motor_speed_rad_s": speed, "torque_Nm": torque})


def test_the_floor_of_laps_is_one_of_the_records_and_not_of_the_model() -> None:
    actuator = actuator_of("bare motor", 0).changed({INERTIA: 2e-4, VISCOUS: 3e-4, CSJ: 0.05})
    bench = Bench(actuator, [again(1)])
    assert bench.division.by == "lap"
    floors = []
    for changes in ({}, {"presliding.stretch_rad": 0.3}, {VISCOUS: 1e-3, INERTIA: 4e-4}):
        samples = bench.changed(changes)
        floors.append(floor_of(bench, bench.fit(samples, (), np.zeros((bench.fold.size, 0)))))
        # nothing that is fitted is below what no model can be below
        assert floors[-1] < 100.0 * np.linalg.norm(samples.target[bench.training]) / np.linalg.norm(samples.drive[bench.training])
    assert max(floors) < 1.1 * min(floors)
    # 5e-4 Nm of noise behind a filter, of some 0.05 Nm
    assert 0.1 < floors[0] < 1.5


@pytest.mark.slow
def test_what_is_sought_by_simulation_alone_is_not_advised_where_nothing_can_be_simulated() -> None:
    reasons = Counter(one.reason for one in found().refused)
    assert reasons[NOT_SIMULATED] and not reasons[UNSOUGHT]
    assert "needs a known controller" in NOT_SIMULATED and "--method" not in NOT_SIMULATED


def shaft(seed: int, stretch_rad: float, drift_Nm_per_s: float = 0.0) -> MotionRecord:
    """Eighteen seconds of a shaft whose contact stretches before it slides, and whose drive's zero may drift."""
    random, time = np.random.default_rng(seed), np.arange(4500) * 4e-3
    angle = sum(
        size * np.sin(2.0 * np.pi * hz * (1.0 + 0.05 * seed) * time + random.uniform(0.0, 6.0))
        for hz, size in ((0.2, 20.0), (0.55, 9.0), (1.2, 3.0), (2.4, 1.0))
    )
    speed, stretch = np.gradient(angle, 4e-3), np.zeros(time.size)
    for row, way in enumerate(np.diff(angle) / stretch_rad, start=1):
        stretch[row] = np.sign(way) - (np.sign(way) - stretch[row - 1]) * np.exp(-abs(way))
    torque = 2e-4 * np.gradient(speed, 4e-3) + 1e-4 * speed + DRY_NM * (1.0 + 0.012 * random.normal()) * stretch + drift_Nm_per_s * time
    return MotionRecord(4e-3, f"shaft_{seed}.csv").with_columns(
        {"motor_speed_rad_s": speed, "torque_Nm": torque + random.normal(0.0, 1e-3, time.size)}
    )


def bare() -> Actuator:
    return actuator_of("bare motor", 0).changed({INERTIA: 2e-4, VISCOUS: 1e-4, CSJ: 0.05, LOAD: 0.0}).with_drive_lag(0.0)


@pytest.mark.slow
def test_every_step_stands_once_and_lowers_the_error() -> None:
    """A zero that drifts is no effect of the library, and several of them take up a part of it: what one has made needless is not counted beside what came again."""
    answer = improve_by_forces(bare(), [shaft(seed, 0.1, 0.003) for seed in range(6)])
    names = [step.effect for step in answer.steps]
    assert names and len(set(names)) == len(names)
    assert not set(names) & {one.effect for one in answer.refused}
    errors = [answer.refitted, *(step.errors for step in answer.steps)]
    assert all(after.training < before.training for before, after in itertools.pairwise(errors))
    assert set(names) - {"constant_load"} == set(answer.actuator.active_effects) - {"constant_load"}


def dragged(seed: int, power: float) -> MotionRecord:
    """A shaft with dry friction and a drag that grows with a power of the speed, as large as the dry friction at its fastest."""
    run = shaft(seed, 1e-3)
    speed = run.recorded("motor_speed_rad_s")
    drag = DRY_NM * np.sign(speed) * (np.abs(speed) / 60.0) ** power
    return run.with_columns({"torque_Nm": run.recorded("torque_Nm") - 1e-4 * speed + drag})


def test_an_effect_that_pushes_a_base_value_to_its_end_is_none() -> None:
    """A drag that grows faster than with the square takes viscous friction below zero beside one that does not; of one with the square alone nothing is left, which is where it may be."""
    reasons = []
    for power in (3.5, 2.0):
        bench = Bench(bare(), [dragged(seed, power) for seed in range(4)])
        search = ForceSearch(bench, untold, ["quadratic_viscous"])
        bench.stay_in_ranges()
        search.prepare(bench.start.setting)
        base = bench.judged(bench.fit(bench.start, (), np.zeros((bench.fold.size, 0))))
        tried = search.tried(base, "quadratic_viscous")
        assert isinstance(tried, Tried)
        fit = bench.judged(tried.fit)
        assert base.values[VISCOUS] > 0.0 and fit.values[VISCOUS] == pytest.approx(0.0, abs=5e-5)
        reasons.append(search.judge.refusal(base, replace(tried, fit=fit)))
    assert "(screw.viscous_Nm_s_per_rad) would lie on an end of where it may be: 0" in reasons[0] and not reasons[1]


def test_what_came_again_is_no_second_step() -> None:
    """An effect that another one made needless, and that came back beside the next, stands where it came last, with the errors of the model as it is."""
    bench = Bench(bare(), [dragged(seed, 2.0) for seed in range(3)])
    search = ForceSearch(bench, untold)
    search.prepare(bench.start.setting)
    base = bench.judged(bench.fit(bench.start, (), np.zeros((bench.fold.size, 0))))
    found_one = search.tried(base, "quadratic_viscous")
    assert isinstance(found_one, Tried)
    fit = bench.judged(found_one.fit)
    steps = [ForceStep(name, {}, {}, (), base.errors, {}) for name in ("quadratic_viscous", "presliding", "quadratic_viscous")]
    (step,) = _in_model(steps, fit, bench)
    assert step.effect == "quadratic_viscous" and step.errors == fit.errors and step.values == fit.values
