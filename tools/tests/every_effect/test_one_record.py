"""What is known of an effect stands in one record: the registry refuses a gap, and no other file of the tools names an effect."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import pytest

import ema_tools
from ema_tools.library.definitions import Definitions, load_definitions
from ema_tools.library.record import GENERIC, ConfoundedParameter, EffectRecord, Onboard, Typical
from ema_tools.library.registry import described, effect_of_base_value, joined, learned_effect, record_of

TOOLS = Path(ema_tools.__file__).parent
# The equation and the record of an effect; and what doubles facts on purpose, so that the benchmark does not test the tools against themselves.
OF_EFFECTS = ("library/effects", "reference/effects", "truth", "benchmarks")
# Other files that name effects, and why.
EXCEPTIONS: Mapping[str, str] = {
    "data/own_unit.py": "what differs on the worn days of the shipped unit; the truth plant alone reads it",
    "data/story.py": "what the machine of the shipped recordings was made with; the truth plant alone reads it",
    "compare/validity.py": "presliding is the word of the field for the motion before a contact slides",
    "cli/__init__.py": "an example in the help of an option",
}


def test_no_other_file_names_an_effect() -> None:
    names = re.compile(r"\b(" + "|".join(described()) + r")\b")
    found = {}
    for path in sorted(TOOLS.rglob("*.py")):
        file = path.relative_to(TOOLS).as_posix()
        if not file.startswith(OF_EFFECTS):
            named = sorted(set(names.findall(path.read_text(encoding="utf-8"))))
            found.update({file: named} if named else {})
    assert set(found) == set(EXCEPTIONS), found


def test_every_row_has_its_record_in_the_order_of_the_list() -> None:
    definitions = load_definitions()
    assert list(joined(definitions, described())) == [effect.name for effect in definitions.effects]


def refused(changed: Mapping[str, EffectRecord | None], definitions: Definitions | None = None) -> str:
    """Why records with these changes are refused; None takes one away."""
    records = {name: record for name, record in {**described(), **changed}.items() if record is not None}
    with pytest.raises(LookupError) as error:
        joined(definitions or load_definitions(), records)
    return str(error.value)


def test_what_is_missing_or_wrong_is_refused() -> None:
    known = described()
    spot = known["jam_spot"]
    assert "library/effects/jam_spot.py is missing" in refused({"jam_spot": None})
    assert "no row of ema_effects.def" in refused({"rust": GENERIC})
    assert "depth_mm is no parameter" in refused({"jam_spot": replace(spot, onboard=Onboard({"depth_mm": (1.0,)}))})
    assert "the size, does not stand first" in refused({"jam_spot": replace(spot, typical=Typical({"place_mm": 1.0}, "wrong"))})
    assert "phase_rad is no parameter" in refused({"jam_spot": replace(spot, periodic=known["cogging_torque"].periodic)})
    assert "no row of ema_params.def" in refused({"jam_spot": replace(spot, confounded=ConfoundedParameter("screw.rust_mm", 1.0))})
    assert "whose record does not say so" in refused({"jam_spot": replace(spot, inseparable=("pitch_ripple",))})


def test_an_effect_of_ones_own_needs_no_record() -> None:
    definitions = load_definitions()
    own = replace(definitions.effects[0], name="rust", is_own=True)
    found = joined(replace(definitions, effects=(*definitions.effects, own)), described())
    assert found["rust"] is GENERIC
    assert record_of("csj") is GENERIC


def test_effects_are_found_by_what_they_are() -> None:
    assert record_of(effect_of_base_value("screw.load_torque_Nm")).base_value
    assert {learned_effect(balance) for balance in ("mechanical", "electrical", "kinematic")} == {
        name for name, record in described().items() if record.learned is not None and not record.learned.friction
    }
    assert learned_effect("mechanical", friction=True) != learned_effect("mechanical")
