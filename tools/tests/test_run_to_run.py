"""How a machine differs from run to run, as its baseline records show it."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from ema_tools.data.actuator import reference_actuator
from ema_tools.data.records import Record
from ema_tools.fit.evidence import Evidence, settled, simulate_channels
from ema_tools.fit.nuisance import ASKED, ASKED_VARIES, BESIDES, PER_DEGC, TEMPERATURE, USUAL_WEIGHT, Spread, besides, moved
from ema_tools.select.baseline import gather
from ema_tools.select.run_to_run import _SCALES, _learned, _scales
from ema_tools.select.search import diagnose
from ema_tools.tasks.diagnose import answer
from support import chirp_record

SUPPLY = "drive.supply_V"
NOISE = {"position_mm": 0.002, "motor_position_mm": 0.001, "current_A": 0.03, "voltage_V": 0.01}


def drawn(widths: list[float], runs: int, seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """Directions [k, 1, rows] that are orthogonal, and runs [runs, 1, rows] that differ along each by its width and by noise of 0.1."""
    random = np.random.default_rng(seed)
    directions = np.linalg.qr(random.normal(size=(400, len(widths))))[0].T[:, None] * 20.0
    values = np.array(widths)[:, None] * random.normal(size=(len(widths), runs))
    return directions, np.einsum("kr,kcn->rcn", values, directions) + 0.1 * random.normal(size=(runs, 1, 400))


def of(count: int) -> tuple[Spread, ...]:
    """So many values that vary, and a temperature that does nothing."""
    return (*(Spread((f"value {place}",), 1.0, True) for place in range(count)), Spread(("none",), 1.0, True, (0.0,), TEMPERATURE))


def test_many_runs_tell_the_width_of_each_direction() -> None:
    directions, runs = drawn([0.3, 3.0, 0.0], 400)
    _, widths, values, _, _ = _learned(directions, runs - runs.mean(axis=0), np.array([1e-6]), of(2), ())
    assert widths[:2] == pytest.approx([0.3, 3.0], rel=0.12)
    assert np.std(values[1]) == pytest.approx(3.0, rel=0.12)


def test_what_few_runs_do_not_show_stays_as_usual_and_what_is_stated_does_not_move() -> None:
    directions, runs = drawn([1e-3, 5.0, 5.0, 0.0], 3, seed=2)
    directions[0] *= 1e-6
    _, widths, _, _, _ = _learned(directions, runs - runs.mean(axis=0), np.array([1e-6]), of(3), ("value 2",))
    assert widths[0] == pytest.approx(1.0, rel=1e-3)
    assert 1.0 < widths[1] < 8.0 and widths[2] == 1.0


def test_what_a_degree_does_to_friction_is_learned_where_the_days_differ() -> None:
    """A line through the runs: friction that follows the temperature by a slope of its own, in standard deviations of each."""
    random = np.random.default_rng(5)
    vary = (Spread(("screw.csj_Nm",), 0.004, True), Spread(("motor.resistance_ohm",), 5.0, True, (0.004,), TEMPERATURE))
    directions, _ = drawn([1.0, 1.0], 2)
    warm = random.normal(size=30)
    values = np.array([0.8 * warm + 0.1 * random.normal(size=30), warm])
    runs = np.einsum("kr,kcn->rcn", values, directions) + 0.1 * random.normal(size=(30, 1, 400))
    found, widths, _, shares, doubts = _learned(directions, runs - runs.mean(axis=0), np.array([1e-6]), vary, ())
    assert shares == pytest.approx([0.8, 0.0], abs=0.06) and widths[0] < 0.6
    assert found[1] == pytest.approx(directions[1] + shares[0] * directions[0], abs=1e-9)
    # days that are alike tell nothing of it, and friction may be as far off as degrees take it
    calm = np.einsum("kr,kcn->rcn", values * [[0.1], [0.0]], directions) + 0.1 * random.normal(size=(30, 1, 400))
    _, _, _, none, open_doubts = _learned(directions, calm - calm.mean(axis=0), np.array([1e-6]), vary, ())
    assert abs(none[0]) < 0.6 and open_doubts[0] > 3.0 * doubts[0]


def test_two_runs_that_are_alike_narrow_it_by_no_more_than_they_weigh() -> None:
    directions, runs = drawn([0.0, 0.0], 2)
    _, widths, _, _, _ = _learned(directions, runs - runs.mean(axis=0), np.array([1e-6]), of(1), ())
    assert widths[0] >= np.sqrt(USUAL_WEIGHT / (USUAL_WEIGHT + 1.0))


@cache
def on_supply(share: float, seed: int) -> Record:
    """A chirp of the reference actuator whose supply is off by a share, with noise."""
    model = reference_actuator()
    record = chirp_record(model.changed({SUPPLY: (1.0 + share) * model[SUPPLY]}))
    random = np.random.default_rng(seed)
    noisy = {name: record.recorded(name) + std * random.normal(size=record.rows) for name, std in NOISE.items()}
    return Record(record.period_s, record.command_mm, file=f"run_{seed}.csv", **noisy)


def as_asked(share: float, seed: int) -> Record:
    """The same with the voltage that the controller asks for, which takes the supply for what the data sheet states."""
    record = on_supply(share, seed)
    return replace(record, voltage_V=record.recorded("voltage_V") / (1.0 + share))


DAYS = (0.004, -0.005, 0.001, -0.002, 0.003)


def of_days(shares: tuple[float, ...], today: float = 0.0) -> Evidence:
    healthy = [on_supply(share, 10 + place) for place, share in enumerate(shares)]
    return gather(reference_actuator(), on_supply(today, 30), healthy)


def std_of(evidence: Evidence, title: str) -> float:
    return next(one.std for one in evidence.varies if one.title == title)


def test_what_moves_several_values_moves_them_after_each_has_moved_by_itself() -> None:
    model, name = reference_actuator(), "motor.resistance_ohm"
    warm = Spread((name,), 10.0, True, (0.004,), TEMPERATURE)
    found = moved(model, (Spread((name,), 0.01, True), warm), np.array([2.0, -1.0]))
    assert found == {name: pytest.approx(model[name] * 1.02 * 0.96, rel=1e-12)}


def test_a_supply_that_differs_from_day_to_day_is_learned_and_no_noise() -> None:
    calm, days = of_days((0.0,) * 5), of_days(DAYS)
    usual = BESIDES[(SUPPLY,)] * np.sqrt(1.0 + 1.0 / len(DAYS))
    assert std_of(calm, SUPPLY) < usual < std_of(days, SUPPLY)
    # what the days differ by has left the noise, which holds it where the machine is taken for known
    known = [one.of_known for one in (calm, days)]
    assert known[0] is not None and known[1] is not None
    assert np.mean(days.noise) == pytest.approx(np.mean(calm.noise), rel=0.05)
    assert np.mean(known[1].noise) > 1.2 * np.mean(known[0].noise)


def test_a_day_of_another_temperature_is_no_effect_and_is_said() -> None:
    model = reference_actuator()
    warm = chirp_record(model.changed({name: (1.0 + 12.0 * share) * model[name] for name, share in PER_DEGC.items()}))
    random = np.random.default_rng(40)
    noisy = {name: warm.recorded(name) + std * random.normal(size=warm.rows) for name, std in NOISE.items()}
    today = Record(warm.period_s, warm.command_mm, file="today.csv", **noisy)
    found = answer(model, today, [on_supply(0.0, 10 + place) for place in range(3)])
    assert found.diagnosis.verdict == "adequate"
    said = [one.text for one in found.gate.remarks if one.topic == TEMPERATURE]
    assert len(said) == 1 and re.search(r"about 1[0-4] degC warmer", said[0])


def test_a_supply_of_another_day_is_no_effect_and_one_that_sags_is() -> None:
    assert diagnose(of_days(DAYS, 0.006)).verdict == "adequate"
    sags = diagnose(of_days(DAYS, -0.05))
    assert sags.verdict == "missing" and {"supply_sag", "gain_drift"} & {sags.named[0].name, *sags.alike}


def test_a_supply_of_another_day_is_no_effect_where_the_voltage_is_as_asked() -> None:
    healthy = [as_asked(share, 10 + place) for place, share in enumerate(DAYS)]
    evidence = gather(reference_actuator(), as_asked(0.008, 30), healthy)
    assert std_of(evidence, ASKED) > ASKED_VARIES
    assert diagnose(evidence).verdict == "adequate"


def test_each_parameter_moves_the_signals_by_a_direction_of_its_own() -> None:
    evidence = of_days((0.0,) * 3)
    assert [evidence.spread[-1].title, *(one.title for one in evidence.varies)] == [one.title for one in besides(evidence.actuator)]
    assert len(evidence.additive) == len(evidence.varies)
    assert np.max(np.abs(settled(evidence, {}).deviations)) < 3.0
    place = [one.title for one in evidence.varies].index(SUPPLY)
    one = evidence.varies[place]
    here = simulate_channels(evidence.actuator, evidence.record, evidence.channels, evidence.start_mm)
    moved = simulate_channels(
        evidence.actuator.changed(one.changes(evidence.actuator, 1.0)), evidence.record, evidence.channels, evidence.start_mm
    )
    # a reversal may jump a step, and a direction is taken over another distance
    assert np.std(evidence.additive[place] - (moved - here)) < 0.05 * np.std(moved - here)


@pytest.mark.parametrize("scale", [0.0, 1.0, 4.0])
def test_two_dozen_values_tell_together_how_far_days_go(scale: float) -> None:
    widths = [scale] * 24
    widths[3] += 10.0 * (scale or 0.1)
    directions, runs = drawn(widths, 5)
    found = _scales(directions, runs - runs.mean(axis=0), np.array([1e-6]), 1)
    assert found[0] == 1.0
    # one that goes ten times farther than all others does not take them along
    assert np.all(found[1:] == found[1]) and found[1] == pytest.approx(max(scale, _SCALES[0]), rel=0.6)
