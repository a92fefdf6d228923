"""In sentences an effect stands by its display name, its code name behind it in brackets; what programs read keeps the code name."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from demo_run import demo_run
from ema_tools.library.definitions import load_definitions
from ema_tools.library.display_names import all_coded, coded, display, value_coded, within
from support import RECORDINGS, REFERENCE, run_ema

_STORY = RECORDINGS / "story"
# A command is to be typed: code names stand in it bare.
_COMMAND = re.compile(r"ema add \S+ \w+|--between( \w+)+|docs/\w+\.md|\S+\.csv")
# A name or a value in brackets behind what it is called.
_BRACKETS = re.compile(r"(?<=\w \()[\w.]+(?=[;)])")


def bare(text: str) -> list[str]:
    """Code names of effects and faults that stand in a sentence without their display names."""
    codes = {effect.name for effect in load_definitions().effects if "_" in effect.name} | {"csj", "blk"}
    return [word for word in re.findall(r"\w+", _BRACKETS.sub("", _COMMAND.sub("", text))) if word in codes]


def sentences(data: Any, path: str = "") -> Iterator[tuple[str, str]]:
    """What is read as a sentence in a result, with its path."""
    if isinstance(data, dict):
        for key, one in data.items():
            # what came last is a name for programs
            if key not in ("provenance", "curves", "workbench", "added"):
                yield from sentences(one, f"{path}.{key}")
    elif isinstance(data, list):
        for one in data:
            yield from sentences(one, path)
    elif isinstance(data, str) and data.count(" ") > 2:
        yield path, data


def bare_in(path: Path) -> list[tuple[str, str]]:
    """Sentences of a result's file that name something by its code name alone."""
    return [(at, text) for at, text in sentences(json.loads(path.read_text(encoding="utf-8"))) if bare(text)]


def test_names() -> None:
    assert display("stribeck_friction") == "Stribeck friction" and within("cogging_torque") == "cogging torque"
    assert coded("stribeck_friction") == "Stribeck friction (stribeck_friction)"
    assert coded("cogging_torque", "size 0.3") == "cogging torque (cogging_torque; size 0.3)"
    assert coded("cogging_torque", first=True) == "Cogging torque (cogging_torque)"
    # a name of one word is its own code name
    assert coded("presliding") == "presliding" and coded("presliding", "size 2") == "presliding (size 2)"
    assert coded("csj") == "friction (CSJ)" and all_coded(("blk", "spring_load"), " and ") == "backlash (BLK) and spring load (spring_load)"
    assert value_coded("motor.resistance_ohm") == "winding resistance (motor.resistance_ohm)"
    assert value_coded("control.kp_per_m") == "proportional gain (control.kp_per_m)"
    assert value_coded("screw.friction_asymmetry") == "friction asymmetry (screw.friction_asymmetry)"
    assert value_coded("encoder.rod_offset_mm") == "rod offset (encoder.rod_offset_mm)"
    assert value_coded("spring_load.stiffness_Nm_per_mm") == "stiffness of spring load (spring_load.stiffness_Nm_per_mm)"
    assert value_coded("effects.stribeck_friction.shape") == "shape of Stribeck friction (effects.stribeck_friction.shape)"
    assert bare("missing is stribeck_friction") and not bare("missing is Stribeck friction (stribeck_friction; rise 0.3)")
    assert bare("cannot be told from csj") and not bare("Next: ema add a.toml stribeck_friction --fit b.csv puts it in")


@pytest.mark.slow
@pytest.mark.parametrize("name", ["compare", "identify_before", "diagnose", "add", "calibrate"])
def test_no_sentence_of_the_demo_has_a_code_name_alone(name: str) -> None:
    found = next(iter(sorted(demo_run()[0].glob(f"{name}*.json"))), None)
    if found is None:
        pytest.skip(f"the demo keeps no {name}.json")
    assert bare_in(found) == []


@pytest.mark.slow
def test_nor_of_a_balance_whose_effects_are_refused(tmp_path: Path) -> None:
    asked = ("--method", "balance", "--json", tmp_path / "balance.json")
    assert run_ema("diagnose", REFERENCE, _STORY / "today.csv", *asked).code == 0
    data = json.loads((tmp_path / "balance.json").read_text(encoding="utf-8"))
    assert [one for one in data["effects"] if one.get("reason")] and bare_in(tmp_path / "balance.json") == []
    # what programs read is as it was
    assert {one["name"] for one in data["effects"]} <= {effect.name for effect in load_definitions().effects} | {"position_friction"}
