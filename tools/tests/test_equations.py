"""The module's equations at points, as the desk shows them, against the reference: every effect of the library, the contact, the play and the control law."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ema_tools.base.errors import InputError
from ema_tools.data.actuator import Actuator, reference_actuator
from ema_tools.library.definitions import load_definitions
from ema_tools.plant.native import POINT, SITES, library
from reference_model import encoder, pid
from reference_model.actuator import build
from reference_model.effects import SITE_FUNCTIONS, example_of, module_of
from reference_model.point import Data, Point
from reference_model.vectors.parts import PID_CASES

WARMS = ("WINDING", "GREASE")
AT_POINTS = [effect for effect in load_definitions().effects if effect.site not in ("PARAMETER", "PRESLIDING", "TRANSMISSION", *WARMS)]
BEFORE_RUN = [effect for effect in load_definitions().effects if effect.site == "PARAMETER"]
ROWS = 400


def points_of(seed: int) -> np.ndarray:
    """States all over the machine's range, the drive's voltage and a level of dry friction with its direction, [7, rows]; speeds of both signs, near zero and zero."""
    random = np.random.default_rng(seed)
    spread = {
        "current_A": 5.0,
        "speed_rad_s": 200.0,
        "angle_rad": 50.0,
        "motor_mm": 5.0,
        "voltage_V": 40.0,
        "level_Nm": 0.2,
        "direction": 1.0,
    }
    points = np.array([spread[name] * random.uniform(-1.0, 1.0, ROWS) for name in POINT])
    points[POINT.index("speed_rad_s"), :40] *= 1e-3
    points[POINT.index("speed_rad_s"), 40] = 0.0
    points[POINT.index("level_Nm")] = np.abs(points[POINT.index("level_Nm")])
    points[POINT.index("direction")] = np.sign(points[POINT.index("direction")])
    return points


def by_reference(actuator: Actuator, name: str, points: np.ndarray) -> np.ndarray:
    """The effect at every point, by the reference."""
    module, effect = module_of(name), getattr(build(actuator.values).effects, name)
    site = load_definitions().effect(name).site
    function = getattr(module, SITE_FUNCTIONS[site][0])
    data = Data(
        actuator["motor.torque_constant_Nm_per_A"],
        actuator["screw.viscous_Nm_s_per_rad"],
        actuator["screw.lead_mm"],
        actuator["drive.supply_V"],
    )
    found = []
    for current, speed, angle, motor, voltage, level, direction in points.T.tolist():
        given = (level,) if site == "FRICTION" else ()
        found.append(function(effect, *given, Point(current, speed, angle, motor, voltage, data, direction, 0.0, 0.0)))
    return np.array(found)


def test_the_sites_are_counted_as_the_module_counts_them() -> None:
    assert {effect.site for effect in load_definitions().effects} <= set(SITES)
    assert set(SITES) == set(SITE_FUNCTIONS)


@pytest.mark.parametrize("effect", AT_POINTS, ids=lambda effect: effect.name)
def test_effects_at_points_are_the_references(effect) -> None:  # type: ignore[no-untyped-def]
    viscous = {"screw.viscous_Nm_s_per_rad": 3e-4}
    actuator = reference_actuator().changed({**viscous, **example_of(effect.name)})
    points = points_of(len(effect.name))
    found = library().site(*actuator.arrays(), effect.site, points)
    expected = by_reference(actuator, effect.name, points)
    assert np.any(expected != 0.0)
    assert found == pytest.approx(expected, rel=1e-12, abs=1e-13 * float(np.max(np.abs(expected))))
    # at its zero the effect is absent
    absent = actuator.changed({effect.size.name: effect.size.nominal})
    assert not np.any(library().site(*absent.arrays(), effect.site, points))


@pytest.mark.parametrize("site", sorted({effect.site for effect in AT_POINTS}))
def test_the_effects_of_a_site_add_up(site: str) -> None:
    names = [effect.name for effect in AT_POINTS if effect.site == site]
    actuator = reference_actuator().changed({key: value for name in names for key, value in example_of(name).items()})
    points = points_of(3)
    expected = sum(by_reference(actuator, name, points) for name in names)
    assert library().site(*actuator.arrays(), site, points) == pytest.approx(expected, rel=1e-11, abs=1e-13 * np.max(np.abs(expected)))


@pytest.mark.parametrize("site", ["PARAMETER", "PRESLIDING", "TRANSMISSION", *WARMS])
def test_a_site_that_gives_no_number_at_a_point_is_refused(site: str) -> None:
    with pytest.raises(InputError, match=f"site {site}"):
        library().site(*reference_actuator().arrays(), site, points_of(1))


@pytest.mark.parametrize("site", WARMS)
def test_what_warms_follows_the_references_rate(site: str) -> None:
    (effect,) = (effect for effect in load_definitions().effects if effect.site == site)
    actuator = reference_actuator().changed(example_of(effect.name))
    module, values = module_of(effect.name), getattr(build(actuator.values).effects, effect.name)
    time_s = np.arange(3_000) * 1e-3
    current = 4.0 * np.sin(2.0 * np.pi * 0.7 * time_s)
    found = library().warmth(*actuator.arrays(), site, current, 1e-3)
    memory, resistance = 0.0, actuator["motor.resistance_ohm"]
    expected = []
    for row in range(time_s.size):
        expected.append(module.change(values, memory))
        # in pieces so small that Euler's rule is exact to what is asked
        for piece in range(20):
            amps = float(np.interp(1e-3 * (row + (piece + 0.5) / 20.0), time_s, current))
            warm = 1.0 + (module.change(values, memory) if site == "WINDING" else 0.0)
            memory += 5e-5 * module.rate_per_s(values, memory, resistance * warm * amps * amps)
    assert np.max(np.abs(expected)) > 1e-3
    assert found == pytest.approx(np.array(expected), abs=2e-4 * float(np.max(np.abs(expected))))
    absent = actuator.changed({effect.size.name: effect.size.nominal})
    assert not np.any(library().warmth(*absent.arrays(), site, current, 1e-3))
    with pytest.raises(InputError, match="site VOLTAGE"):
        library().warmth(*actuator.arrays(), "VOLTAGE", current, 1e-3)


@pytest.mark.parametrize("effect", BEFORE_RUN, ids=lambda effect: effect.name)
def test_adjusted_parameters_are_the_references(effect) -> None:  # type: ignore[no-untyped-def]
    actuator = reference_actuator().changed(example_of(effect.name))
    known = load_definitions()
    names = [row.name for row in known.reals] + [row.name for row in known.effect_values]
    found = dict(zip(names, library().adjusted(*actuator.arrays()).tolist(), strict=True))
    changed = module_of(effect.name).change_values(getattr(build(actuator.values).effects, effect.name), actuator.values)
    expected = {name: changed.get(name, actuator[name]) for name in names}
    assert any(expected[name] != actuator[name] for name in names)
    assert found == pytest.approx(expected, rel=1e-14, abs=0.0)


def test_all_parameters_change_in_the_order_of_the_list() -> None:
    names = [effect.name for effect in BEFORE_RUN]
    actuator = reference_actuator().changed({key: value for name in names for key, value in example_of(name).items()})
    expected = dict(actuator.values)
    for name in names:
        expected.update(module_of(name).change_values(getattr(build(actuator.values).effects, name), expected))
    found = library().adjusted(*actuator.arrays())
    assert found[: len(load_definitions().reals)] == pytest.approx([expected[row.name] for row in load_definitions().reals], rel=1e-13)


def test_a_transmissions_mass_stays_in_the_inertia() -> None:
    actuator = reference_actuator().changed(example_of("transmission_compliance"))
    values, options = actuator.arrays()
    assert np.array_equal(library().adjusted(values, options), values)


def test_the_contact_stretches_as_its_equation_says() -> None:
    stretch = 0.3
    actuator = reference_actuator().changed({"presliding.stretch_rad": stretch})
    angle = np.cumsum(0.1 * np.random.default_rng(7).standard_normal(ROWS))
    found = library().contact(*actuator.arrays(), angle)
    # the reference's slope along every turn, in many small parts
    module, effect = module_of("presliding"), build(actuator.values).effects.presliding
    parts, share, expected = 2000, 0.0, [0.0]
    for turn in np.diff(angle).tolist():
        side = math.copysign(1, turn)
        for _ in range(parts):
            half = share + 0.5 * turn / parts * side * module.slope_per_rad(effect, share, side, 1.0) * side
            share += turn / parts * module.slope_per_rad(effect, half, side, 1.0)
        expected.append(share)
    assert found == pytest.approx(expected, abs=1e-6)
    assert not np.any(library().contact(*reference_actuator().arrays(), angle))


def test_friction_behind_an_elastic_play_follows_its_equation_but_for_what_the_gap_holds() -> None:
    example = example_of("elastic_backlash")
    actuator = reference_actuator().changed(example)
    angle = np.cumsum(0.5 * np.random.default_rng(7).standard_normal(ROWS))
    found = library().contact(*actuator.arrays(), angle)
    module, effect = module_of("elastic_backlash"), build(actuator.values).effects.elastic_backlash
    # mm per rad of the motor
    lead = actuator["screw.lead_mm"] / (2.0 * math.pi * actuator["gearbox.ratio"])
    most = 0.5 * example["elastic_backlash.gap_mm"] + example["elastic_backlash.contact_mm"]
    ahead, expected = 0.0, [0.0]
    for turn in np.diff(angle).tolist():
        ahead = min(max(ahead + lead * turn, -most), most)
        expected.append(module.share(effect, ahead))
    assert np.ptp(expected) == 2.0
    # the module keeps its place in the gap in a hundred-thousandth of the friction
    assert found == pytest.approx(expected, abs=2.1e-5)
    one_by_one = library().contact_after(*actuator.arrays(), found[:-1], np.diff(angle))
    assert np.array_equal(one_by_one, found[1:])


def test_the_play_follows_at_half_its_width() -> None:
    width = 0.2
    actuator = reference_actuator().changed({"screw.blk_mm": width})
    motor = np.cumsum(0.05 * np.random.default_rng(8).standard_normal(ROWS))
    position, expected = 0.03, []
    for place in motor.tolist():
        position = min(max(position, place - 0.5 * width), place + 0.5 * width)
        expected.append(position)
    assert library().play(*actuator.arrays(), motor, 0.03) == pytest.approx(expected, abs=1e-15)
    there_and_back = np.array([0.0, 1.0, 1.05, 0.95, 0.9, -1.0])
    assert library().play(*actuator.arrays(), there_and_back, 0.0) == pytest.approx([0.0, 0.9, 0.95, 0.95, 0.95, -0.9])


CONTROL = {
    **{case.name: case.values for case in PID_CASES},
    "every other step": {"control.every_steps": 2, "control.kd_s_per_m": 1.5},
    "rows of two steps": {"control.every_steps": 4, "timing.record_every_steps": 2},
    "coarse": {"encoder.resolution_mm": 0.01},
    "late": {"encoder.delay_s": 0.0027},
    "very late": {"encoder.delay_s": 0.012},
    "late by an effect, coarse": {
        "feedback_delay.delay_s": 0.002,
        "encoder.delay_s": 0.0015,
        "encoder.resolution_mm": 0.005,
        "gain_drift.drift": 0.3,
    },
}


@pytest.mark.parametrize("values", CONTROL.values(), ids=CONTROL.keys())
def test_the_control_law_is_the_references(values: dict[str, float]) -> None:
    actuator = reference_actuator().changed(values)
    random = np.random.default_rng(9)
    command = np.repeat(random.uniform(-2.0, 2.0, ROWS // 20), 20)
    feedback = command + random.normal(0.0, 0.3, ROWS)
    changed = dict(actuator.values)
    for effect in BEFORE_RUN:
        if effect.name in actuator.active_effects:
            changed.update(module_of(effect.name).change_values(getattr(build(changed).effects, effect.name), changed))
    part = build(changed)
    every = part.control.every_steps // part.timing.record_every_steps
    state, expected = pid.at_rest(), []
    for row in range(ROWS):
        if row % every == 0:
            seen = encoder.feedback_mm(part.encoder, float(part.timing.step_s), feedback, row)
            state = pid.run(part.control, part.control.every_steps * part.timing.step_s, 1e-3 * command[row], 1e-3 * seen, state)
        expected.append(state.output)
    found = library().controller(*actuator.arrays(), command, feedback)
    assert np.ptp(expected) > 0.0
    assert found == pytest.approx(expected, rel=1e-11, abs=1e-11)


def test_a_feedback_later_than_the_module_keeps_is_refused() -> None:
    late = reference_actuator().changed({"encoder.delay_s": 0.012, "feedback_delay.delay_s": 0.001})
    with pytest.raises(InputError, match="controller: "):
        library().controller(*late.arrays(), np.zeros(20), np.zeros(20))


def test_both_precisions_agree_at_points() -> None:
    actuator = reference_actuator().changed(example_of("jam_spot"))
    wide, narrow = (library(bits).site(*actuator.arrays(), "FRICTION", points_of(2)) for bits in (64, 32))
    assert narrow == pytest.approx(wide, rel=1e-5, abs=1e-7)
    assert not np.array_equal(wide, narrow)
