"""One suite over every effect of the library: its record is complete, its zero does nothing, its typical size is allowed and seen, and its torque in closed form is what a simulation shows."""

from __future__ import annotations

import functools
import json
import re
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pytest

from benchmarks.effects import header
from ema_tools.base.arrays import Reals
from ema_tools.data.actuator import reference_actuator, row_of
from ema_tools.data.commands import make_command
from ema_tools.data.records import Record
from ema_tools.design.typical import scaled, typical_change
from ema_tools.fit.evidence import Evidence, view
from ema_tools.fit.nuisance import SLIGHT_REACH
from ema_tools.fit.whitening import Whitener, least_noise, lines_of
from ema_tools.library.definitions import load_definitions
from ema_tools.library.registry import described, record_of, separating
from ema_tools.plant.native import library
from ema_tools.results.codec import to_json
from ema_tools.select.matched_filter import Screen
from ema_tools.tasks.simulate import simulate_record
from ema_tools.words.answers.effects import effects as written
from reference_model.effects import example_of
from support import ROOT, run_ema

EFFECTS = [effect.name for effect in load_definitions().effects]
PHYSICAL = [effect.name for effect in load_definitions().effects if not effect.is_learned]
IN_CLOSED_FORM = [name for name in PHYSICAL if record_of(name).periodic is not None or record_of(name).local is not None]
INSEPARABLE = [(name, other) for name in PHYSICAL for other in record_of(name).inseparable if name < other]

NOISE = {"position_mm": 0.002, "motor_position_mm": 0.002, "current_A": 0.03, "voltage_V": 0.024}
# A typical size changes a record of the chirp by more than this, in standard deviations of the sensors' noise over all rows.
SEEN = 10.0
SAME = 0.999  # cosine of what two inseparable effects make of a record
# The torque in closed form against what a simulation shows, at this share of the typical size: its cosine, and how far the size may be off.
PART = 0.1
COSINE, SIZE_OFF = 0.85, 0.25


@dataclass(frozen=True)
class Expected:
    """What an effect reaches instead, and why it cannot do better."""

    cosine: float
    size_off: float
    why: str


LESS: Mapping[str, Expected] = {
    "stribeck_friction": Expected(0.6, 0.25, "it acts where the machine nearly rests, and the filter knows no rest"),
    "directional_stribeck": Expected(0.55, 0.25, "it acts where the machine nearly rests, and the filter knows no rest"),
    "load_dependent_stribeck": Expected(0.65, 0.5, "it acts where the machine nearly rests, and the filter knows no rest"),
    "cogging_torque": Expected(0.75, 0.6, "it acts most where the machine nearly rests, and the filter knows no rest"),
}


@functools.cache
def base() -> Record:
    """The record of the reference actuator."""
    return simulated({})


def simulated(changes: Mapping[str, float]) -> Record:
    """The record of the reference actuator with `changes`."""
    actuator = reference_actuator().changed(dict(changes))
    return simulate_record(actuator, make_command("chirp", actuator), 64)


def typical(effect: str) -> dict[str, float]:
    """The values of an effect at its typical size."""
    found = typical_change(reference_actuator(), effect, float(np.max(np.abs(base().recorded("current_A")))))
    assert found is not None, f"{effect}: give its record a typical size"
    return found


def change(changes: Mapping[str, float]) -> Reals:
    """What `changes` make of all signals, in standard deviations, [signals * rows]."""
    record = simulated(changes)
    return np.concatenate([(record.recorded(name) - base().recorded(name)) / noise for name, noise in NOISE.items()])


def cosine(one: Reals, other: Reals) -> float:
    """Of two vectors."""
    return float(one @ other) / float(np.linalg.norm(one) * np.linalg.norm(other))


def test_exceptions_are_of_effects_that_need_them() -> None:
    assert set(LESS) <= set(IN_CLOSED_FORM)
    assert all(one.why for one in LESS.values())


@pytest.mark.parametrize("effect", EFFECTS)
def test_every_place_is_filled(effect: str) -> None:
    record = described()[effect]
    assert record.shows.split()[0] in ("mechanical", "electrical", "kinematic", "controller")
    assert sum(other.shows == record.shows for other in described().values()) == 1
    assert example_of(effect)
    law = re.compile(rf"^(void|ema_real|ema_rod_t) ema_effect_{effect}(_adjust)?\(", re.MULTILINE)
    assert sum(bool(law.search(path.read_text(encoding="utf-8"))) for path in (ROOT / "src" / "effects").glob("ema_effects_*.c")) == 1
    row = load_definitions().effect(effect)
    assert row.is_learned == (record.learned is not None)
    if not row.is_learned:
        needs = record.below_peak is None
        assert (record.typical is not None) == needs, f"{effect}: its record {'needs' if needs else 'must not have'} a typical size"
    assert record.typical is None or record.typical.why
    if record.slight is not None and record.slight.free:
        assert record.slight.size == max(values[row.size.field] for values in record.slight.free)


@pytest.mark.parametrize("effect", PHYSICAL)
def test_at_zero_nothing_changes(effect: str) -> None:
    """To the last bit, in both precisions, whatever its other values are."""
    size = load_definitions().effect(effect).size
    absent = {**typical(effect), f"effects.{size.name}": size.nominal}
    command = make_command("chirp:duration_s=3", reference_actuator())
    for bits in (32, 64):
        without = library(bits).simulate(*reference_actuator().arrays(), command.samples_mm)
        at_zero = library(bits).simulate(*reference_actuator().changed(absent).arrays(), command.samples_mm)
        for channel in NOISE:
            assert np.array_equal(getattr(at_zero, channel), getattr(without, channel)), channel


@pytest.mark.parametrize("effect", PHYSICAL)
def test_a_typical_size_is_allowed_and_seen_and_not_slight(effect: str) -> None:
    values = typical(effect)
    size = load_definitions().effect(effect).size
    assert next(iter(values)) == f"effects.{size.name}"
    for larger in (1.0, 3.0):
        for name, value in scaled(reference_actuator(), effect, values, larger).items():
            assert row_of(name).lower <= value <= row_of(name).upper, name
    assert float(np.linalg.norm(change(values))) > SEEN
    slight = record_of(effect).slight
    if slight is not None:
        assert SLIGHT_REACH * slight.usual(reference_actuator()["screw.csj_Nm"]) < abs(values[f"effects.{size.name}"])


@pytest.mark.parametrize(("effect", "other"), INSEPARABLE)
def test_inseparable_effects_do_the_same_and_a_measurement_tells_them_apart(effect: str, other: str) -> None:
    assert effect in record_of(other).inseparable
    assert abs(cosine(change(typical(effect)), change(typical(other)))) > SAME
    assert separating((effect, other))


@pytest.mark.parametrize("effect", IN_CLOSED_FORM)
def test_the_torque_in_closed_form_is_what_a_simulation_shows(effect: str) -> None:
    """Sign, size and shape: the best shape of the matched filter on the noiseless record of the effect alone."""
    size = f"effects.{load_definitions().effect(effect).size.name}"
    hidden = typical(effect)
    hidden[size] *= PART
    record, names = simulated(hidden), tuple(NOISE)
    here, there = (np.array([one.recorded(name) for name in names]) for one in (base(), record))
    level = np.maximum(np.array(list(NOISE.values())), least_noise(here))
    power = np.broadcast_to((level**2)[:, None], (len(names), lines_of(record.rows)))
    nothing = np.empty((0, *here.shape))
    evidence = Evidence(reference_actuator(), base(), names, there, (), Whitener.of(power, record.rows), power, nothing, 0.0, (here,))
    seen = view(evidence, {})
    found = Screen(seen).shapes_of(effect)
    assert found
    allowed = LESS.get(effect, Expected(COSINE, SIZE_OFF, ""))
    assert np.sqrt(max(found[0].score, 0.0) / seen.cost) > allowed.cosine
    assert found[0].size == pytest.approx(hidden[size], rel=allowed.size_off)
    if f"effects.{effect}.periods" in hidden:
        assert found[0].shape[f"effects.{effect}.periods"] == hidden[f"effects.{effect}.periods"]


@pytest.mark.parametrize("effect", EFFECTS)
def test_words_exist(effect: str) -> None:
    ran = run_ema("effects", effect)
    assert ran.code == 0
    assert " ".join(record_of(effect).shows.split()) in " ".join(ran.out.split())
    told = json.loads(json.dumps(to_json(written([load_definitions().effect(effect)])), allow_nan=False))["effects"][0]
    assert told["signature"] == record_of(effect).shows
    assert all(told[key] for key in ("equation", "source", "acts_on"))


def test_the_target_counts_every_effect_at_its_typical_size() -> None:
    """The sizes that the program for the target compiles in; `cmake --build build --target written` writes them."""
    assert (ROOT / "tests" / "target" / "ema_costed.def").read_text(encoding="utf-8") == header()
