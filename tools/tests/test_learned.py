"""Learned tables in Python: told apart from physical effects, kept by TOML and export, refused by name, flown as the reference has them, and a verdict that says when one was left."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from ema_tools.base.errors import InputError
from ema_tools.data.actuator import Actuator, read_actuator, reference_actuator
from ema_tools.library.definitions import TableAxis, load_definitions
from ema_tools.plant.native import library
from ema_tools.tasks.export import flat_text, header_text
from reference_model import table
from reference_model.actuator import build
from reference_model.effects import example_of
from reference_model.point import Data, Point
from support import ROOT, chirp_record, run_ema

LEARNED = tuple(effect.name for effect in load_definitions().effects if effect.is_learned)


def learned(name: str, **values: float) -> Actuator:
    """The reference actuator with the example of `name`, changed by `values`."""
    example = {key: value for key, value in example_of(name).items() if key.startswith(name)}
    return reference_actuator().changed(example | {f"{name}.{field}": value for field, value in values.items()})


def test_tables_are_told_apart_from_physical_effects() -> None:
    assert LEARNED == ("learned_torque", "learned_friction", "learned_voltage", "learned_reading")
    known = load_definitions()
    assert [known.effect(name).site for name in LEARNED] == ["TORQUE", "FRICTION", "VOLTAGE", "READING"]
    for name in LEARNED:
        effect = known.effect(name)
        assert [row.field for row in effect.parameters[:4]] == ["gain", "axis", "first", "last"]
        assert [row.field for row in effect.nodes] == [f"node_{k:02d}" for k in range(16)]
    assert known.effect("spring_load").nodes == ()
    assert not known.effect("spring_load").is_learned


def test_axes_are_those_of_the_module() -> None:
    found = re.findall(r"EMA_AXIS_(\w+) = (\d)", (ROOT / "include" / "ema" / "ema_actuator.h").read_text())
    assert [(axis.name, str(axis.value)) for axis in TableAxis] == found
    row = load_definitions().find("learned_torque.axis")
    assert (row.lower, row.upper) == (min(TableAxis), max(TableAxis))


@pytest.mark.parametrize("name", LEARNED)
def test_toml_export_and_library_page_carry_a_table(name: str, tmp_path: Path) -> None:
    actuator = learned(name, gain=0.5)
    (tmp_path / "a.toml").write_text(actuator.written_text(), encoding="utf-8")
    again = read_actuator(tmp_path / "a.toml")
    assert again.values == actuator.values
    assert again.active_effects == (name,)
    for field in ("gain", "first", "node_00", "node_15"):
        value = actuator[f"{name}.{field}"]
        assert f"effects.{name}.{field} = {value!r}" in flat_text(actuator)
    block = header_text(actuator).split(f"/* {name} */")[1].split("},")[0]
    assert len(re.findall(r"f, /\* node_\d\d \*/", block)) == 16
    shown = run_ema("effects", name).out
    assert "node_15" in shown
    assert "table(axis)" in shown
    assert "learned: no physical effect but a table" in shown
    assert "learned: " not in run_ema("effects", "spring_load").out


@pytest.mark.parametrize(
    ("name", "values", "named"),
    [
        ("learned_torque", {"last": 0.0}, "learned_torque.first"),
        ("learned_friction", {"axis": 1.5}, "learned_friction.axis"),
        ("learned_reading", {"last": 5.5}, "learned_reading.last"),
    ],
)
@pytest.mark.parametrize("bits", [32, 64])
def test_table_that_cannot_be_read_is_named(name: str, values: dict[str, float], named: str, bits: int) -> None:
    with pytest.raises(InputError, match=re.escape(named)) as error:
        library(bits).check(*learned(name, **values).arrays())
    assert "\n" not in str(error.value)
    library(bits).check(*learned(name, **values, gain=0.0).arrays())


@pytest.mark.slow
@pytest.mark.parametrize("axis", range(5))
def test_reference_interpolates_as_numpy_does(axis: int) -> None:
    rng = np.random.default_rng(axis)
    nodes = rng.normal(size=16)
    first, last = (0.5, 5.0) if axis in (2, 3) else (-3.0, 4.0)
    named = {f"learned_torque.node_{k:02d}": float(node) for k, node in enumerate(nodes)}
    values = (
        reference_actuator()
        .changed(
            {"learned_torque.gain": 2.0, "learned_torque.axis": axis, "learned_torque.first": first, "learned_torque.last": last, **named}
        )
        .values
    )
    effect = build(values).effects.learned_torque
    period = {2: 5.0, 3: 2.0 * np.pi}.get(axis)
    places = np.linspace(first, last, 16)
    for at in rng.uniform(-20.0, 20.0, 300):
        speed, position, angle, current = (
            (at if axis == 0 else 7e3),
            (at if axis in (1, 2) else 7e3),
            (at if axis == 3 else 7e3),
            (at if axis == 4 else 7e3),
        )
        point = Point(current, speed, angle, position, 0.0, Data(0.06, 1e-4, 5.0, 24.0), 0.0, 0.0, 0.0)
        assert table.value(effect, point) == pytest.approx(2.0 * np.interp(at, places, nodes, period=period), abs=1e-12)


def test_identification_says_that_a_table_was_left() -> None:
    wide = learned("learned_friction", first=-3.0, last=3.0)
    narrow = learned("learned_friction", first=-1.0, last=1.0)
    reason = "a learned table was used outside the range it was seen in"
    for actuator, left in ((wide, False), (narrow, True)):
        record = chirp_record(actuator)
        found = library(32).identify(*actuator.arrays(), record.command_mm, record.table())
        assert (reason in found.reasons) == left
        assert found.verdict == ("undecided" if left else "healthy")
        assert found.adequate
