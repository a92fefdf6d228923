"""Naming a missing effect: the whitening keeps lengths, healthy repeats look like noise, and effects hidden on the truth plant are found."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from ema_tools.actuator import reference_actuator
from ema_tools.benchmarks import naming
from ema_tools.diagnosis.candidates import FAULTS, candidates
from ema_tools.diagnosis.evidence import Whitener, gather
from ema_tools.diagnosis.search import diagnose, effect_of
from ema_tools.definitions import load_definitions
from ema_tools.errors import InputError
from ema_tools.reference.compiled import HAS_NUMBA

needs_numba = pytest.mark.skipif(not HAS_NUMBA, reason="the truth plant takes minutes a record without Numba")


@pytest.mark.parametrize("rows", [100, 101])
def test_whitening_with_unit_weights_keeps_lengths_and_angles(rows: int) -> None:
    random = np.random.default_rng(3)
    first, second = random.normal(size=(2, 3, rows))
    whiten = Whitener(np.ones((3, rows // 2 + 1)))
    assert whiten(first) @ whiten(second) == pytest.approx(float(np.sum(first * second)), rel=1e-10)


@pytest.fixture(scope="module")
def healthy() -> list[naming.Record]:
    """Repeats of the healthy machine and one more run of it."""
    return [naming.measured({}, 700 + k) for k in range(naming.REPEATS + 1)]


@needs_numba
def test_a_healthy_run_costs_what_the_repeats_cost(healthy: list[naming.Record]) -> None:
    evidence = gather(reference_actuator(), healthy[-1], healthy[:-1])
    assert evidence.channels == ("position_mm", "motor_position_mm", "current_A", "voltage_V")
    costs = [float(repeat @ repeat) for repeat in evidence.repeats]
    own = float(evidence.residual @ evidence.residual)
    assert 0.8 * min(costs) < own < 1.2 * max(costs)
    found = diagnose(evidence)
    assert found.verdict == "adequate"
    assert found.fit is None


@needs_numba
def test_every_effect_and_fault_is_a_candidate(healthy: list[naming.Record]) -> None:
    evidence = gather(reference_actuator(), healthy[-1], healthy[:-1])
    names = {candidate.effect for candidate in candidates(evidence)}
    assert names == {*FAULTS, *(effect.name for effect in load_definitions().effects)}
    assert "blk" not in {candidate.effect for candidate in candidates(evidence, without=("blk",))}


@needs_numba
@pytest.mark.slow
@pytest.mark.parametrize("hidden", ["feedback_delay", "constant_load", "inertia_change", "sensor_gain"])
def test_a_hidden_effect_is_named_with_its_size(hidden: str) -> None:
    trial = naming.trial(hidden, 1.0, seed=11)
    assert trial.right, f"{hidden}: named {trial.named}"
    fit = trial.diagnosis.fit
    assert fit is not None
    assert trial.diagnosis.cost_after < 1.1 * trial.diagnosis.cost_floor
    if fit.effects == (hidden,):
        size, true = next(iter(naming.MEDIUM[hidden].items()))
        assert fit.values[f"effects.{hidden}.{size}"] == pytest.approx(true, rel=0.15)


@needs_numba
@pytest.mark.slow
def test_a_fault_is_named_as_the_fault_and_not_as_an_effect(healthy: list[naming.Record]) -> None:
    worn = naming.measured({"screw.csj_Nm": 0.2}, 777)
    found = diagnose(gather(reference_actuator(), worn, healthy[:-1]))
    assert found.fit is not None
    assert found.fit.effects[0] == "csj"
    assert effect_of("screw.csj_Nm") == "csj"


@needs_numba
def test_repeats_of_another_command_or_too_few_are_refused(healthy: list[naming.Record]) -> None:
    with pytest.raises(InputError, match="give two or more"):
        gather(reference_actuator(), healthy[-1], healthy[:1])
    other = dataclasses.replace(healthy[0], command_mm=healthy[0].command_mm * 1.5, file="other.csv")
    with pytest.raises(InputError, match=r"other\.csv: command_mm"):
        gather(reference_actuator(), healthy[-1], [other, *healthy[1:3]])
