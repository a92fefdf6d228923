"""Where no effect beside CSJ and BLK explains a record: the whole search names what it can, a sensor's own error is said as such, and the answer stays open."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from ema_tools.base.arrays import Reals
from ema_tools.data.actuator import reference_actuator
from ema_tools.data.records import Record
from ema_tools.fit.misfit import misfit, whole_std
from ema_tools.select import cross_check
from ema_tools.select.known_machine import KnownMachine, MachineFit, compared
from ema_tools.tasks.identify import identify
from ema_tools.words.sentences.identification import sentence
from support import chirp_record

KNOWN = reference_actuator()
NOISE = {"position_mm": 0.005, "motor_position_mm": 0.002, "current_A": 0.03, "voltage_V": 0.01}


def _recorded(changes: dict[str, float], seed: int, file: str = "today.csv") -> Record:
    return replace(chirp_record(KNOWN.changed(changes), "chirp").with_noise(NOISE, seed), file=file)


def _healthy() -> list[Record]:
    return [_recorded({}, seed, f"healthy_{seed}.csv") for seed in (2, 3, 4)]


def _late(signal: Reals) -> Reals:
    return np.concatenate([signal[:1].repeat(2), signal[:-2]])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        (lambda one: replace(one, position_mm=_late(one.position_mm)), r"sensor of the rod position \(position_mm\).* it reads 2 ms late"),
        (
            lambda one: replace(one, motor_position_mm=1.02 * one.motor_position_mm),
            r"motor_position_mm\).* it reads 1\.02 times the signal",
        ),
        (lambda one: replace(one, current_A=1.1 * one.current_A), r"current_A\).* it reads 1\.1 times the signal"),
    ],
    ids=["rod late", "motor's encoder", "current"],
)
def test_a_sensor_that_errs_is_named_and_nothing_is_decided(wrong: Callable[[Record], Record], said: str) -> None:
    found = identify(KNOWN, wrong(_recorded({}, 1)), _healthy())
    assert found.verdict == "undecided"
    assert found.checked is not None
    assert found.checked.kind == "unknown"
    assert re.search(said, sentence(found)), sentence(found)


@pytest.mark.slow
def test_what_the_whole_search_names_keeps_the_answer_open(monkeypatch: pytest.MonkeyPatch) -> None:
    """Torque that repeats with the motor's turn, where a single effect beside the faults was not enough to say so."""
    cogging = {"effects.cogging_torque.amplitude_Nm": 0.01}
    monkeypatch.setattr(cross_check, "named", lambda known, base: ("unknown", None, ()))
    found = identify(KNOWN, _recorded(cogging, 1), _healthy())
    checked = found.checked
    assert checked is not None
    assert (checked.kind, checked.effects[0], checked.withheld) == ("missing", "cogging_torque", True)
    assert found.verdict == "undecided"
    size = "effects.cogging_torque.amplitude_Nm"
    assert abs(checked.values[size] - 0.01) < 3.0 * checked.std[size]


def test_what_is_left_widens_a_standard_error_and_noise_does_not() -> None:
    numbers = 10_000
    assert misfit(numbers + 2.9 * np.sqrt(2.0 * numbers), numbers, numbers) == 0.0
    assert misfit(2.0 * numbers, numbers, numbers) == pytest.approx(numbers - 3.0 * np.sqrt(2.0 * numbers))
    # noise alone, the share of a change that no model is better than, and a misfit of which half may lie along the value
    assert whole_std(1e-3, 0.0, "effects.stribeck_friction.rise", 0.0) == pytest.approx(1e-3)
    assert whole_std(0.0, 0.0, "effects.stribeck_friction.rise", 0.5) == pytest.approx(0.003)
    assert whole_std(1e-3, 200.0, "effects.stribeck_friction.rise", 0.0) == pytest.approx(1e-3 * np.sqrt(101.0))
    assert whole_std(0.0, 0.0, "effects.cogging_torque.phase_rad", 3.0) == 0.0


def test_a_fit_that_leaves_much_is_less_sure_of_its_size() -> None:
    known: KnownMachine = compared(KNOWN, _recorded({}, 1), _healthy()).known
    fit = MachineFit("viscous_rise", {"effects.viscous_rise.rise": 0.0}, {"effects.viscous_rise.rise": 1e-3}, known.floor)
    poor = replace(fit, cost=known.floor + 10.0 * known.evidence.numbers)
    assert known.with_whole_std(fit).std == pytest.approx(fit.std)
    assert known.with_whole_std(poor).std["effects.viscous_rise.rise"] > 100.0 * 1e-3
