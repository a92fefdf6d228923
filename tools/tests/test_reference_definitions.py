"""The two lists are read as they stand, and a broken row is named."""

from pathlib import Path

import pytest

from ema_tools.library.definitions import DefinitionError, defaults, definition_folder, load_definitions, read_definitions, unit_of

PARAM = 'EMA_PARAM(motor, resistance_ohm, 0.99, 1.0e-4, 1000.0, "winding, with a comma")\n'
EFFECT = 'EMA_EFFECT(drag, TORQUE, 0, 1, "eq", "src", "a, b", EMA_P(c_Nm, 0.0, 0.0, 1.0, "x") EMA_P(n, 2.0, 1.0, 3.0, "y"))\n'


def write(folder: Path, params: str = PARAM, effects: str = EFFECT) -> Path:
    """Both lists in `folder`."""
    (folder / "ema_params.def").write_text(params)
    (folder / "ema_effects.def").write_text(effects)
    return folder


def test_shipped_lists() -> None:
    known = load_definitions()
    assert len(known.ids) == len(known.reals) + len(known.effect_values) + len(known.options)
    assert [*known.ids.values()] == list(range(len(known.ids)))
    assert known.find("screw.csj_Nm").nominal == 0.138
    assert known.find("control.structure").choices == ("pid", "cascade")  # type: ignore[union-attr]
    assert known.effect("stribeck_friction").size.name == "stribeck_friction.rise"
    assert defaults()["motor.resistance_ohm"] == 0.99
    for row in (*known.parameters, *known.effect_values):
        assert row.lower <= row.nominal <= row.upper, row.name


def test_every_row_of_the_files_is_read() -> None:
    text = (definition_folder() / "ema_params.def").read_text()
    rows = [line for line in text.splitlines() if line.startswith(("EMA_PARAM(", "EMA_OPTION("))]
    assert len(load_definitions().parameters) == len(rows)
    text = (definition_folder() / "ema_effects.def").read_text()
    assert len(load_definitions().effects) == sum(line.startswith("EMA_EFFECT(") for line in text.splitlines())


def test_small_lists(tmp_path: Path) -> None:
    known = read_definitions(write(tmp_path, "/* a, (b */\n" + PARAM))
    assert known.reals[0].text == "winding, with a comma"
    effect = known.effects[0]
    assert (effect.site, effect.memory, effect.look_alikes) == ("TORQUE", 0, ("a", "b"))
    assert [value.name for value in effect.parameters] == ["drag.c_Nm", "drag.n"]


@pytest.mark.parametrize(
    ("params", "part"),
    [
        ('EMA_PARAM(motor, r_ohm, 0.99, 1.0e-4, "no upper")\n', "row 1: EMA_PARAM needs 6"),
        ('\n\nEMA_PARAM(motor, r_ohm, low, 1.0, 2.0, "x")\n', "row 3: EMA_PARAM needs 6"),
        ("EMA_THING(motor, r_ohm)\n", "EMA_THING"),
        ('EMA_PARAM(motor, r_ohm, 1.0, 0.0, 2.0, "x"\n', "')' expected"),
        ("EMA_PARAM(motor, r_ohm, 1.0, , 2.0)\n", "argument is missing"),
        ("EMA_PARAM(motor, $)\n", "cannot read"),
        (PARAM + PARAM, "motor.resistance_ohm: stands twice"),
    ],
)
def test_broken_rows_are_named(tmp_path: Path, params: str, part: str) -> None:
    with pytest.raises(DefinitionError) as error:
        read_definitions(write(tmp_path, params))
    assert part in str(error.value)
    assert "\n" not in str(error.value)


def test_missing_lists(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("EMA_DEFINITIONS", str(tmp_path))
    with pytest.raises(DefinitionError, match="EMA_DEFINITIONS"):
        definition_folder()


def test_unknown_names_suggest_known_ones() -> None:
    with pytest.raises(KeyError, match=r"motor\.resistance_ohm"):
        load_definitions().find("motor.resistance")
    with pytest.raises(KeyError, match="screw"):
        load_definitions().find("nothing.at_all")
    with pytest.raises(KeyError, match="spring_load"):
        load_definitions().effect("spring")


def test_units_come_from_the_suffix() -> None:
    assert unit_of("viscous_Nm_s_per_rad") == "Nm s/rad"
    assert unit_of("drag_Nm_s2_per_rad2") == "Nm s2/rad2"
    assert unit_of("ki_per_m_s") == "1/(m s)"
    assert unit_of("efficiency") == ""
