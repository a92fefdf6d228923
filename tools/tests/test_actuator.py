"""Actuator files: the shipped one, round trips, comments, and what is complained about."""

from __future__ import annotations

import math
import re
from pathlib import Path

import pytest
import tomlkit
from hypothesis import given
from hypothesis import strategies as st

from ema_tools.base.errors import InputError
from ema_tools.data.actuator import (
    Actuator,
    nearest,
    read_actuator,
    reference_actuator,
    row_of,
    shown,
)
from ema_tools.library.definitions import EffectParameter, Parameter, load_definitions
from support import REFERENCE

ROWS = (*load_definitions().parameters, *load_definitions().effect_values)


def value_of(row: Parameter | EffectParameter) -> st.SearchStrategy[float]:
    if isinstance(row, Parameter) and row.is_option:
        return st.integers(int(row.lower), int(row.upper)).map(float)
    return st.floats(row.lower, row.upper, allow_nan=False)


changes = st.dictionaries(st.sampled_from(ROWS), st.none(), max_size=12).flatmap(
    lambda rows: st.fixed_dictionaries({row.name: value_of(row) for row in rows})
)


def test_travel_per_motor_angle_has_the_gear_ratio() -> None:
    actuator = reference_actuator().changed({"screw.lead_mm": 5.0, "gearbox.ratio": 4.0})
    assert actuator.lead_mm_per_rad == pytest.approx(5.0 / (8.0 * math.pi))


def read_text(text: str, folder: Path) -> Actuator:
    path = folder / "a.toml"
    path.write_text(text, encoding="utf-8")
    return read_actuator(path)


@pytest.mark.parametrize("value", ["inf", "-inf", "nan"])
@pytest.mark.parametrize(("key", "said"), [("every_steps", "not a whole number"), ("step_s", "outside ")])
def test_numbers_that_are_none_are_refused(tmp_path: Path, key: str, value: str, said: str) -> None:
    text, count = re.subn(rf"^({key} *= )[0-9.e-]+", rf"\g<1>{value}", REFERENCE.read_text(encoding="utf-8"), count=1, flags=re.MULTILINE)
    assert count == 1
    (tmp_path / "a.toml").write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=rf"a\.toml: \w+\.{key} = {value}: {said}"):
        read_actuator(tmp_path / "a.toml")


def test_shipped_file_is_the_nominal_column() -> None:
    assert read_actuator(REFERENCE).values == reference_actuator().values


def test_shipped_file_explains_every_value() -> None:
    lines = {line.split("=")[0].strip(): line for line in REFERENCE.read_text(encoding="utf-8").splitlines() if "=" in line}
    for row in load_definitions().parameters:
        assert "# " in lines[row.field]
        assert row.text in lines[row.field]
        assert not row.unit or f"[{row.unit}]" in lines[row.field]


@given(changes)
def test_round_trip_of_a_fresh_file(tmp_path_factory: pytest.TempPathFactory, changed: dict[str, float]) -> None:
    actuator = reference_actuator().changed(changed)
    assert read_text(actuator.written_text(), tmp_path_factory.mktemp("a")).values == actuator.values


@pytest.mark.slow
@given(changes)
def test_round_trip_of_the_shipped_file_keeps_its_comments(tmp_path_factory: pytest.TempPathFactory, changed: dict[str, float]) -> None:
    shipped = REFERENCE.read_text(encoding="utf-8")
    actuator = read_actuator(REFERENCE).changed(changed)
    text = actuator.written_text()
    assert read_text(text, tmp_path_factory.mktemp("a")).values == actuator.values
    comments = [line.split("#", 1)[1] for line in shipped.splitlines() if "#" in line]
    for comment in comments:
        assert comment in text


def test_unchanged_file_is_written_as_it_was() -> None:
    assert read_actuator(REFERENCE).written_text() == REFERENCE.read_text(encoding="utf-8")


def test_comments_and_order_of_the_user_stay(tmp_path: Path) -> None:
    text = "# my machine\n" + REFERENCE.read_text(encoding="utf-8").replace("csj_Nm = 0.138 ", "csj_Nm = 0.138 # measured in May;", 1)
    changed = read_text(text, tmp_path).changed({"screw.csj_Nm": 0.2, "stribeck_friction.rise": 0.3})
    written = changed.written_text()
    assert written.startswith("# my machine\n")
    assert "csj_Nm = 0.2 # measured in May;" in written
    assert "[effects.stribeck_friction]" in written
    again = read_text(written, tmp_path)
    assert again.values == changed.values
    assert again.active_effects == ("stribeck_friction",)


def test_arrays_stand_in_the_order_of_the_lists() -> None:
    actuator = reference_actuator().changed({"screw.csj_Nm": 0.2, "control.structure": 1, "spring_load.stiffness_Nm_per_mm": 0.5})
    values, options = actuator.arrays()
    ids = load_definitions().ids
    assert values[ids["screw.csj_Nm"]] == 0.2
    assert values[ids["spring_load.stiffness_Nm_per_mm"]] == 0.5
    assert options[ids["control.structure"] - len(values)] == 1


def edited(old: str, new: str) -> str:
    text = REFERENCE.read_text(encoding="utf-8")
    assert old in text
    return text.replace(old, new, 1)


BAD = [
    (
        "unknown key",
        lambda: edited("inductance_H =", "inductanse_H ="),
        "a.toml: motor.inductanse_H: unknown key (did you mean inductance_H?)",
    ),
    ("unknown table", lambda: edited("[gearbox]", "[gear]"), "a.toml: [gear]: unknown table (did you mean gearbox?)"),
    (
        "text for a number",
        lambda: edited("supply_V = 24.0", 'supply_V = "24 V"'),
        'a.toml: drive.supply_V = "24 V": not a number: give one in 0.1 .. 2000 V, without quotes',
    ),
    (
        "a number as a text",
        lambda: edited("supply_V = 24.0", "supply_V = '24.0'"),
        'a.toml: drive.supply_V = "24.0": not a number: give one in 0.1 .. 2000 V, without quotes',
    ),
    (
        "a text for a whole number",
        lambda: edited("every_steps = 1 ", 'every_steps = "1" '),
        'a.toml: control.every_steps = "1": not a number: ',
    ),
    (
        "a number as a text in an effect",
        lambda: edited("[control]", '[effects.stribeck_friction]\nrise = "0.1"\n[control]'),
        'a.toml: effects.stribeck_friction.rise = "0.1": not a number: ',
    ),
    (
        "a number without end",
        lambda: edited("supply_V = 24.0", f"supply_V = 1{'0' * 400}"),
        "a.toml: drive.supply_V: a number of more digits than any value has",
    ),
    ("yes for a number", lambda: edited("supply_V = 24.0", "supply_V = true"), "a.toml: drive.supply_V = True: not a number"),
    ("out of range", lambda: edited("csj_Nm = 0.138", "csj_Nm = 138.0"), "a.toml: screw.csj_Nm = 138.0: outside 0 .. 100 Nm"),
    ("not a number", lambda: edited("csj_Nm = 0.138", "csj_Nm = nan"), "a.toml: screw.csj_Nm = nan: outside 0 .. 100 Nm"),
    (
        "unknown choice",
        lambda: edited('side = "motor"', 'side = "rot"'),
        "a.toml: encoder.side = rot: not a choice (did you mean rod?): use one of motor, rod",
    ),
    ("half of a count", lambda: edited("every_steps = 1 ", "every_steps = 1.5 "), "a.toml: control.every_steps = 1.5: not a whole number"),
    (
        "unknown effect",
        lambda: edited("[control]", "[effects.stribek_friction]\nrise = 0.1\n[control]"),
        "a.toml: effects.stribek_friction: unknown effect (did you mean stribeck_friction?)",
    ),
    (
        "unknown parameter of an effect",
        lambda: edited("[control]", "[effects.stribeck_friction]\nriser = 0.1\n[control]"),
        "a.toml: effects.stribeck_friction.riser: unknown key (did you mean rise?)",
    ),
    (
        "a value of the machine missing",
        lambda: edited("inductance_H = 0.0008", "# inductance_H = 0.0008"),
        "a.toml: motor.inductance_H is missing: add it, in the reference actuator it is inductance_H = 0.0008",
    ),
    (
        "a whole table missing",
        lambda: edited("[gearbox]", "[actuator.gearbox]").split("[actuator.gearbox]")[0],
        "a.toml: gearbox.ratio is missing (and",
    ),
    ("a table that is a number", lambda: "motor = 3\n", "a.toml: motor: not a table"),
    ("an effect that is a number", lambda: "effects = 3\n", "a.toml: effects: not a table"),
    (
        "unknown key about the actuator",
        lambda: edited("[actuator]", "[actuator]\nnmae = 'x'"),
        "a.toml: actuator.nmae: unknown key (did you mean name?)",
    ),
    (
        "a number for a name",
        lambda: edited('name = "reference actuator"', "name = 3"),
        "a.toml: actuator.name = 3: not a text: put it in quotes",
    ),
    ("broken TOML", lambda: edited("[motor]", "[motor"), "a.toml: not TOML: "),
    (
        "the same key twice",
        lambda: edited("[motor]\n", "[motor]\ninductance_H = 1e-3\n"),
        'a.toml: not TOML: key "inductance_H" already exists at line ',
    ),
]


@pytest.mark.parametrize(("text", "message"), [case[1:] for case in BAD], ids=[case[0] for case in BAD])
def test_bad_file_is_named_in_one_line(tmp_path: Path, text: object, message: str) -> None:
    with pytest.raises(InputError) as raised:
        read_text(text(), tmp_path)  # type: ignore[operator]
    assert str(raised.value).startswith(message)
    assert "\n" not in str(raised.value)


def test_absent_and_binary_files(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file or directory: check the path"):
        read_actuator(tmp_path / "none.toml")
    (tmp_path / "b.toml").write_bytes(b"[motor]\n\xff\n")
    with pytest.raises(InputError, match="byte 8 is not UTF-8"):
        read_actuator(tmp_path / "b.toml")


def test_settings_may_be_left_out(tmp_path: Path) -> None:
    text = REFERENCE.read_text(encoding="utf-8").split("[search]")[0]
    assert read_text(text, tmp_path).values == reference_actuator().values


def test_existing_file_is_not_overwritten(tmp_path: Path) -> None:
    path = tmp_path / "a.toml"
    path.write_text("mine", encoding="utf-8")
    with pytest.raises(InputError, match="exists already: choose another name or give --force"):
        reference_actuator().write(path)
    assert path.read_text(encoding="utf-8") == "mine"
    reference_actuator().write(path, force=True)
    assert tomlkit.parse(path.read_text(encoding="utf-8"))["screw"]["csj_Nm"] == 0.138  # type: ignore[index]


def test_names_of_effects_with_and_without_their_table() -> None:
    assert row_of("effects.stribeck_friction.rise") is row_of("stribeck_friction.rise")
    assert shown(row_of("stribeck_friction.rise")) == "effects.stribeck_friction.rise"
    with pytest.raises(
        InputError, match=r"effects.stribeck_friction.rice: unknown value \(did you mean effects.stribeck_friction.rise\?\)"
    ):
        row_of("effects.stribeck_friction.rice")


def test_a_name_that_is_not_finished_is_the_one_that_begins_so() -> None:
    names = ["drag_Nm_s_per_rad", "speed_rad_s", "drab"]
    assert nearest("drag", iter(names)) == " (did you mean drag_Nm_s_per_rad?)"
    assert nearest("sped_rad_s", names) == " (did you mean speed_rad_s?)" and nearest("", names) == ""
