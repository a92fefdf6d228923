"""Where a model fails: the right balance, what the excess is proportional to, its places, and pictures that show what was put in."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
import pytest

from ema_tools.base.arrays import Reals
from ema_tools.compare.axes import Axis, explained, foretold, hats, machine_state_of
from ema_tools.compare.comparison import compare
from ema_tools.compare.localisation import Where, binned, mean_record, where
from ema_tools.data.actuator import reference_actuator
from ema_tools.fit.whitening import Whitener, lines_of
from ema_tools.results.codec import to_json
from ema_tools.words.answers.localisation import localisation
from ema_tools.words.sentences.comparison import sentence as sentence_of_comparison
from ema_tools.words.sentences.localisation import sentence
from repeated_runs import WIDE, measured, repeats
from support import chirp_record


def wave(columns: Mapping[str, Reals], name: str) -> dict[str, Reals]:
    """A column with an error of 5 um once per motor turn."""
    turn_mm = 2.0 * np.pi * reference_actuator().lead_mm_per_rad
    return {name: columns[name] + 0.005 * np.sin(2.0 * np.pi * columns["motor_position_mm"] / turn_mm)}


def late(values: Reals) -> Reals:
    """Two rows late, 2 ms."""
    return np.concatenate((np.full(2, values[0]), values[:-2]))


def close(text: str, words: str) -> bool:
    """Whether a sentence has these words, its number within a tenth of what a scale, a zero or an amplitude differs by."""
    number = re.search(r"\d+\.?\d*", words)
    assert number is not None
    found = re.search(re.escape(words[: number.start()]) + r"(\d+\.?\d*)" + re.escape(words[number.end() :]), text)
    nominal = float(number[0]) - (1.0 if "times" in words else 0.0)
    return found is not None and float(found[1]) - (1.0 if "times" in words else 0.0) == pytest.approx(nominal, rel=0.15)


def found(changes: Mapping[str, float], text: str = "chirp") -> Where:
    return where(reference_actuator(), measured(changes, 99, text), repeats(text))


@pytest.mark.parametrize(
    ("changes", "block", "words"),
    [
        ({"effects.winding_heating.rise_degC": 30.0}, "electrical", "proportional to current"),
        ({"effects.inverter_dead_time.drop_V": 0.3}, "electrical", "with the sign of the current"),
        ({"screw.csj_Nm": 0.16}, "mechanical", "with the sign of the motion"),
        ({"effects.constant_load.torque_Nm": 0.015}, "mechanical", "constant"),
        ({"effects.inertia_change.change": 0.1}, "mechanical", "proportional to acceleration"),
        ({"effects.spring_load.stiffness_Nm_per_mm": 0.01}, "mechanical", "proportional to position"),
        (
            {"effects.cogging_torque.amplitude_Nm": 0.045, "effects.cogging_torque.periods": 12.0},
            "mechanical",
            "in 12 periods per motor turn",
        ),
        ({"effects.sensor_gain.error": 0.003}, "kinematic", "proportional to position"),
        ({"effects.sensor_offset.offset_mm": 0.02}, "kinematic", "constant"),
        ({"effects.feedback_delay.delay_s": 1e-3}, "controller", "proportional to speed"),
    ],
)
def test_the_right_balance_is_accused_and_described(changes: dict[str, float], block: str, words: str) -> None:
    answer = found(changes)
    worst = max(answer.blocks, key=lambda one: one.share)
    assert worst.name == block and worst.share > 0.9
    assert worst.winner is not None and worst.winner.words == words
    assert f"lies in the {block} balance" in sentence(answer) and words in sentence(answer)


def test_coefficient_of_the_winning_term_is_the_change() -> None:
    answer = found({"effects.winding_heating.rise_degC": 30.0})
    electrical = next(one for one in answer.blocks if one.name == "electrical")
    assert electrical.winner is not None
    assert electrical.winner.coefficient == pytest.approx(0.99 * 0.00393 * 30.0, rel=0.05)


def test_a_small_effect_below_the_noise_of_its_balance_is_seen_by_its_shape() -> None:
    answer = found({"effects.constant_load.torque_Nm": 0.004})
    mechanical = next(one for one in answer.blocks if one.name == "mechanical")
    assert mechanical.rms < 3.0 * mechanical.floor_rms
    assert mechanical.telling and mechanical.winner is not None and mechanical.winner.words == "constant"


def test_a_healthy_record_accuses_no_balance() -> None:
    for seed in range(60, 66):
        answer = where(reference_actuator(), measured({}, seed), repeats())
        assert not any(block.telling for block in answer.blocks), (seed, sentence(answer))
        assert sentence(answer).endswith("no balance shows more than the healthy repeats explain.")


def test_standing_errors_drop_out_against_repeats_and_show_without() -> None:
    other = reference_actuator().changed({"motor.resistance_ohm": 1.3})
    against = where(other, measured({}, 99), repeats())
    assert not any(block.telling for block in against.blocks)
    alone = where(other, measured({}, 99))
    assert sentence(alone).startswith("100 % of what the model leaves unexplained lies in the electrical balance")
    assert "proportional to current" in sentence(alone) and not alone.relative


@pytest.mark.parametrize(
    ("error", "signal", "blamed"),
    [
        (lambda r: wave(r, "motor_position_mm"), "motor position has an error that repeats once per motor turn (0.005 mm)", ""),
        (lambda r: wave(r, "position_mm"), "rod position has an error that repeats once per motor turn (0.005 mm)", "kinematic"),
        (lambda r: {"position_mm": 1.01 * r["position_mm"]}, "rod position reads 1.01 times the signal", "kinematic"),
        (lambda r: {"current_A": 1.05 * r["current_A"]}, "current reads 1.05 times the signal", ""),
        (lambda r: {"current_A": r["current_A"] + 0.1}, "current reads 0.1 A too high", ""),
        (lambda r: {"position_mm": late(r["position_mm"])}, "rod position reads 2 ms late", "kinematic"),
        (lambda r: {"motor_position_mm": late(r["motor_position_mm"])}, "motor position reads 2 ms late", ""),
    ],
    ids=["motor wave", "rod wave", "rod scale", "current scale", "current zero", "rod late", "motor late"],
)
def test_an_error_of_a_reading_is_no_mechanics(error: Callable[[dict[str, Reals]], dict[str, Reals]], signal: str, blamed: str) -> None:
    record = measured({}, 99)
    columns = {name: np.asarray(record.recorded(name)) for name in ("position_mm", "motor_position_mm", "current_A")}
    record = record.with_columns(error(columns))
    answer = where(reference_actuator(), record, repeats())
    alone = chirp_record(reference_actuator()).with_noise(
        dict.fromkeys(("position_mm", "motor_position_mm"), 0.002) | {"current_A": 0.03}, 9
    )
    alone = alone.with_columns(error({name: np.asarray(alone.recorded(name)) for name in columns}))
    told, compared = sentence(answer), sentence_of_comparison(compare(reference_actuator(), alone))
    # the pattern comes first, then the block
    subject = re.split(" reads| has", signal)[0]
    for text in (told, compared):
        assert text.startswith(f"The {subject} "), text
        assert "mechanical balance (" not in text, text
    assert close(told, signal), told
    assert (f"lies in the {blamed} balance" in told) if blamed else ("so its sensor is at fault and not the machine" in told)
    entry = localisation(answer).reading
    assert entry is not None and entry.outside_mechanics == (not blamed) and entry.sentence in told


@pytest.mark.parametrize(
    "changes",
    [
        {"screw.csj_Nm": 0.19, "screw.blk_mm": 0.05},
        {"motor.torque_constant_Nm_per_A": 0.95 * reference_actuator()["motor.torque_constant_Nm_per_A"]},
        {"effects.constant_load.torque_Nm": 0.015},
        {"effects.cogging_torque.amplitude_Nm": 0.05, "effects.cogging_torque.periods": 1.0},
        {"effects.winding_heating.rise_degC": 30.0},
        {"effects.feedback_delay.delay_s": 1e-3},
    ],
)
def test_a_change_of_the_machine_is_no_error_of_a_reading(changes: dict[str, float]) -> None:
    assert found(changes).reading is None
    assert compare(reference_actuator(), measured(changes, 99)).reading is None


def test_place_of_a_jam_is_told() -> None:
    answer = found({"effects.jam_spot.amplitude_Nm": 0.2, "effects.jam_spot.place_mm": 0.8, "effects.jam_spot.width_mm": 0.1})
    places = [place for place in answer.places if place.source == "mechanical balance" and place.by == "position"]
    assert places[0].part == max((place for place in places), key=lambda place: place.share).part
    low, high = (float(word) for word in places[0].part.removesuffix(" mm").split(" to "))
    assert low < 0.8 < high and "at position" in sentence(answer)
    bins = next(one for one in answer.pictures.bins if one.source == "mechanical" and one.by == "position")
    peak = bins.center[int(np.argmax(bins.share_percent))]
    assert peak == pytest.approx(0.8, abs=0.2)


def test_orders_show_the_line_and_the_screw() -> None:
    answer = found({"effects.cogging_torque.amplitude_Nm": 0.045, "effects.cogging_torque.periods": 12.0})
    turns = answer.pictures.orders["mechanical"].turns
    place = int(np.argmax(np.divide(turns.amplitude, turns.chance)))
    assert turns.order[place] == 12.0
    assert turns.amplitude[place] == pytest.approx(0.045, rel=0.25) and turns.chance[place] < 0.02
    screw = found({"effects.sensor_gain.error": 0.0}, WIDE)
    assert screw.pictures.orders["mechanical"].stroke_leads == pytest.approx(3.2, abs=0.1)


def test_torque_against_speed_shows_the_added_friction() -> None:
    drawn = found({"screw.csj_Nm": 0.188}).pictures.torque_speed
    assert drawn is not None and drawn.measured is not None and drawn.expected is not None
    fast = [place for place, speed in enumerate(drawn.measured.center) if speed > 50.0]
    measured_torque = np.mean([drawn.measured.mean[place] for place in fast])
    healthy_torque = np.mean([drawn.expected.mean[place] for place in fast])
    assert drawn.other == "healthy"
    assert measured_torque - healthy_torque == pytest.approx(0.05, rel=0.1)


def test_play_is_the_width_of_its_loop() -> None:
    loops = found({"screw.blk_mm": 0.1}).pictures.hysteresis.play
    assert loops is not None and loops.healthy is not None and loops.model is not None
    assert np.ptp(loops.measured.y) == pytest.approx(100.0, rel=0.1)
    assert np.ptp(loops.healthy.y) == pytest.approx(33.0, rel=0.2)
    assert np.ptp(loops.model.y) == pytest.approx(33.0, rel=0.1)


def test_missing_signals_are_said() -> None:
    record = replace(measured({}, 99), current_A=None)
    answer = where(reference_actuator(), record, [replace(one, current_A=None) for one in repeats()])
    reasons = {block.name: block.reason for block in answer.blocks}
    assert reasons["mechanical"] and reasons["electrical"] and not reasons["kinematic"]
    assert "not to be had: mechanical, electrical" in sentence(answer)
    alone = replace(record, motor_position_mm=None, voltage_V=None)
    assert sentence(where(reference_actuator(), alone)).startswith("No balance can be drawn")


def test_shares_of_signals_use_the_noise_that_is_known() -> None:
    record = measured({"effects.winding_heating.rise_degC": 60.0}, 99)
    channels = ("position_mm", "motor_position_mm", "current_A", "voltage_V")
    power = np.outer([1e-6, 1e-6, 1e-3, 1e-3], np.ones(lines_of(record.rows)))
    plain, weighed = (
        where(reference_actuator(), record, repeats()),
        where(reference_actuator(), record, repeats(), Whitener.of(power, record.rows), channels),
    )
    for answer in (plain, weighed):
        assert sum(one.share for one in answer.channels) == pytest.approx(1.0)
        assert {one.name for one in answer.channels} == set(channels)
    # with weights that are alike at all frequencies the shares are those of the squares
    weights = {
        name: size / power[place, 0]
        for place, name in enumerate(channels)
        for size in [next(one.rms for one in plain.channels if one.name == name) ** 2]
    }
    for one in weighed.channels:
        assert one.share == pytest.approx(weights[one.name] / sum(weights.values()), rel=1e-6)
    noise = next(one for one in plain.channels if one.name == "current_A")
    assert noise.floor_rms == pytest.approx(0.03, rel=0.5)


def test_result_is_finite_json() -> None:
    answer = found({"screw.csj_Nm": 0.16})
    text = json.dumps(to_json(localisation(answer)), allow_nan=False)
    result = json.loads(text)
    assert result["relative_to_healthy"] is True and result["blocks"][0]["name"] == "mechanical"
    assert len(text) < 200_000
    assert sum(block["share_percent"] for block in result["blocks"]) == pytest.approx(100.0)


def test_out_of_sample_share_does_not_reward_flexibility() -> None:
    random = np.random.default_rng(5)
    noise, half = random.normal(size=600), np.arange(600) // 50 % 2 == 0
    columns = hats(random.uniform(0.0, 1.0, 600), 0.0, 1.0, 16)
    assert explained(noise, columns, half) < 0.0
    signal = columns @ np.arange(16.0)
    assert explained(signal, columns, half) == pytest.approx(1.0)
    assert foretold(signal, columns, half) == pytest.approx(signal)


def test_table_columns_interpolate_and_hold_the_edges() -> None:
    nodes = np.random.default_rng(6).normal(size=16)
    at = np.array([-3.0, 0.0, 0.31, 1.0, 7.0])
    assert hats(at, 0.0, 1.0, 16) @ nodes == pytest.approx(np.interp(at, np.linspace(0.0, 1.0, 16), nodes))


def test_bins_hold_mean_band_and_share() -> None:
    axis = Axis("position", "mm", np.repeat([0.0, 1.0], 50))
    values = np.concatenate((np.tile([1.0, 3.0], 25), np.zeros(50)))
    bins = binned(axis, values, 2)
    assert bins is not None
    assert bins.mean == pytest.approx([2.0, 0.0]) and bins.low == pytest.approx([1.0, 0.0]) and bins.share == pytest.approx([1.0, 0.0])
    assert binned(Axis("position", "mm", np.zeros(4)), np.zeros(4)) is None


def test_motion_tells_passes_and_halves_hold_both_directions() -> None:
    record = chirp_record()
    from ema_tools.balances.filtering import Smoother

    motion = machine_state_of(reference_actuator(), record, Smoother.of(record.period_s))
    half = motion.halves()
    assert motion.passes[-1] > 30
    for part in (half, ~half):
        assert 0.3 < np.mean(motion.direction[part] > 0.0) < 0.7


def test_mean_of_records_keeps_common_signals() -> None:
    first, second = repeats()[:2]
    mean = mean_record([first, replace(second, voltage_V=None)])
    assert mean.voltage_V is None
    assert mean.position_mm == pytest.approx(0.5 * (first.position_mm + second.position_mm))
