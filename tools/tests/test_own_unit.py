"""The unit with standing errors of recordings/unit: its records, its own model as shipped, and what the flight code answers by it, alone and behind its table of signatures."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from benchmarks.truth import recordings
from ema_tools.base.compiled import HAS_NUMBA
from ema_tools.data import own_unit
from ema_tools.data.actuator import read_actuator, reference_actuator
from ema_tools.data.records import Record, read_record
from ema_tools.library.definitions import load_definitions
from ema_tools.plant.native import Identification, SearchSettings, Table
from ema_tools.plant.signatures_header import read_signatures
from ema_tools.tasks.calibrate import calibrate
from ema_tools.tasks.onboard_search import run
from ema_tools.tasks.own_machine import own_machine
from reference_model.vectors import session
from support import EXPORTED, ROOT

UNIT = ROOT / "recordings" / "unit"
TABLE = EXPORTED / "ace_unit_signatures.h"
VECTORS = ROOT / "tests" / "vectors"
needs_numba = pytest.mark.skipif(not HAS_NUMBA, reason="the truth plant takes minutes a record without Numba")


def healthy() -> list[Record]:
    return [read_record(UNIT / f"{own_unit.healthy_day(number).name}.csv") for number in range(1, own_unit.HEALTHY_RUNS + 1)]


def flown(name: str, table: Table | None = None) -> Identification:
    """The flight code's answer on a day, its record in int16."""
    return run(read_actuator(UNIT / "unit.toml"), read_record(UNIT / f"{name}.csv"), SearchSettings(int16_record=True), 32, table=table)


@pytest.mark.slow
@needs_numba
def test_recordings_are_reproduced_and_tell_nothing(tmp_path: Path) -> None:
    for path in recordings.write_unit(tmp_path):
        assert path.read_bytes() == (UNIT / path.name).read_bytes(), f"{path.name}: run python -m benchmarks.truth.recordings recordings"
        head = "".join(line for line in path.read_text(encoding="utf-8").splitlines() if line.startswith("#"))
        assert own_unit.EFFECT not in head and "CSJ" not in head and "worn" not in head
    assert {path.name for path in UNIT.iterdir()} == {"unit.toml", *(path.name for path in tmp_path.iterdir())}


@pytest.mark.slow
def test_the_shipped_model_is_what_calibrate_makes() -> None:
    known = read_actuator(UNIT / "unit.toml")
    found = own_machine(calibrate(reference_actuator(), healthy()).actuator, healthy())
    assert found is not None
    say = "run build/ema calibrate actuators/reference.toml recordings/unit/healthy_?.csv -o recordings/unit/unit.toml --force, then the target `written`"
    assert found.actuator.active_effects == known.active_effects, say
    for row in load_definitions().rows:
        # two machines' linear algebra; what the runs hardly determine may differ more
        assert found.actuator[row.name] == pytest.approx(known[row.name], rel=2e-2, abs=1e-3), f"{row.name}: {say}"


def test_healthy_fault_with_its_size_and_undecided() -> None:
    sound, worn, hidden = (flown(day.name) for day in own_unit.LATER)
    assert [one.verdict for one in (sound, worn, hidden)] == ["healthy", "fault", "undecided"]
    shift = {one.name: one.shift_percent for one in worn.identified}
    assert shift["screw.csj_Nm"] == pytest.approx(own_unit.CSJ_SHIFT_PERCENT, abs=3.0)
    assert shift["screw.blk_mm"] == pytest.approx(own_unit.BLK_SHIFT_PERCENT, abs=3.0)
    # the day is found with it: warmer grease is thinner, a warmer winding resists more
    day = {one.name: one.shift_percent for one in sound.day}
    assert day["screw.viscous_Nm_s_per_rad"] < -5.0 and 0.5 < day["motor.resistance_ohm"] < 2.0


@pytest.mark.release
def test_behind_the_table_the_answer_is_the_same_and_names_what_is_missing() -> None:
    """Grease and winding of the day are searched behind a table of signatures as well."""
    table = read_signatures(TABLE)
    for day in own_unit.LATER:
        alone, behind = flown(day.name), flown(day.name, table)
        assert behind.verdict == alone.verdict and len(behind.day) == 2
        for one, other in zip((*alone.identified, *alone.day), (*behind.identified, *behind.day), strict=True):
            assert abs(one.estimate - other.estimate) < 0.5 * one.std, (day.name, one, other)
        assert behind.finding is not None
        if day is own_unit.HIDDEN:
            assert (behind.finding.kind, behind.finding.effect) == ("missing", own_unit.EFFECT)
            assert behind.finding.size == pytest.approx(own_unit.EFFECT_VALUES["inverter_dead_time.drop_V"], rel=0.06)
        else:
            assert behind.finding.kind == "adequate"


@pytest.mark.parametrize("search", session.FILES)
def test_the_stored_answer_is_that_of_the_desk(search: str) -> None:
    stored = json.loads((VECTORS / session.FILES[search]).read_text(encoding="utf-8"))
    assert stored["answer"] == session.answer(search)
    assert [len(stored["answer"][name]) for name in ("estimate", "std", "shift_percent")] == [4, 4, 4]
