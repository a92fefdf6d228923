"""Naming a missing effect: the whitening keeps lengths, healthy repeats look like noise, and effects hidden on the truth plant are found, added and confirmed."""

from __future__ import annotations

import dataclasses
import re

import numpy as np
import pytest

from benchmarks.hidden.machines import machine, measured
from benchmarks.hidden.sealed import STEP_S
from ema_tools.base.compiled import HAS_NUMBA
from ema_tools.base.errors import InputError, taken
from ema_tools.compare.localisation import where
from ema_tools.data.actuator import reference_actuator
from ema_tools.data.commands import make_command
from ema_tools.data.records import Record
from ema_tools.fit.evidence import Sensitivity, View, settled, view
from ema_tools.fit.refit import refit
from ema_tools.fit.whitening import Whitener, counted, lines_of
from ema_tools.library.definitions import load_definitions
from ema_tools.library.faults import FAULTS, effect_of
from ema_tools.results.codec import to_json
from ema_tools.select.baseline import gather
from ema_tools.select.candidates import candidates
from ema_tools.select.healthy_records import check_against_all
from ema_tools.select.holdout import Rung, refuted
from ema_tools.select.matched_filter import Screen
from ema_tools.tasks.add import add
from ema_tools.tasks.diagnose import Answer, answer
from ema_tools.tasks.learned_tables import helpful_tables, today_worn
from ema_tools.tasks.simulate import simulate_record
from ema_tools.words.advice import with_next
from ema_tools.words.answers.diagnosis import diagnosis
from ema_tools.words.sentences.addition import reason
from ema_tools.words.sentences.diagnosis import sentence
from shared_results import shared_result
from stored_records import day

needs_numba = pytest.mark.skipif(not HAS_NUMBA, reason="the truth plant takes minutes a record without Numba")
UNIT = 2  # a machine with Coulomb friction


def run_of(changes: dict[str, float], seed: int, command: str = "chirp") -> Record:
    """One run of the machine, as its sensors show it."""
    run = measured(machine(UNIT), changes, command, seed)
    return Record(STEP_S, run.command_mm, run.position_mm, run.motor_position_mm, run.current_A, run.voltage_V, file=f"run_{seed}.csv")


@pytest.mark.parametrize("rows", [100, 99, 101])
def test_whitening_with_unit_power_keeps_lengths_and_angles(rows: int) -> None:
    random = np.random.default_rng(3)
    first, second = random.normal(size=(2, 3, rows))
    whiten = Whitener.of(np.ones((3, lines_of(rows))), rows)
    used = counted(rows)
    assert rows - used <= 1
    assert whiten(first) @ whiten(second) == pytest.approx(float(np.sum((first * second)[:, :used])), rel=1e-10)


@pytest.fixture(scope="module")
def healthy() -> list[Record]:
    """Repeats of the healthy machine and one more run of it."""
    return [day(f"healthy_{700 + k}") for k in range(6)]


@pytest.fixture(scope="module")
def held_out() -> list[Record]:
    """The machine with a hot winding, under the chirp and under another command."""
    return [day("hot_801"), day("hot_802")]


@pytest.fixture(scope="module")
@shared_result
def hot() -> Answer:
    held_out = [day("hot_801"), day("hot_802")]
    return answer(reference_actuator(), held_out[0], [day(f"healthy_{700 + k}") for k in range(5)], held_out[1])


@pytest.mark.slow
def test_a_healthy_run_costs_what_the_repeats_cost_and_is_not_accused(healthy: list[Record]) -> None:
    found = answer(reference_actuator(), healthy[-1], healthy[:-1])
    assert found.evidence.channels == ("position_mm", "motor_position_mm", "current_A", "voltage_V")
    costs = [float(repeat @ repeat) for repeat in found.evidence.of_repeats]
    own = settled(found.evidence, {}).cost
    assert 0.8 * min(costs) < own < 1.2 * max(costs)
    assert (found.verdict, found.effects, found.faults) == ("adequate", (), ())
    assert found.diagnosis.fit is None


def test_every_effect_and_fault_is_a_candidate(healthy: list[Record]) -> None:
    here = settled(gather(reference_actuator(), healthy[-1], healthy[:-1]), {})
    screen = Screen(here)
    names = {candidate.effect for candidate in candidates(screen)}
    every = {*FAULTS, *(effect.name for effect in load_definitions().physical)}
    # a torque of one sign whose every shape the residual speaks against has none to try
    against = {effect.name for effect in load_definitions().physical if screen.shapes_of(effect.name) == []}
    assert names == every - against
    assert len(against) <= 1
    assert "blk" not in {candidate.effect for candidate in candidates(Screen(here), without=("blk",))}


@pytest.mark.slow
def test_a_hidden_effect_is_named_with_its_size_and_the_error_falls_to_the_floor(hot: Answer) -> None:
    assert hot.verdict == "missing"
    first = hot.effects[0]
    assert first.name == "winding_heating"
    size = "effects.winding_heating.rise_degC"
    assert abs(first.values[size] - 40.0) < 3.0 * first.std[size] < 12.0
    assert hot.errors.before > 3.0 * hot.errors.floor
    assert hot.errors.after <= 1.05 * hot.errors.floor


@pytest.mark.slow
def test_the_record_held_out_confirms_it(hot: Answer) -> None:
    errors = hot.errors
    assert errors.holdout_before is not None and errors.holdout_after is not None and errors.holdout_floor is not None
    assert errors.holdout_after < 0.5 * errors.holdout_before
    assert errors.holdout_after <= 1.15 * errors.holdout_floor


@pytest.mark.slow
def test_the_answer_has_the_keys_that_programs_read(hot: Answer) -> None:
    result = to_json(with_next(diagnosis(hot, {})))
    assert result["verdict"] == "missing"
    assert {"name", "class", "parameters", "score", "limit", "accepted"} <= set(result["effects"][0])
    assert result["effects"][0]["class"][0] == "winding_heating"
    assert {"before", "after", "floor", "holdout_before", "holdout_after"} <= set(result["error"])
    assert "ema add" in result["next_experiment"]


@pytest.mark.slow
def test_adding_the_effect_gives_the_machine_with_it(healthy: list[Record], held_out: list[Record]) -> None:
    found = add(reference_actuator(), "winding_heating", held_out[0], healthy[:-1], held_out[1])
    assert found.recommended, reason(found)
    assert found.actuator["winding_heating.rise_degC"] == pytest.approx(40.0, abs=3.0)
    true = machine(UNIT).values
    assert found.actuator["screw.csj_Nm"] == pytest.approx(true["screw.csj_Nm"], rel=0.01)
    assert found.errors.after < 0.5 * found.errors.before


@pytest.mark.slow
def test_adding_a_wrong_effect_is_not_recommended(healthy: list[Record]) -> None:
    found = add(reference_actuator(), "spring_load", healthy[-1], healthy[:-1])
    assert not found.recommended
    assert reason(found)


@pytest.mark.slow
@needs_numba
def test_a_fault_is_named_as_the_fault_and_not_as_an_effect(healthy: list[Record]) -> None:
    found = answer(reference_actuator(), run_of({"screw.csj_Nm": 0.2}, 777), healthy[:-1])
    assert found.verdict == "adequate"
    assert [one.name for one in found.faults] == ["csj"]
    assert found.faults[0].values["screw.csj_Nm"] == pytest.approx(0.2, rel=0.02)
    assert effect_of("screw.csj_Nm") == "csj"


def _noisy(changes: dict[str, float], seed: int) -> Record:
    model = reference_actuator()
    noise = {"position_mm": 0.005, "motor_position_mm": 0.002, "current_A": 0.03}
    return dataclasses.replace(
        simulate_record(model.changed(changes), make_command("chirp", model), 64, noise, seed), file=f"run_{seed}.csv"
    )


@pytest.mark.slow
def test_a_worn_one_among_the_healthy_records_is_named() -> None:
    worn = {"screw.csj_Nm": 1.4 * reference_actuator()["screw.csj_Nm"]}
    with pytest.raises(InputError, match=r"run_3\.csv: not of the same state as run_2\.csv: csj_Nm differs from theirs by"):
        answer(reference_actuator(), _noisy({}, 1), [_noisy({}, 2), _noisy(worn, 3)])


@pytest.mark.release
@pytest.mark.parametrize("changes", [{}, {"control.kp_per_m": 420.0}])
def test_two_healthy_records_that_differ_conclude_nothing(changes: dict[str, float]) -> None:
    """Neither that today's change is within repeatability, nor that a healthy record lacks an effect."""
    found = answer(reference_actuator(), _noisy(changes, 1), [_noisy({}, 2), _noisy({"control.kp_per_m": 420.0}, 3)])
    assert found.verdict == "unknown" and not found.effects and not found.faults
    assert "the healthy records differ by themselves" in sentence(found)
    assert any(one.topic == "repeats" and one.severity == "weakens" for one in found.gate.remarks)


@pytest.mark.slow
@needs_numba
def test_a_swing_beside_wear_is_found_whatever_its_phase(healthy: list[Record]) -> None:
    """Friction that has grown holds the motor longer, and another number of periods looks stronger until all three are fitted."""
    hidden = {"cogging_torque.amplitude_Nm": 0.03, "cogging_torque.periods": 14.0, "cogging_torque.phase_rad": 1.0}
    found = answer(reference_actuator(), run_of({**hidden, "screw.csj_Nm": 0.2, "screw.blk_mm": 0.055}, 830), healthy)
    assert [one.name for one in found.effects] == ["cogging_torque"] and {one.name for one in found.faults} == {"csj", "blk"}
    assert found.effects[0].values["effects.cogging_torque.periods"] == 14.0


@pytest.mark.slow
@needs_numba
def test_friction_that_has_grown_is_no_learned_table(healthy: list[Record]) -> None:
    record = run_of({"screw.csj_Nm": 0.2}, 831)
    evidence = gather(reference_actuator(), record, healthy)
    seen = today_worn(settled(evidence, {}))
    assert seen.values["screw.csj_Nm"] == pytest.approx(0.2, rel=0.02)
    places = where(evidence.actuator, record, healthy, evidence.whiten, evidence.channels)
    assert list(helpful_tables(seen, record, places)) == []


def test_a_spot_lies_where_the_record_moves(healthy: list[Record]) -> None:
    """Friction that slopes over the stroke looks like the flank of a spot far outside of it, which no record shows."""
    record = run_of({}, 832)
    start = {"effects.jam_spot.amplitude_Nm": 0.05, "effects.jam_spot.place_mm": 6.0, "effects.jam_spot.width_mm": 8.0}
    found = refit(settled(gather(reference_actuator(), record, healthy), {}), start).values
    low, high = float(record.command_mm.min()), float(record.command_mm.max())
    assert low <= found["effects.jam_spot.place_mm"] <= high
    assert found["effects.jam_spot.width_mm"] <= high - low


def test_a_machine_that_does_not_follow_is_no_mistaken_unit() -> None:
    healthy = [day(f"healthy_{700 + k}") for k in range(2)]
    stuck = dataclasses.replace(healthy[0], position_mm=0.002 * healthy[0].position_mm, file="stuck.csv")
    with pytest.raises(InputError, match=r"stuck\.csv: position_mm is 0\.002 times .* under the same command: the machine does not follow"):
        check_against_all(stuck, healthy)


@pytest.mark.slow
def test_a_fault_beside_one_effect_is_taken_before_three_effects_that_explain_no_more() -> None:
    """A colder winding and more friction on a slow triangle: the strongest single effect is a third that is not there, and two more mend it."""
    model = reference_actuator()
    command = make_command("triangle:amplitude_mm=2,start_hz=0.2", model)
    noise = {"position_mm": 0.005, "motor_position_mm": 0.002, "current_A": 0.03}
    worn = model.changed({"motor.resistance_ohm": 0.8 * model["motor.resistance_ohm"], "screw.csj_Nm": 1.25 * model["screw.csj_Nm"]})
    runs = [simulate_record(machine, command, 64, noise, seed) for seed, machine in enumerate((worn, model, model, model), start=1)]
    found = answer(model, runs[0], runs[1:])
    assert [one.name for one in found.effects] == ["winding_heating"]
    assert [one.name for one in found.faults] == ["csj"]
    assert found.faults[0].values["screw.csj_Nm"] == pytest.approx(worn["screw.csj_Nm"], rel=0.01)


@pytest.mark.release
@needs_numba
def test_without_repeats_a_hot_winding_has_the_doubt_of_the_resistance_it_hides_behind() -> None:
    """Resistance is known to 4 % from the data sheet, which is as much as 10 degC: no record alone can do better."""
    found = answer(reference_actuator(), run_of({"winding_heating.rise_degC": 120.0}, 811))
    hot = next(one for one in found.effects if one.name == "winding_heating")
    (size,), (std,) = hot.values.values(), hot.std.values()
    assert std > 6.0
    assert abs(size - 120.0) < min(3.0 * std, 40.0)


@pytest.mark.slow
@needs_numba
def test_without_repeats_a_worn_unit_lacks_no_effect() -> None:
    worn = {name: factor * machine(UNIT).values[name] for name, factor in (("screw.csj_Nm", 1.5), ("screw.blk_mm", 2.0))}
    found = answer(reference_actuator(), run_of(worn, 812))
    # the unit's own friction asymmetry of 0.3 % is really there, and one class with a constant load
    assert {one.name for one in found.effects} <= {"coulomb_asymmetry", "constant_load"}, sentence(found)


@pytest.mark.release
@needs_numba
def test_without_repeats_an_effect_in_a_narrow_valley_is_named() -> None:
    """Grease that thickens with the day does nearly what the unit's own viscous friction does: the fit has to follow the bend between the two."""
    run = measured(machine(1), {"viscous_rise.rise": 1.5}, "chirp", 813)
    record = Record(STEP_S, run.command_mm, run.position_mm, run.motor_position_mm, run.current_A, run.voltage_V, file="run")
    found = answer(reference_actuator(), record)
    assert [one.name for one in found.effects] == ["viscous_rise"], sentence(found)
    assert found.effects[0].values["effects.viscous_rise.rise"] == pytest.approx(1.5, abs=0.5)


def test_changes_side_by_side_are_seen_as_one_after_the_other() -> None:
    """A view's sensitivities and signatures are those of each change alone, bit for bit; in the place of a change that the model refuses stands the error of that."""
    actuator = reference_actuator()
    evidence = gather(actuator, simulate_record(actuator, make_command("chirp", actuator)).with_noise({"position_mm": 0.002}, 4))
    here = view(evidence, {})
    changes = [{"effects.cogging_torque.amplitude_Nm": 0.004, "effects.cogging_torque.periods": float(4 + k)} for k in range(12)]
    changes[3] = {"effects.gain_drift.drift": 0.02}
    refused = [{"screw.inertia_kgm2": 1e-9}, {"effects.cogging_torque.amplitude_Nm": 1e9}]
    asked = [refused[0], *changes, refused[1]]
    sensitivities, signatures = here.sensitivities(asked), here.signatures(asked)
    for change, many, signature in zip(changes, sensitivities[1:-1], signatures[1:-1], strict=True):
        vector = here.moved(change)
        assert isinstance(many, Sensitivity) and not isinstance(signature, InputError)
        assert vector.tobytes() == many.vector.tobytes()
        assert here.shared(vector).tobytes() == many.shared.tobytes()
        assert here.signature(change).tobytes() == signature.tobytes()
    for place, change in zip((0, -1), refused, strict=True):
        with pytest.raises(InputError) as alone:
            here.moved(change)
        assert str(alone.value) == str(sensitivities[place]) == str(signatures[place])
        with pytest.raises(InputError, match=re.escape(str(alone.value))):
            taken([sensitivities[1], sensitivities[place]])


def test_where_the_model_takes_no_other_value_the_last_view_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    """A unit at the edge of what the model takes ends the fit, not the command."""
    actuator = reference_actuator()
    record = simulate_record(
        actuator.changed({"screw.viscous_Nm_s_per_rad": 1.1 * actuator["screw.viscous_Nm_s_per_rad"]}), make_command("chirp", actuator)
    )
    evidence = gather(actuator, record.with_noise({"position_mm": 0.002, "current_A": 0.03}, 4))
    first = view(evidence, {})
    seen: list[int] = []

    def refuses(*_: object) -> View:
        seen.append(1)
        raise InputError("simulate: too far")

    monkeypatch.setattr("ema_tools.fit.evidence.view", lambda *_: first)
    monkeypatch.setattr("ema_tools.fit.evidence._seen", refuses)
    assert settled(evidence, {}) is first
    assert seen == [1]


@needs_numba
@pytest.mark.slow
@pytest.mark.parametrize(
    ("effect", "size", "value", "shape"),
    [
        ("cogging_torque", "amplitude_Nm", 0.0148, {"periods": 72.0, "phase_rad": 1.868}),
        ("torque_ripple", "ratio", 0.02, {"periods": 12.0, "phase_rad": 2.327}),
    ],
)
def test_with_the_position_alone_what_repeats_within_a_turn_is_named_with_its_periods(
    healthy: list[Record], effect: str, size: str, value: float, shape: dict[str, float]
) -> None:
    """It shows only where the machine nearly rests: as far as the filter sees, Stribeck friction does as well."""
    hidden = {f"{effect}.{name}": number for name, number in {size: value, **shape}.items()}
    alone = [Record(STEP_S, one.command_mm, one.position_mm, file=one.file) for one in (run_of(hidden, 813), *healthy[:-1])]
    found = answer(reference_actuator(), alone[0], alone[1:])
    assert [one.name for one in found.effects] == [effect]
    assert found.effects[0].values[f"effects.{effect}.periods"] == shape["periods"]
    assert found.effects[0].values[f"effects.{effect}.{size}"] == pytest.approx(value, rel=0.15)


@needs_numba
@pytest.mark.release
def test_a_large_cogging_is_named_with_its_periods(healthy: list[Record]) -> None:
    """It moves the machine by more than a period: counted along the model's motion another number, or Stribeck friction, would fit better."""
    hidden = {"cogging_torque.amplitude_Nm": 0.0444, "cogging_torque.periods": 72.0, "cogging_torque.phase_rad": 1.868}
    found = answer(reference_actuator(), run_of(hidden, 816), healthy)
    assert [one.name for one in found.effects] == ["cogging_torque"]
    values = found.effects[0].values
    assert values["effects.cogging_torque.periods"] == 72.0
    assert values["effects.cogging_torque.amplitude_Nm"] == pytest.approx(0.0444, rel=0.1)
    assert found.diagnosis.cost_after < 1.1 * found.diagnosis.cost_floor


@needs_numba
@pytest.mark.slow
@pytest.mark.parametrize(
    ("effect", "size", "value", "shape"),
    [("winding_heating", "rise_degC", 30.0, {}), ("winding_warming", "rise_degC_per_W", 18.0, {"time_s": 3.0})],
)
def test_the_size_of_a_warm_winding_holds_its_interval(
    healthy: list[Record], effect: str, size: str, value: float, shape: dict[str, float]
) -> None:
    """The resistance that scatters does nearly the same: fitted with the scatter linear, the size stopped a quarter short, in an interval that denied it."""
    found = answer(reference_actuator(), run_of({f"{effect}.{name}": one for name, one in {size: value, **shape}.items()}, 815), healthy)
    assert [one.name for one in found.effects] == [effect]
    name = f"effects.{effect}.{size}"
    here = found.effects[0]
    # four standard errors: one of thousands of records lies further off
    # a day's temperature moves the winding as well, by what baseline records leave open
    assert abs(here.values[name] - value) < 4.0 * here.std[name] < 0.5 * value


@needs_numba
@pytest.mark.slow
def test_wear_beside_an_effect_is_found_with_the_position_alone(healthy: list[Record]) -> None:
    """The strongest alone is CSJ, which then takes what belongs to BLK and to the effect."""
    own = machine(UNIT).values
    hidden = {
        "screw.csj_Nm": 1.4 * own["screw.csj_Nm"],
        "screw.blk_mm": 2.0 * own["screw.blk_mm"],
        "stribeck_friction.rise": 0.3,
        "stribeck_friction.speed_rad_s": 10.0,
    }
    alone = [Record(STEP_S, one.command_mm, one.position_mm, file=one.file) for one in (run_of(hidden, 814), *healthy[:-1])]
    found = answer(reference_actuator(), alone[0], alone[1:])
    assert [one.name for one in found.effects] == ["stribeck_friction"]
    assert sorted(one.name for one in found.faults) == ["blk", "csj"]
    assert found.effects[0].values["effects.stribeck_friction.rise"] == pytest.approx(0.3, rel=0.05)
    assert found.diagnosis.cost_after < 1.1 * found.diagnosis.cost_floor


def test_a_step_that_raises_the_error_held_out_is_refuted_with_all_that_follow() -> None:
    steps = [
        Rung((), "", 9.0, 8.0, (9.0, 8.0)),
        Rung((), "own", 5.0, 4.0, (5.0, 4.0)),
        Rung(("a",), "a", 2.0, 3.0, (2.0, 3.0)),
        Rung(("a", "b"), "b", 1.5, 3.5, (1.5, 3.5)),
        Rung(("a", "b", "c"), "c", 1.0, 2.0, (1.0, 2.0)),
    ]
    assert refuted(steps) == ("b", "c")
    assert refuted(steps[:3]) == ()
    assert refuted([Rung((), "", 9.0, None, (9.0, None)), Rung(("a",), "a", 2.0, None, (2.0, None))]) == ()


def test_repeats_of_another_command_or_too_few_are_refused(healthy: list[Record]) -> None:
    with pytest.raises(InputError, match="one healthy record tells nothing"):
        gather(reference_actuator(), healthy[-1], healthy[:1])
    worn = dataclasses.replace(day("worn_780"), file="worn.csv")
    with pytest.raises(
        InputError, match=r"worn\.csv: [\d.]+ times as far from the healthy records' median as the others are: leave it out"
    ):
        gather(reference_actuator(), healthy[-1], [*healthy[:2], worn])
    other = dataclasses.replace(healthy[0], command_mm=healthy[0].command_mm * 1.5, file="other.csv")
    with pytest.raises(InputError, match=r"other\.csv: command_mm"):
        gather(reference_actuator(), healthy[-1], [other, *healthy[1:3]])
