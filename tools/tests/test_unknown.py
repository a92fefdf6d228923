"""What the library does not hold: drawn against every axis, the axes ranked without rewarding chance, and learned as a table."""

from __future__ import annotations

import json
from collections.abc import Mapping

import numpy as np
import pytest

from ema_tools.compare.localisation import where
from ema_tools.compare.unexplained import KINDS, NODES, LearnedTable, Unknown, learned, left_over
from ema_tools.data.actuator import reference_actuator
from ema_tools.data.records import Record, simulated
from ema_tools.results.codec import to_json
from ema_tools.words.answers.unexplained import unexplained
from ema_tools.words.sentences.unexplained import learned_sentence, sentence
from repeated_runs import WIDE, measured, repeats
from support import chirp_record


def left(changes: Mapping[str, float] | Record, text: str = WIDE, healthy: bool = True) -> tuple[Unknown, ...]:
    """What a model without the changes leaves."""
    record = changes if isinstance(changes, Record) else measured(changes, 99, text)
    model = reference_actuator()
    return left_over(model, record, where(model, record, repeats(text) if healthy else ()))


def table(unknowns: tuple[Unknown, ...]) -> LearnedTable:
    found = learned(unknowns[0])
    assert found is not None
    return found


RIPPLE = {"effects.pitch_ripple.ratio": 0.3, "effects.pitch_ripple.phase_rad": 0.8}
JAM = {"effects.jam_spot.amplitude_Nm": 0.1, "effects.jam_spot.place_mm": 2.0, "effects.jam_spot.width_mm": 1.5}


@pytest.mark.parametrize("healthy", [True, False])
def test_what_repeats_with_the_screw_is_not_taken_for_position(healthy: bool) -> None:
    first = left(RIPPLE, healthy=healthy)[0]
    assert first.balance == "mechanical" and first.best is not None
    assert (first.best.axis, first.best.friction) == ("place in the lead", True)
    assert "with the screw lead, against the motion" in sentence(first)


def test_what_belongs_to_one_place_is_not_taken_for_the_screw() -> None:
    first = left(JAM)[0]
    assert first.best is not None and (first.best.axis, first.best.friction) == ("position", True)
    assert "repeats with position, against the motion" in sentence(first) and "; not with the screw lead" in sentence(first)


@pytest.mark.parametrize(
    ("changes", "balance", "axis"),
    [
        ({"effects.winding_heating.rise_degC": 60.0}, "electrical", "current"),
        ({"effects.quadratic_viscous.drag_Nm_s2_per_rad2": 4e-6}, "mechanical", "speed"),
        ({"effects.spring_load.stiffness_Nm_per_mm": 0.01}, "mechanical", "position"),
        ({"effects.sensor_gain.error": 0.002}, "kinematic", "position"),
        ({"effects.constant_load.torque_Nm": 0.02}, "mechanical", "constant"),
    ],
)
def test_balance_and_axis_are_found(changes: dict[str, float], balance: str, axis: str) -> None:
    first = left(changes)[0]
    assert first.balance == balance and first.best is not None and first.best.axis == axis
    assert first.best.of_excess > 0.6


def test_a_short_stroke_tells_nothing_of_the_screw() -> None:
    first = left({"effects.jam_spot.amplitude_Nm": 0.2, "effects.jam_spot.place_mm": 0.5, "effects.jam_spot.width_mm": 0.5}, "chirp")[0]
    assert first.best is not None and first.best.axis == "position"
    assert "cannot be told apart on a stroke below one lead" in sentence(first)
    assert not any(one.axis == "place in the lead" for one in first.ranked)


def test_a_healthy_record_repeats_with_nothing() -> None:
    for seed in (61, 62, 63):
        for one in left(measured({}, seed, WIDE)):
            assert one.best is None, (seed, sentence(one))
            assert learned(one) is None and "repeats with none of the axes" in sentence(one)


def test_random_torque_is_not_learned() -> None:
    record = measured({}, 99, WIDE)
    random = np.random.default_rng(8)
    walk = np.convolve(random.normal(size=record.rows), np.ones(200) / 200.0, mode="same")
    noisy = record.with_columns({"current_A": record.recorded("current_A") + 6.0 * walk})
    mechanical = next(one for one in left(noisy) if one.balance == "mechanical")
    assert mechanical.rms > 2.0 * mechanical.floor_rms
    assert mechanical.best is None and learned(mechanical) is None


def test_learned_table_is_the_torque_that_was_hidden() -> None:
    found = table(left({"effects.spring_load.stiffness_Nm_per_mm": 0.01}))
    assert found.effect == "learned_torque" and found.axis == "position"
    places = np.linspace(found.first, found.last, NODES)
    # a spring pulls back: the torque on the shaft is against extension
    assert found.nodes == pytest.approx(-0.01 * places, abs=0.006)
    assert found.first < -7.0 and found.last > 7.0


def test_learned_friction_is_the_added_level_round_the_lead() -> None:
    found = table(left(RIPPLE))
    assert found.effect == "learned_friction" and (found.first, found.last) == (0.0, 5.0)
    places = np.linspace(found.first, found.last, NODES)
    hidden = 0.138 * 0.3 * np.sin(2.0 * np.pi * places / 5.0 + 0.8)
    assert found.nodes == pytest.approx(hidden, abs=0.2 * 0.138 * 0.3)
    assert found.nodes[0] == pytest.approx(found.nodes[-1])


def test_learned_voltage_and_reading_have_their_signs() -> None:
    heated = table(left({"effects.winding_heating.rise_degC": 60.0}))
    assert heated.effect == "learned_voltage" and heated.axis == "current"
    amperes = np.linspace(heated.first, heated.last, NODES)
    assert heated.nodes == pytest.approx(-0.99 * 0.00393 * 60.0 * amperes, abs=0.06)
    read = table(left({"effects.sensor_gain.error": 0.002}))
    assert read.effect == "learned_reading"
    assert read.nodes == pytest.approx(0.002 * np.linspace(read.first, read.last, NODES), abs=0.002)


def test_changes_name_every_value_of_the_table() -> None:
    found = table(left({"effects.winding_heating.rise_degC": 60.0}))
    assert set(found.changes) == {
        f"effects.learned_voltage.{field}" for field in ("gain", "axis", "first", "last", *(f"node_{place:02d}" for place in range(NODES)))
    }
    assert found.changes["effects.learned_voltage.gain"] == 1.0 and found.changes["effects.learned_voltage.axis"] == 4.0
    assert "outside that range it holds its edge value" in learned_sentence(found)


def test_constant_becomes_a_flat_table() -> None:
    found = table(left({"effects.constant_load.torque_Nm": 0.02}))
    assert found.effect == "learned_torque" and found.axis == "position"
    assert found.nodes == pytest.approx(np.full(NODES, -0.02), abs=0.004)


def test_known_effects_are_taken_off_first() -> None:
    model = reference_actuator()
    record = measured({**JAM, "effects.constant_load.torque_Nm": 0.05}, 99, WIDE)
    before = where(model, record, repeats(WIDE))
    knowing = left_over(model.changed({"effects.constant_load.torque_Nm": 0.05}), record, before)[0]
    assert knowing.best is not None and knowing.best.axis == "position" and knowing.best.friction
    assert knowing.rms < left_over(model, record, before)[0].rms


def test_result_is_finite_json() -> None:
    unknowns = left(JAM)
    answer = json.loads(json.dumps(to_json(unexplained(unknowns, learned(unknowns[0]))), allow_nan=False))
    assert [one["balance"] for one in answer["balances"]] == [one.balance for one in unknowns]
    assert {one["balance"] for one in answer["balances"]} == set(KINDS)
    assert answer["learned"]["effect"] == "learned_friction" and len(answer["learned"]["nodes"]) == NODES
    shares = [picture["explained_percent"] for picture in answer["balances"][0]["pictures"]]
    assert shares == sorted(shares, reverse=True)
    assert unexplained([]).learned is None


@pytest.mark.parametrize(
    ("changes", "channel"),
    [
        (JAM, "current_A"),
        (RIPPLE, "current_A"),
        ({"effects.winding_heating.rise_degC": 60.0}, "voltage_V"),
        ({"effects.quadratic_viscous.drag_Nm_s2_per_rad2": 4e-6}, "position_mm"),
        ({"effects.sensor_gain.error": 0.002}, "position_mm"),
    ],
)
def test_the_table_can_be_flown_without_knowing_the_name(changes: dict[str, float], channel: str) -> None:
    model = reference_actuator()
    true = chirp_record(model.changed(changes), WIDE)
    taught = model.changed(table(left(changes)).changes)
    before, after = (float(np.linalg.norm(getattr(simulated(one, true), channel) - true.recorded(channel))) for one in (model, taught))
    assert after < 0.1 * before
