"""Many runs side by side have the bits of runs one after the other: every effect, command, kind of event and form of the blocks."""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence

import numpy as np
import pytest

from benchmarks.effects import costed_changes
from ema_tools.base.arrays import Reals
from ema_tools.base.errors import InputError, LibraryError
from ema_tools.data.actuator import reference_actuator
from ema_tools.library.definitions import load_definitions, named_library
from ema_tools.plant.lanes import Lanes, lanes
from ema_tools.plant.native import OUTPUTS, library

STEP_S = 1e-3
ROWS = 3000
EFFECTS = tuple(effect.name for effect in load_definitions().effects)
_CHIRP = {"amplitude_mm": 2.0, "start_hz": 0.1, "end_hz": 8.0, "duration_s": 3.0}

# What brings runs to the events of the motion, and the blocks to their other forms.
FORMS: Mapping[str, Mapping[str, float]] = {
    "as it is": {},
    "stops": {"screw.travel_mm": 1.4},
    "a limit of the current": {"drive.current_limit_A": 2.0, "motor.torque_limit_Nm": 0.18},
    "a limit of the torque": {"motor.torque_limit_Nm": 0.16},
    "a drive that holds the current": {"drive.current_limit_A": 2.2},
    "a late drive": {"drive.output_delay_s": 2.4e-3},
    "a drive that is late by whole steps": {"drive.output_delay_s": 2e-3},
    "a late and coarse sensor": {"encoder.delay_s": 1.3e-3, "encoder.resolution_mm": 0.002, "encoder.side": 1},
    "derivative action": {"control.kd_s_per_m": 2.0, "control.average_speed": 1},
    "a cascade": {
        "control.structure": 1, "control.position_gain_per_s": 40.0, "control.speed_gain_s_per_m": 20.0, "control.speed_integral_per_m": 50.0,
    },
    "control at every third step": {"control.every_steps": 3},
    "a current loop": {"drive.mode": 1, "drive.current_scale_A": 10.0, "drive.current_loop_s": 5e-4},
    "a current loop short of voltage": {"drive.mode": 1, "drive.current_scale_A": 30.0, "drive.current_loop_s": 5e-4, "drive.supply_V": 3.0},
    "an ideal current loop": {"drive.mode": 1, "drive.current_scale_A": 10.0, "drive.current_loop_s": 0.0, "drive.current_limit_A": 4.0},
    "no inductance": {"motor.inductance_H": 0.0},
    "substeps": {"timing.substeps": 3},
    "rows apart": {"timing.record_every_steps": 4},
    "no play, dynamic friction": {"screw.blk_mm": 0.0, "screw.dynamic_ratio": 0.6, "screw.load_torque_Nm": 0.05, "gearbox.efficiency": 0.8},
}  # fmt: skip


@functools.cache
def command(kind: str) -> Reals:
    if kind == "rests":
        wave = library().command("triangle", {"amplitude_mm": 1.5, "start_hz": 1.0, "end_hz": 1.0, "duration_s": 3.0}, STEP_S, ROWS)
        return np.where((np.arange(ROWS) // 400) % 2 == 0, wave, np.round(wave))
    if kind == "steps":
        return np.where((np.arange(ROWS) // 700) % 2 == 0, 0.0, 1.8)
    return library().command("chirp", _CHIRP, STEP_S, ROWS)


def rows_of(changes: Sequence[Mapping[str, float]]) -> tuple[Reals, np.ndarray]:
    actuators = [reference_actuator().changed(change).arrays() for change in changes]
    assert all(np.array_equal(options, actuators[0][1]) for _, options in actuators)
    return np.array([values for values, _ in actuators]), actuators[0][1]


def spread_over(changes: Mapping[str, float], runs: int) -> list[dict[str, float]]:
    """Runs that differ in size: friction, inertia and play by a few per cent, what is changed by a share of its change."""
    reference = reference_actuator().values
    sizes = [name for name in changes if name.endswith(tuple(f"{e.name}.{e.parameters[0].field}" for e in load_definitions().effects))]
    return [
        {
            "screw.csj_Nm": reference["screw.csj_Nm"] * (1.0 + 0.02 * k),
            "screw.inertia_kgm2": reference["screw.inertia_kgm2"] * (1.0 + 0.01 * (k % 3)),
            **changes,
            **{name: changes[name] * (1.0 + 0.3 * k / runs) for name in sizes},
        }
        for k in range(runs)
    ]  # fmt: skip


def assert_same_bits(changes: Sequence[Mapping[str, float]], command_mm: Reals, bits: int = 64, start_mm: float = 0.0) -> None:
    values, options = rows_of(changes)
    alone = [library(bits).simulate(row, options, command_mm, start_mm) for row in values]
    together = library(bits).simulate_many(values, options, command_mm, start_mm=start_mm)
    for one, many in zip(alone, together, strict=True):
        assert isinstance(many, np.ndarray)
        for name, signal in zip(OUTPUTS, many, strict=True):
            assert getattr(one, name).tobytes() == signal.tobytes(), name
    build = lanes(bits, len(values))
    assert build is not None
    with build.simulated(values, options, command_mm, start_mm) as runs:
        assert runs.unlocated_event_steps.tolist() == [one.unlocated_event_steps for one in alone]


@pytest.mark.parametrize("bits", [32, 64])
@pytest.mark.parametrize("effect", EFFECTS)
def test_every_effect_at_two_sizes(effect: str, bits: int) -> None:
    changes = costed_changes()[effect]
    size = next(iter(changes))
    # in float32 the first are enough for all lanes, the others go into half as many
    assert_same_bits(spread_over(changes, 9), command("chirp"), bits)
    assert_same_bits(spread_over({**changes, size: 0.4 * changes[size]}, 5), command("rests"), bits)


@pytest.mark.parametrize("kind", ["chirp", "rests", "steps"])
@pytest.mark.parametrize("form", FORMS)
def test_every_form_of_the_blocks(form: str, kind: str) -> None:
    assert_same_bits(spread_over(FORMS[form], 6), command(kind))


@pytest.mark.parametrize(
    "effect", ["stribeck_friction", "presliding", "transmission_compliance", "source_resistance", "torque_ripple", "learned_torque"]
)
@pytest.mark.parametrize(
    "form",
    [
        "stops",
        "a limit of the current",
        "a drive that holds the current",
        "a late drive",
        "a current loop short of voltage",
        "no inductance",
        "substeps",
    ],
)
def test_effects_beside_events(form: str, effect: str) -> None:
    assert_same_bits(spread_over({**costed_changes()[effect], **FORMS[form]}, 5), command("rests"))


@pytest.mark.parametrize("bits", [32, 64])
def test_all_effects_together(bits: int) -> None:
    together = {name: value for changes in costed_changes().values() for name, value in changes.items()}
    assert_same_bits(spread_over(together, 6), command("chirp"), bits, start_mm=0.7)


@pytest.mark.parametrize("bits", [32, 64])
@pytest.mark.parametrize("runs", [1, 2, 3, 4, 5, 8, 9, 15, 16, 17, 37])
def test_any_number_of_runs(runs: int, bits: int) -> None:
    assert_same_bits(spread_over({}, runs), command("chirp"), bits)


def test_runs_of_different_shapes_find_their_own_company() -> None:
    dead_time = costed_changes()["inverter_dead_time"]
    mixed = [
        change
        for pair in zip(spread_over({}, 6), spread_over(dead_time, 6), spread_over(FORMS["a late drive"], 6), strict=True)
        for change in pair
    ]
    assert_same_bits(mixed, command("chirp"))


def test_effects_that_act_before_a_run_keep_company_with_others() -> None:
    """A winding that heats, a gain that drifts and a current limit that is reached are numbers of the plant; with a run alone on its lanes, too."""
    before = [costed_changes()[effect] for effect in ("winding_heating", "gain_drift", "inertia_change", "supply_sag")]
    limit = {"effects.current_limit.limit_A": 3.0}
    for changes in ([limit, *before, {}], [*before, {}, limit], [limit, limit, limit, limit, limit], [*before, *before, limit, {}]):
        assert_same_bits(changes, command("rests"))
        assert_same_bits([{**change, **costed_changes()["presliding"]} for change in changes], command("chirp"), 32)


def test_a_run_that_is_refused_or_diverges_leaves_the_others_alone() -> None:
    # back-calculation that swings up, as far as the module allows it
    changes = spread_over({}, 9)
    values, options = rows_of(changes)
    ids = load_definitions().ids
    values[1, ids["screw.csj_Nm"]] = np.nan
    values[3, ids["screw.inertia_kgm2"]] = -1.0
    values[4, ids["control.kp_per_m"]] = 1e308
    together = library().simulate_many(values, options, command("chirp"))
    for row, many in zip(values, together, strict=True):
        try:
            one = library().simulate(row, options, command("chirp"))
        except InputError as error:
            assert isinstance(many, InputError)
            assert str(many) == str(error)
        else:
            assert isinstance(many, np.ndarray)
            assert np.array_equal(one.current_A, many[OUTPUTS.index("current_A")])
    assert [isinstance(many, InputError) for many in together][:4] == [False, True, False, True]


def test_a_command_that_is_no_number_is_refused_for_all() -> None:
    values, options = rows_of(spread_over({}, 6))
    broken = command("chirp").copy()
    broken[50] = np.nan
    refused = library().simulate_many(values, options, broken)
    with pytest.raises(InputError) as single:
        library().simulate(values[0], options, broken)
    assert [str(error) for error in refused] == [str(single.value)] * 6


@pytest.mark.parametrize(("bits", "name"), [(32, "ema_lanes32"), (32, "ema_lanes32_few"), (64, "ema_lanes64")])
def test_every_build_has_the_same_bits(bits: int, name: str) -> None:
    changes = {
        name: value
        for effect in ("stribeck_friction", "jam_spot", "inverter_dead_time")
        for name, value in costed_changes()[effect].items()
    }
    values, options = rows_of(spread_over(changes, 6 if name.endswith("few") else 9))
    best = lanes(bits, len(values))
    assert best is not None
    assert best.path.name.startswith(f"lib{name}_avx2" if best.avx2 else f"lib{name}.")
    plain = Lanes(name, bits)
    with (
        best.simulated(values, options, command("chirp"), 0.0) as first,
        plain.simulated(values, options, command("chirp"), 0.0) as second,
    ):
        assert first.out.tobytes() == second.out.tobytes()
    assert not np.any(first.status)
    # most spans go through the lanes, some do not
    assert 0.0 < first.left < 0.1 * first.spans


def test_a_build_of_another_kind_is_refused() -> None:
    assert named_library("ema_lanes64").is_file()
    with pytest.raises(LibraryError, match="built for 64 bits"):
        Lanes("ema_lanes64", 32)


def test_without_the_lanes_runs_go_one_after_the_other(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("ema_tools.plant.native.lanes", lambda bits, runs: None)
    values, options = rows_of(spread_over({}, 2))
    values[1, load_definitions().ids["screw.csj_Nm"]] = np.nan
    good, bad = library().simulate_many(values, options, command("chirp"), ("current_A", "position_mm"))
    alone = library().simulate(values[0], options, command("chirp"))
    assert isinstance(good, np.ndarray)
    assert good.tobytes() == np.array([alone.current_A, alone.position_mm]).tobytes()
    assert isinstance(bad, InputError)


def test_memory_is_lent_again_and_never_to_two_at_once() -> None:
    build = Lanes("ema_lanes32", 32)
    values, options = rows_of(spread_over({}, 4))
    other, _ = rows_of(spread_over({"screw.csj_Nm": 0.3}, 4))
    with build.simulated(values, options, command("chirp"), 0.0) as first:
        shown, place = first.out.copy(), first.out.ctypes.data
        assert place % 64 == 0
        with build.simulated(other, options, command("chirp"), 0.0) as second:
            assert not np.shares_memory(first.out, second.out)
            assert not np.array_equal(second.out, shown)
        assert np.array_equal(first.out, shown)
    with build.simulated(other, options, command("steps"), 0.0) as third:
        assert third.out.ctypes.data == place


def test_a_current_that_the_drive_holds_stays_in_the_lanes() -> None:
    values, options = rows_of(spread_over(FORMS["a drive that holds the current"], 9))
    build = lanes(32, len(values))
    assert build is not None
    with build.simulated(values, options, command("chirp"), 0.0) as runs:
        held = np.abs(runs.out[:, OUTPUTS.index("current_A")]) == np.float32(2.2)
        # a span leaves as the current comes to its limit and as it goes, not while it is there
        assert 0 < runs.left < 0.2 * np.count_nonzero(held)
