"""What to measure next: the menu is safe and the right kind of command wins, pairs that are the same torque are not separated, and what would separate them is said."""

from __future__ import annotations

import dataclasses
import json
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

from ema_tools.base.errors import InputError
from ema_tools.data.actuator import Actuator, reference_actuator
from ema_tools.data.commands import make_command
from ema_tools.data.records import simulated
from ema_tools.design import next_experiment as following
from ema_tools.design.menu import limits_of, menu
from ema_tools.design.next_experiment import SEPARATE, Next, Option, next_experiment
from ema_tools.design.runs import USUAL_NOISE, run_of
from ema_tools.design.typical import scaled, typical_change, zero_of
from ema_tools.fit.evidence import view
from ema_tools.fit.refit import refit
from ema_tools.library.definitions import load_definitions
from ema_tools.library.faults import FAULTS
from ema_tools.library.measurements import MEASUREMENTS
from ema_tools.library.registry import separating
from ema_tools.select.candidates import signatures
from ema_tools.select.matched_filter import Screen
from ema_tools.tasks.simulate import simulate_record
from ema_tools.words.sentences.experiment import advice, offence, sentence
from support import REFERENCE, complaint, run_ema

pytestmark = pytest.mark.release


def option(found: Next, title: str) -> Option:
    """The option of the menu called `title`."""
    return next(one for one in found.options if one.title == title)


def test_drag_of_two_kinds_needs_speed() -> None:
    found = next_experiment(reference_actuator(), ["quadratic_viscous", "viscous_rise"])
    assert found.best is not None
    assert found.best.separation > 10.0
    assert found.best.peak_speed_mm_s > 0.5 * found.limits.speed_mm_s
    assert found.best.peak_speed_mm_s > 5.0 * option(found, "slow triangle").peak_speed_mm_s
    assert option(found, "slow triangle").separation < 1.0
    assert option(found, "chirp").separation > 10.0 * option(found, "slow triangle").separation
    assert found.best.command in sentence(found)


def test_no_command_tells_a_load_from_an_asymmetry_and_what_would_is_said() -> None:
    found = next_experiment(reference_actuator(), ["constant_load", "coulomb_asymmetry"])
    assert found.best is None
    assert max(one.separation for one in found.options) < 0.1
    # far above detection, so it is not for lack of size
    assert found.hidden == ()
    assert max(one.shown["coulomb_asymmetry"] for one in found.options) > 30.0
    assert "turn the actuator over" in sentence(found)


def test_a_constant_load_and_a_spring_are_told_apart() -> None:
    found = next_experiment(reference_actuator(), ["constant_load", "spring_load"])
    assert found.best is not None
    assert not advice(found)


def test_a_bad_spot_and_a_ripple_of_the_screw_need_more_than_one_lead() -> None:
    found = next_experiment(reference_actuator(), ["jam_spot", "pitch_ripple"])
    assert found.best is not None
    assert "several leads" in found.best.title
    assert found.best.separation > 5.0 * option(found, "chirp").separation


def test_the_separation_is_what_noisy_records_show() -> None:
    """On a record with noise, the wrong effect's best fit costs the square of the separation more than the right one's."""
    actuator = reference_actuator()
    names = ("quadratic_viscous", "viscous_rise")
    values = {"effects.quadratic_viscous.drag_Nm_s2_per_rad2": 3e-8}
    channels = ("position_mm", "current_A")
    said = option(next_experiment(actuator, names, channels, values), "chirp")
    run = run_of(actuator, "chirp", said.command)
    evidence = following._evidence(actuator, run, channels, USUAL_NOISE)
    clean = evidence.simulate(values, np.zeros(len(evidence.spread)))
    random = np.random.default_rng(5)
    extra = []
    for _ in range(8):
        noisy = clean + np.sqrt(evidence.noise[:, :1]) * random.normal(size=clean.shape)
        seen = view(dataclasses.replace(evidence, target=noisy), {})
        wrong, right = (
            min(refit(seen, one.start()).cost for one in signatures(Screen(seen), only=(name,))[:2])
            for name in ("viscous_rise", "quadratic_viscous")
        )
        extra.append(wrong - right)
    # one direction of the pair, and the share to which the model is trusted taken out
    one_way = following._left(view(dataclasses.replace(evidence, target=clean), {}), "viscous_rise") ** 2 * (
        1.0 + following._MODEL_ERROR**2 * said.shown["quadratic_viscous"] ** 2
    )
    assert one_way > 25.0
    assert np.mean(extra) == pytest.approx(one_way, abs=4.0 * 2.0 * np.sqrt(one_way / len(extra)) + 2.0)
    assert said.separation <= np.sqrt(one_way)


def test_a_signal_that_is_not_recorded_is_asked_for() -> None:
    # a stiff loop hides a torque from the position: what is small there is plain in the current
    values = {"effects.viscous_rise.rise": 0.05, "effects.inertia_change.change": 0.005}
    alone = next_experiment(reference_actuator(), ["viscous_rise", "inertia_change"], ("position_mm",), values)
    assert alone.best is None
    assert alone.hidden
    assert alone.with_channels is not None
    names, better = alone.with_channels
    assert names == ("position_mm", "current_A")
    assert better.separation >= SEPARATE
    assert "Record current_A too" in sentence(alone)
    with_current = next_experiment(reference_actuator(), ["viscous_rise", "inertia_change"], names, values)
    assert with_current.best is not None
    assert with_current.best.separation == pytest.approx(better.separation)


def test_three_effects_are_ranked_by_their_worst_pair() -> None:
    found = next_experiment(reference_actuator(), ["constant_load", "coulomb_asymmetry", "inertia_change"])
    assert found.confused == (("constant_load", "coulomb_asymmetry"),)
    first = found.options[0]
    assert first.separation == min(first.pairs.values())
    assert max(one.pairs["constant_load", "inertia_change"] for one in found.options) > SEPARATE


def test_more_noise_separates_less() -> None:
    def chirp(noise: float) -> float:
        found = next_experiment(
            reference_actuator(),
            ["quadratic_viscous", "viscous_rise"],
            ("current_A",),
            noise={"current_A": noise},
            own_limits={"stroke_mm": 5.0},
        )
        return option(found, "chirp").separation

    assert chirp(0.03) > 1.5 * chirp(0.3)


@pytest.mark.parametrize("supply_V", [24.0, 12.0])
def test_what_is_recommended_is_safe_on_the_machine(supply_V: float) -> None:
    actuator = reference_actuator().changed({"drive.supply_V": supply_V})
    found = next_experiment(actuator, ["winding_heating", "viscous_rise"])
    assert found.best is not None
    for one in found.options:
        command = make_command(one.command, actuator)
        run = simulated(actuator, simulate_record(actuator, command))
        assert np.max(np.abs(run.position_mm)) <= 0.8 * actuator["screw.travel_mm"]
        assert np.max(np.abs(run.voltage_V)) <= 0.95 * supply_V * (1.0 + 1e-6)
        assert np.max(np.abs(run.current_A)) <= found.limits.current_A
        assert np.max(np.abs(run.speed_mm_s)) <= found.limits.speed_mm_s


def test_an_unsafe_command_is_left_out_and_said() -> None:
    found = next_experiment(
        reference_actuator(),
        ["quadratic_viscous", "viscous_rise"],
        own_limits={"speed_mm_s": 20.0},
        more=["chirp:amplitude_mm=2,end_hz=4", "triangle:amplitude_mm=30"],
    )
    said = [offence(reason) for command, reason in found.unsafe.items() if command.startswith("own command")]
    assert len(said) == 2
    assert all("allowed is" in reason for reason in said)
    assert all(one.peak_speed_mm_s <= 20.0 for one in found.options)
    nothing = next_experiment(reference_actuator(), ["quadratic_viscous", "viscous_rise"], own_limits={"current_A": 1e-3})
    assert not nothing.options
    assert "No command of the menu is safe" in sentence(nothing)


def test_the_menu_fits_small_and_large_machines() -> None:
    reference = reference_actuator()
    assert menu(reference, limits_of(reference))["chirp"] == "chirp:amplitude_mm=2,start_hz=0.1,end_hz=4,duration_s=10"
    for changes in ({"screw.travel_mm": 1.5}, {"screw.travel_mm": 500.0, "screw.lead_mm": 20.0}, {"timing.step_s": 0.01}):
        actuator = reference.changed(changes)
        limits = limits_of(actuator)
        for title, text in menu(actuator, limits).items():
            samples = make_command(text, actuator).samples_mm
            assert np.max(np.abs(samples)) <= limits.stroke_mm, title


def test_every_effect_has_a_size_that_the_model_takes() -> None:
    reference = reference_actuator()
    for effect in [*FAULTS, *(row.name for row in load_definitions().effects if not row.is_learned)]:
        values = typical_change(reference, effect, 7.0)
        assert values is not None, f"{effect}: no usual size: give its record one"
        size, present = zero_of(reference, effect)
        assert values[size] != present
        reference.changed(values)
        larger = scaled(reference, effect, values, 3.0)
        reference.changed(larger)
        if effect != "current_limit":
            assert abs(larger[size] - present) == pytest.approx(3.0 * abs(values[size] - present))


def test_an_effect_without_a_usual_size_gets_one_that_shows(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(following, "typical_change", lambda *_: None)
    found = next_experiment(reference_actuator(), ["winding_heating", "viscous_rise"])
    assert min(option(found, "chirp").shown.values()) >= 30.0
    assert max(option(found, "chirp").shown.values()) < 200.0


def test_every_measurement_separates_something() -> None:
    known = [*FAULTS, *(row.name for row in load_definitions().effects)]
    separated = {one for pair in combinations(known, 2) for one in separating(pair)}
    assert separated == set(MEASUREMENTS)


def test_a_change_of_an_effect_that_is_there_already_is_compared() -> None:
    warm: Actuator = reference_actuator().changed({"effects.winding_heating.rise_degC": 20.0})
    found = next_experiment(warm, ["winding_heating", "supply_sag"])
    assert found.values["winding_heating"]["effects.winding_heating.rise_degC"] == 50.0
    assert found.best is not None


def test_the_command_line_writes_the_result(tmp_path: Path) -> None:
    result = tmp_path / "next.json"
    ran = run_ema(
        "next", REFERENCE, "--between", "inertia_change", "viscous_rise", "--set", "effects.inertia_change.change=0.1", "--json", result
    )
    assert ran.code == 0, ran.err
    assert ran.out.startswith("Next: ")
    found = json.loads(result.read_text())
    assert found["effects"] == ["inertia_change", "viscous_rise"]
    assert found["sizes"]["inertia_change"] == {"change": 0.1}
    assert found["best"]["separation"] >= found["needed"]
    assert found["options"][0] == found["best"]
    assert found["confused"] == []


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (["--between", "inertia_chang", "csj"], "inertia_change"),
        (["--between", "csj"], "two or more"),
        (["--between", "csj", "blk", "--set", "effects.inertia_change.change=0.1"], "belongs to none"),
        (["--between", "csj", "inertia_change", "--set", "effects.inertia_change.change=0"], "is not there"),
        (["--between", "csj", "inertia_change", "--set", "effects.inertia_change.change"], "no value"),
        (["--between", "csj", "blk", "--channels", "curent_A"], "current_A"),
        (["--between", "csj", "blk", "--limit", "strok_mm=4"], "stroke_mm"),
        (["--between", "csj", "blk", "--limit", "stroke_mm=-4"], "above zero"),
        (["--between", "csj", "blk", "--also", "chirb"], "chirp"),
        (["--between", "csj", "learned_torque"], "learned_torque"),
    ],
)
def test_bad_questions_are_refused_in_one_line(arguments: list[str], named: str) -> None:
    assert named in complaint(run_ema("next", REFERENCE, *arguments))


def test_bad_values_raise() -> None:
    with pytest.raises(InputError, match="torque_Nm"):
        next_experiment(reference_actuator(), ["constant_load", "csj"], values={"effects.constant_load.torque_Nm": 1e9})
