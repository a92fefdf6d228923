"""The lists as the library gives them to Python: every row, in the order of the files."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from ema_tools.base.errors import LibraryError
from ema_tools.library.definitions import defaults, library_path, load_definitions, open_library, read_definitions, unit_of
from support import ROOT

LISTS = ROOT / "include" / "ema"


def test_shipped_lists() -> None:
    known = load_definitions()
    assert len(known.ids) == len(known.reals) + len(known.effect_values) + len(known.options)
    assert [*known.ids.values()] == list(range(len(known.ids)))
    assert known.find("screw.csj_Nm").nominal == 0.138
    assert known.find("control.structure").choices == ("pid", "cascade")  # type: ignore[union-attr]
    assert known.find("control.every_steps").choices == ()  # type: ignore[union-attr]
    assert known.effect("stribeck_friction").size.name == "stribeck_friction.rise"
    assert defaults()["motor.resistance_ohm"] == 0.99
    for row in (*known.parameters, *known.effect_values):
        assert row.lower <= row.nominal <= row.upper, row.name
    names = [row.name for row in known.rows] + [effect.name for effect in known.effects]
    assert len(set(names)) == len(names)


def test_every_row_of_the_files_is_there_in_their_order() -> None:
    rows = re.findall(r"^EMA_(PARAM|OPTION)\((\w+), (\w+),", (LISTS / "ema_params.def").read_text(), re.MULTILINE)
    found = [("OPTION" if row.is_option else "PARAM", row.section, row.field) for row in load_definitions().parameters]
    assert found == rows
    effects = re.findall(r"^EMA_EFFECT\(([a-z]\w*), (\w+), (\d+), (\d+)", (LISTS / "ema_effects.def").read_text(), re.MULTILINE)
    known = [
        (row.name, f"{row.site}_TABLE" if row.is_learned else row.site, str(row.memory), str(row.substeps))
        for row in load_definitions().effects
    ]
    assert known == effects


def test_texts_of_an_effect() -> None:
    effect = load_definitions().effect("quadratic_viscous")
    assert effect.equation == "- drag * w * abs(w)"
    assert effect.source.startswith("turbulent drag of a rotor")
    assert effect.look_alikes == ("viscous_rise", "load_dependent_friction")
    only = effect.parameters[0]
    assert (only.name, only.nominal, only.lower, only.upper) == ("quadratic_viscous.drag_Nm_s2_per_rad2", 0.0, -1e-3, 1e-3)
    assert only.text == "drag at the motor shaft"


def test_both_precisions_have_the_same_lists() -> None:
    own, known = read_definitions(library_path(32)), load_definitions()
    assert (own.parameters, own.effects) == (known.parameters, known.effects)


def test_library_that_is_absent_or_none(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    name = library_path(64).name
    monkeypatch.setenv("EMA_LIBRARY_DIR", str(tmp_path))
    with pytest.raises(LibraryError, match="build the project"):
        load_definitions()
    (tmp_path / name).write_bytes(b"no library")
    with pytest.raises(LibraryError, match="cannot be loaded"):
        open_library(tmp_path / name)


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
    assert unit_of("bow_per_mm") == "1/mm"
    assert unit_of("speed_mm_s") == "mm/s"


def test_every_unit_has_a_printed_text() -> None:
    lines = (ROOT / "tests" / "checks" / "unit_names.txt").read_text(encoding="utf-8").splitlines()
    units = [line.split()[1] for line in lines if line.startswith("unit ")]
    assert len(units) > 30
    silent = [unit for unit in units if not unit_of(f"x_{unit}") and unit != "ratio"]
    assert not silent, f"{silent}: write their printed text in library/definitions.py"
    # the numbers of a compound are those of its own text, not of its last part
    assert [unit_of(f"x_{unit}") for unit in ("mm_per_rad", "per_kgm2", "per_m_s")] == ["mm/rad", "1/(kg m2)", "1/(m s)"]
