"""`[scatter]` of an actuator's file: how it is read and written, what it replaces, and what follows from it."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ema_tools.base.errors import InputError
from ema_tools.data.actuator import Actuator, read_actuator, reference_actuator, scattering_rows
from ema_tools.data.records import Record
from ema_tools.design.detection import sight_of
from ema_tools.fit.detection import ShiftTest
from ema_tools.fit.interval import scatter_of
from ema_tools.fit.nuisance import (
    DAY,
    FROM_RUN_TO_RUN,
    Spread,
    from_day_to_day,
    from_run_to_run,
    of_today,
    of_unit,
    share_from_run_to_run,
    stated_std,
    widths_shown,
)
from ema_tools.library.definitions import load_definitions
from ema_tools.select.baseline import against_known, gather
from ema_tools.select.known_machine import KnownMachine, live
from ema_tools.select.search import diagnose
from ema_tools.tasks.healthy_runs import scatter_shown
from ema_tools.tasks.identify import Identified, identify
from ema_tools.tasks.signature_table import signatures
from ema_tools.words.sentences.few_records import few_records
from ema_tools.words.sentences.identification import sentence
from repeated_runs import measured, repeats
from support import RECORDINGS, REFERENCE, chirp_record, complaint, run_ema

NAMES = ("screw.csj_Nm", "screw.blk_mm")
NOISE = {"position_mm": 0.005, "motor_position_mm": 0.005, "current_A": 0.03}
SHORT = "chirp:amplitude_mm=8,start_hz=0.1,end_hz=1.5,duration_s=2"
TABLE = """[scatter]
# six runs in May
screw.csj_Nm = 0.006   # dry
motor.resistance_ohm = 0
screw.load_torque_Nm = 0.02

"""


def stating(**scatter: float) -> Actuator:
    """The reference actuator with a scatter of some values, by `section__field`."""
    return replace(reference_actuator(), scatter={name.replace("__", "."): std for name, std in scatter.items()})


def read_text(text: str, folder: Path, complete: bool = True) -> Actuator:
    (folder / "a.toml").write_text(text, encoding="utf-8")
    return read_actuator(folder / "a.toml", complete)


def with_table(table: str) -> str:
    """The shipped file with a table before the last one."""
    return REFERENCE.read_text(encoding="utf-8").replace("[verdict]", f"{table}[verdict]", 1)


def test_what_is_stated_is_read_by_full_names(tmp_path: Path) -> None:
    found = read_text(with_table(TABLE), tmp_path)
    assert found.scatter == {"screw.csj_Nm": 0.006, "motor.resistance_ohm": 0.0, "screw.load_torque_Nm": 0.02}
    assert found.values == reference_actuator().values
    assert read_actuator(REFERENCE).scatter == {}
    in_tables = with_table("[scatter.screw]\ncsj_Nm = 0.006\nload_torque_Nm = 0.02\n[scatter.motor]\nresistance_ohm = 0\n\n")
    assert read_text(in_tables, tmp_path).scatter == found.scatter


def test_a_machine_without_its_controller_may_state_it(tmp_path: Path) -> None:
    text = with_table(TABLE)
    without = text[: text.index("[control]")] + text[text.index("[motor]") :]
    assert read_text(without, tmp_path, complete=False).scatter["screw.csj_Nm"] == 0.006


def test_the_users_table_stays_as_it_is_where_the_file_is_written(tmp_path: Path) -> None:
    text = with_table(TABLE)
    found = read_text(text, tmp_path)
    assert found.written_text() == text
    changed = found.changed({"screw.csj_Nm": 0.2, "stribeck_friction.rise": 0.3})
    assert TABLE in changed.written_text()
    assert read_text(changed.written_text(), tmp_path).scatter == found.scatter


def test_every_value_that_may_scatter_is_written_and_read(tmp_path: Path) -> None:
    every = {name: min(0.5, row.upper) for name, row in scattering_rows().items()}
    for begun in (reference_actuator(), read_text(with_table(TABLE), tmp_path)):
        written = replace(begun, scatter=every).written_text()
        assert read_text(written, tmp_path).scatter == every
    assert "screw.csj_Nm = 0.5   # dry\n" in written and "# six runs in May" in written
    assert re.search(r"^encoder.rod_offset_mm = 0.5 +# from run to run, one standard deviation, in mm$", written, re.MULTILINE)


@pytest.mark.parametrize(
    "arguments",
    [("add", "FILE", "stribeck_friction", "--set", "rise=0.2"), ("calibrate", "FILE", RECORDINGS / "healthy.csv", "--fit", "screw.csj_Nm")],
    ids=lambda arguments: arguments[0],
)
def test_commands_keep_the_table(tmp_path: Path, arguments: tuple[str | Path, ...]) -> None:
    mine = tmp_path / "mine.toml"
    mine.write_text(with_table(TABLE), encoding="utf-8")
    ran = run_ema(*(mine if one == "FILE" else one for one in arguments), "-o", tmp_path / "new.toml")
    assert ran.code == 0, ran.err
    assert TABLE in (tmp_path / "new.toml").read_text(encoding="utf-8")


BAD = [
    ("scatter = 3\n", "scatter: not a table: write [scatter] with rows such as screw.csj_Nm = 0.006 below"),
    ("[scatter]\ncsj_Nm = 0.1\n", "scatter.csj_Nm: unknown value (did you mean screw.csj_Nm?): rows are named section.field, of control, "),
    ("[scatter]\nscrew.cjs_Nm = 0.1\n", "scatter.screw.cjs_Nm: unknown value (did you mean screw.csj_Nm?)"),
    ("[scatter]\nscrew = 0.1\n", "scatter.screw: unknown value (did you mean screw."),
    ('[scatter]\n"screw.csj_Nm" = 0.1\n', 'scatter."screw.csj_Nm": a name in quotes: write screw.csj_Nm = ... without quotes'),
    (
        "[scatter]\nscrew.csj_Nm = nan\n",
        "scatter.screw.csj_Nm = nan: outside 0 .. 1: give one standard deviation from run to run, as a share of the value",
    ),
    ("[scatter]\nscrew.csj_Nm = inf\n", "scatter.screw.csj_Nm = inf: outside 0 .. 1: "),
    ("[scatter]\nscrew.csj_Nm = -0.1\n", "scatter.screw.csj_Nm = -0.1: outside 0 .. 1: "),
    ("[scatter]\nscrew.csj_Nm = 2\n", "scatter.screw.csj_Nm = 2: outside 0 .. 1: "),
    (f"[scatter]\nscrew.csj_Nm = 1{'0' * 400}\n", "scatter.screw.csj_Nm: outside 0 .. 1: "),
    ('[scatter]\nscrew.csj_Nm = "1 %"\n', 'scatter.screw.csj_Nm = "1 %": not a number: give one standard deviation from run to run, as a '),
    ("[scatter]\nscrew.csj_Nm = true\n", "scatter.screw.csj_Nm = True: not a number: "),
    ("[scatter]\nscrew.csj_Nm = [0.1]\n", "scatter.screw.csj_Nm = [0.1]: not a number: "),
    (
        "[scatter]\nscrew.load_torque_Nm = 101\n",
        "scatter.screw.load_torque_Nm = 101: outside 0 .. 100: give one standard deviation from run to run, in Nm",
    ),
    ("[scatter]\nencoder.side = 0.1\n", "scatter.encoder.side: no value that scatters: leave it out, [scatter] holds numbers of control, "),
    ("[scatter]\nverdict.confidence_std = 0.1\n", "scatter.verdict.confidence_std: no value that scatters: "),
    ("[scatter]\neffects.stribeck_friction.rise = 0.1\n", "scatter.effects.stribeck_friction: no value that scatters: "),
    ("[scater]\nscrew.csj_Nm = 0.1\n", "[scater]: unknown table (did you mean scatter?)"),
]


@pytest.mark.parametrize(("table", "message"), BAD, ids=[message[:48] for _, message in BAD])
def test_bad_rows_are_named_in_one_line(tmp_path: Path, table: str, message: str) -> None:
    text = f"{table}{REFERENCE.read_text(encoding='utf-8')}" if table.startswith("scatter") else with_table(table)
    with pytest.raises(InputError) as raised:
        read_text(text, tmp_path)
    assert str(raised.value).startswith(f"a.toml: {message}")
    assert "\n" not in str(raised.value)


def test_commands_complain_as_reading_does(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text(with_table("[scatter]\nscrew.csj_Nm = -1\n"), encoding="utf-8")
    ran = run_ema("next", tmp_path / "mine.toml", "--detect")
    assert "mine.toml: scatter.screw.csj_Nm = -1: outside 0 .. 1" in complaint(ran)


def test_what_is_stated_takes_the_place_of_the_usual() -> None:
    usual = from_run_to_run(reference_actuator())
    assert usual == tuple(Spread((name,), std, True) for name, std in FROM_RUN_TO_RUN.items())
    as_usual = replace(reference_actuator(), scatter=dict(FROM_RUN_TO_RUN))
    assert from_run_to_run(as_usual) == usual
    assert (of_unit(as_usual), of_today(as_usual)) == (of_unit(reference_actuator()), of_today(reference_actuator()))
    found = from_run_to_run(stating(screw__csj_Nm=0.02, motor__resistance_ohm=0.0, screw__load_torque_Nm=0.01))
    assert found == (
        Spread(("screw.csj_Nm",), 0.02, True),
        Spread(("screw.viscous_Nm_s_per_rad",), FROM_RUN_TO_RUN["screw.viscous_Nm_s_per_rad"], True),
        Spread(("screw.load_torque_Nm",), 0.01, False),
    )


def test_what_nobody_searches_for_has_neither_faults_nor_shares_of_zero() -> None:
    assert tuple(one.title for one in from_day_to_day(reference_actuator())) == DAY
    stated = stating(screw__blk_mm=0.1, screw__viscous_Nm_s_per_rad=0.0, drive__supply_V=0.01).changed({"motor.resistance_ohm": 0.5})
    assert tuple(one.title for one in from_day_to_day(stated)) == ("motor.resistance_ohm", "drive.supply_V")
    assert from_day_to_day(stating(motor__inductance_H=0.1).changed({"motor.inductance_H": 0.0})) == from_day_to_day(reference_actuator())


def test_stated_widths_stay_where_healthy_runs_teach_the_others() -> None:
    shares = np.array([[3.0, -3.0, 3.0, -3.0]] * 3)
    usual = from_run_to_run(stating(screw__csj_Nm=0.02))
    widths = widths_shown(stating(screw__csj_Nm=0.02), usual, shares)
    assert widths[0] == 1.0
    assert np.all(widths[1:] == np.sqrt((4.0 + 36.0) / (4.0 + 3.0)))


def test_a_day_and_a_unit_differ_by_no_less_than_two_runs() -> None:
    wide = stating(motor__resistance_ohm=0.5, drive__supply_V=0.001, gearbox__efficiency=0.04, screw__friction_asymmetry=0.1)
    for found, plain in ((of_today(wide), of_today(reference_actuator())), (of_unit(wide), of_unit(reference_actuator()))):
        std, before = ({one.title: one.std for one in spread} for spread in (found, plain))
        assert std["motor.resistance_ohm"] == 0.5 > before["motor.resistance_ohm"]
        assert std["drive.supply_V"] == before["drive.supply_V"] > 0.001
        assert std["gearbox.efficiency"] == 0.04 and std["screw.friction_asymmetry"] == 0.1
    assert "screw.blk_mm" not in {one.title for one in of_today(stating(screw__blk_mm=0.1))}


def test_shares_are_of_the_value_and_units_are_not() -> None:
    stated = stating(screw__csj_Nm=0.02, screw__load_torque_Nm=0.03).changed({"screw.load_torque_Nm": 5.0})
    assert share_from_run_to_run(stated, "screw.csj_Nm") == 0.02 and share_from_run_to_run(stated, "screw.blk_mm") == 0.0
    assert stated_std(stated, "screw.csj_Nm") == pytest.approx(0.02 * 0.138)
    assert stated_std(stated, "screw.load_torque_Nm") == 0.03
    assert stated_std(stated, "motor.resistance_ohm") is None


def test_few_records_are_said_to_tell_little() -> None:
    assert few_records(2, reference_actuator()).startswith(" How much runs differ is uncertain with 2 healthy records: give 3 or more")
    assert "1 healthy record:" in few_records(1, stating(screw__csj_Nm=0.01))
    assert few_records(0, reference_actuator()) == few_records(3, reference_actuator()) == ""
    assert few_records(2, replace(reference_actuator(), scatter=dict(FROM_RUN_TO_RUN))) == ""


def moved_by(actuator: Actuator, record: Record) -> dict[str, float]:
    return scatter_of(actuator, record, NAMES, {"position_mm": 1.0})


def test_estimates_move_with_what_is_stated() -> None:
    record = chirp_record(text=SHORT)
    usual = moved_by(reference_actuator(), record)
    assert moved_by(replace(reference_actuator(), scatter=dict(FROM_RUN_TO_RUN)), record) == usual
    none = moved_by(replace(reference_actuator(), scatter=dict.fromkeys(FROM_RUN_TO_RUN, 0.0)), record)
    assert none == dict.fromkeys(NAMES, 0.0)
    wide = moved_by(stating(screw__csj_Nm=0.05), record)
    assert wide["screw.csj_Nm"] > 0.049 * 0.138 > 5.0 * usual["screw.csj_Nm"]
    # a value that is zero on the data sheet, in its unit: the estimates follow it in proportion
    small, large = (moved_by(replace(stating(screw__load_torque_Nm=std)), record) for std in (0.01, 0.02))
    more = [one["screw.csj_Nm"] ** 2 - usual["screw.csj_Nm"] ** 2 for one in (small, large)]
    assert more[0] > 0.0 and more[1] == pytest.approx(4.0 * more[0], rel=0.05)


def test_the_ground_test_sees_less_of_a_unit_that_scatters_more() -> None:
    def seen(actuator: Actuator) -> tuple[float, float]:
        sight = sight_of(actuator, ShiftTest(runs=3), SHORT)
        return sight.onboard["csj"].alone, sight.signals["csj"].alone

    usual = seen(reference_actuator())
    assert seen(replace(reference_actuator(), scatter=dict(FROM_RUN_TO_RUN))) == usual
    assert all(wide > 2.0 * one for wide, one in zip(seen(stating(screw__csj_Nm=0.05)), usual, strict=True))
    day = reference_actuator().changed({"search.day_values": 1.0})
    assert seen(replace(day, scatter={"drive.supply_V": 0.1}))[0] > seen(day)[0]


def known(scatter: Mapping[str, float]) -> KnownMachine:
    """A day's record beside healthy runs of an actuator that states a scatter."""
    runs = repeats()[:3]
    actuator = replace(reference_actuator(), scatter=dict(scatter))
    return KnownMachine(against_known(actuator, measured({}, 20), runs, live(*runs)))


def test_a_known_machine_moves_with_what_is_stated_and_no_farther() -> None:
    found = known(
        {"screw.viscous_Nm_s_per_rad": 0.02, "motor.resistance_ohm": 0.0, "encoder.rod_offset_mm": 0.01, "gearbox.efficiency": 0.02}
    )
    widened = np.sqrt(1.0 + 1.0 / 3.0)
    assert {name: one.std for name, one in found.scatter.items()} == pytest.approx(
        {"screw.viscous_Nm_s_per_rad": 0.02 * widened, "encoder.rod_offset_mm": 0.01 * widened, "gearbox.efficiency": 0.02 * widened}
    )
    base = found.base({})
    assert base.values["screw.csj_Nm"] == pytest.approx(0.138, rel=0.02)
    assert abs(base.values["encoder.rod_offset_mm"]) < 0.01 and base.values["gearbox.efficiency"] <= 1.0
    assert not found.at_reach(base)


def test_a_unit_that_does_not_scatter_at_all_is_compared_too() -> None:
    found = known(dict.fromkeys(FROM_RUN_TO_RUN, 0.0))
    assert found.evidence.spread == () and found.scatter == {}
    assert found.base({}).values["screw.csj_Nm"] == pytest.approx(0.138, rel=0.02)


@pytest.mark.slow
def test_signatures_take_what_is_stated() -> None:
    for scatter in ({"drive.supply_V": 0.01}, dict.fromkeys(FROM_RUN_TO_RUN, 0.0)):
        for day in (0.0, 1.0):
            actuator = replace(reference_actuator().changed({"search.day_values": day}), scatter=scatter)
            assert len(signatures(actuator, repeats()[:3]).patterns) > 10


def found_on(actuator: Actuator, healthy: tuple[Record, ...] = ()) -> Identified:
    worn = reference_actuator().changed({"screw.csj_Nm": 1.1 * 0.138})
    return identify(actuator, chirp_record(worn).with_noise(NOISE, 3), healthy)


@pytest.mark.slow
def test_a_small_change_is_none_of_a_unit_that_scatters_as_much() -> None:
    usual, as_usual, wide = map(
        found_on, (reference_actuator(), replace(reference_actuator(), scatter=dict(FROM_RUN_TO_RUN)), stating(screw__csj_Nm=0.05))
    )
    assert usual.verdict == as_usual.verdict == "fault"
    assert wide.verdict == "undecided" and wide.answer.verdict == "fault"
    assert "as [scatter] of its file states" in sentence(wide)
    for one, same, less in zip(usual.answer.identified, as_usual.answer.identified, wide.answer.identified, strict=True):
        assert (one.estimate, usual.interval95(one)) == (same.estimate, as_usual.interval95(same))
        assert one.estimate == less.estimate
    ends = [found.interval95(found.answer.identified[0]) for found in (usual, wide)]
    assert all(low is not None and high is not None for low, high in ends)
    assert ends[1][1] - ends[1][0] > 5.0 * (ends[0][1] - ends[0][0])  # type: ignore[operator]


def diagnosed(actuator: Actuator) -> set[str]:
    """What a diagnosis beside three healthy runs names on a record of 8 % more dry friction: three runs tell 6 % from what they and a day's temperature make of it, by Student's limit."""
    evidence = gather(actuator, measured({"screw.csj_Nm": 1.08 * 0.138}, 77), repeats()[:3])
    return {one.name for one in diagnose(evidence).named if one.accepted}


@pytest.mark.slow
def test_a_diagnosis_names_no_change_that_the_unit_makes_from_run_to_run() -> None:
    assert diagnosed(reference_actuator()) == {"csj"}
    assert diagnosed(stating(screw__csj_Nm=0.05)) == set()


@pytest.mark.slow
def test_what_is_stated_outweighs_what_healthy_records_show() -> None:
    healthy = repeats()[:2]
    shown, stated = found_on(reference_actuator(), healthy), found_on(stating(screw__csj_Nm=0.05), healthy)
    assert shown.verdict == "fault" and stated.verdict != "fault"
    assert stated.healthy_std("screw.csj_Nm") == pytest.approx(0.05 * 0.138 * np.sqrt(1.5), rel=0.1)
    assert "uncertain with 2 healthy records" in sentence(shown)


def test_every_name_that_may_scatter_is_a_real_value_of_the_machine() -> None:
    known = load_definitions().by_name
    assert all(known[name] is row and not row.is_option for name, row in scattering_rows().items())
    assert {row.section for row in scattering_rows().values()} == {"control", "drive", "motor", "gearbox", "screw", "encoder"}


def test_one_run_says_nothing_of_the_scatter() -> None:
    """Its distance from its own mean is zero whatever it read: the usual scatter stays."""
    assert scatter_shown([0.0], 0.03) == pytest.approx(0.03)
    assert scatter_shown([0.0, 0.0], 0.03, 2) == pytest.approx(0.03)
