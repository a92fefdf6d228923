"""The commands diagnose, add and next as a user types them: the keys that programs read, pages, what they refuse and how, and odd records and actuators."""

from __future__ import annotations

import json
import math
import re
import shlex
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ema_tools.data.actuator import read_actuator, reference_actuator
from ema_tools.data.records import Record, read_record, write_record
from ema_tools.library.definitions import load_definitions
from shared_results import shared_folder
from support import RECORDINGS, REFERENCE, chirp_record, complaint, run_ema

NOISE = {"position_mm": 0.002, "motor_position_mm": 0.002, "current_A": 0.03, "voltage_V": 0.01}
HOT = {"winding_heating.rise_degC": 60.0}
# a chirp of four seconds is enough for a hot winding, and quick
SHORT = "chirp:duration_s=4"
OTHER = "multisine:duration_s=4"
ERROR_KEYS = {"before", "after", "floor", "holdout_before", "holdout_after"}
LEARNED = {effect.name for effect in load_definitions().effects if effect.is_learned}


def run_of(seed: int, changes: Mapping[str, float] | None = None, text: str = SHORT, actuator: Path = REFERENCE) -> Record:
    """One noisy run of an actuator, without speed_mm_s."""
    run = chirp_record(read_actuator(actuator).changed(changes or {}), text).with_noise(NOISE, seed)
    return replace(run, speed_mm_s=None)


def written(path: Path, record: Record) -> Path:
    write_record(path, record)
    return path


def changed_actuator(path: Path, **values: object) -> Path:
    """The reference file with some values replaced."""
    text = REFERENCE.read_text(encoding="utf-8")
    for name, value in values.items():
        text, count = re.subn(rf"(?m)^{name}( *)= \S+", f"{name} = {json.dumps(value)}", text)
        assert count == 1, name
    path.write_text(text, encoding="utf-8")
    return path


def finite(value: Any) -> bool:
    return isinstance(value, float) and math.isfinite(value)


@shared_folder
def _runs(folder: Path) -> None:
    found = {f"healthy_{k}": run_of(10 + k) for k in range(3)}
    found |= {"hot": run_of(1, HOT), "hot_other": run_of(2, HOT, OTHER), "other": run_of(3, text=OTHER)}
    for name, record in found.items():
        write_record(folder / f"{name}.csv", record)


@pytest.fixture(scope="module")
def runs() -> dict[str, Path]:
    """Recordings by name: hot, hot under another command, healthy ones."""
    return {path.stem: path for path in _runs().glob("*.csv")}


@pytest.fixture(scope="module")
@shared_folder
def done(folder: Path) -> None:
    """A folder with the results of diagnose and add against three healthy runs, with their pages."""
    runs = {path.stem: path for path in _runs().glob("*.csv")}
    repeats = [part for k in range(3) for part in ("--healthy", runs[f"healthy_{k}"])]
    shared = (*repeats, "--holdout", runs["hot_other"])
    ran = run_ema(
        "diagnose",
        REFERENCE,
        runs["hot"],
        *shared,
        "--json",
        folder / "d.json",
        "--report",
        folder / "d.html",
        "--fitted",
        folder / "d.toml",
    )
    assert ran.code == 0, ran.err
    assert ran.out.startswith("Verdict: missing.\nhot.csv: missing is winding heating (winding_heating; rise_degC ")
    ran = run_ema(
        "add",
        REFERENCE,
        "winding_heating",
        "--fit",
        runs["hot"],
        *shared,
        "-o",
        folder / "a.toml",
        "--json",
        folder / "a.json",
        "--report",
        folder / "a.html",
    )
    assert ran.code == 0, ran.err


def result(path: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return found


def check_effects(effects: list[dict[str, Any]]) -> None:
    """The keys of every effect of a diagnosis, and names from the catalogue."""
    known = {effect.name for effect in load_definitions().effects} - LEARNED
    for one in effects:
        assert {"name", "class", "parameters", "score", "limit", "accepted"} <= set(one)
        assert one["name"] in known and set(one["class"]) <= known and one["class"][0] == one["name"]
        assert all(finite(value) for value in one["parameters"].values())
        assert set(one["std"]) <= set(one["parameters"]) and all(finite(value) for value in one["std"].values())
        assert finite(one["score"]) and finite(one["limit"]) and isinstance(one["accepted"], bool)


def test_diagnose_writes_the_keys_that_programs_read(done: Path) -> None:
    found = result(done / "d.json")
    assert found["verdict"] == "missing"
    check_effects(found["effects"])
    accepted = [one for one in found["effects"] if one["accepted"]]
    assert found["effects"][: len(accepted)] == accepted  # best first
    assert [one["name"] for one in accepted] == ["winding_heating"]
    assert accepted[0]["score"] > accepted[0]["limit"]
    assert abs(accepted[0]["parameters"]["rise_degC"] - 60.0) < 4.0 * accepted[0]["std"]["rise_degC"]
    low, high = accepted[0]["interval95"]["rise_degC"]
    assert low < accepted[0]["parameters"]["rise_degC"] < high
    assert accepted[0]["at_bound"] == []
    assert found["faults"] == {}
    assert set(found["error"]) >= ERROR_KEYS and all(finite(found["error"][key]) for key in ERROR_KEYS)
    assert found["error"]["after"] < 1.2 * found["error"]["floor"] < 0.2 * found["error"]["before"]
    assert found["error"]["holdout_after"] < 0.2 * found["error"]["holdout_before"]
    # the model with the effect is written already, and explains the record
    assert found["next_experiment"] == f"Next: read CSJ and BLK: {shlex.join(found['next'][0])}"
    assert found["next"][0][:3] == ["ema", "identify", str(done / "d.toml")] and found["rivals"] == []


def test_add_writes_the_keys_that_programs_read(done: Path) -> None:
    found = result(done / "a.json")
    assert found["actuator"] == str(done / "a.toml")
    assert set(found["error"]) >= ERROR_KEYS
    size = found["parameters"]["effects.winding_heating.rise_degC"]
    assert set(size) == {"value", "std", "interval95", "unit", "at_bound"}
    assert abs(size["value"] - 60.0) < 4.0 * size["std"] and size["at_bound"] is False and size["unit"] == "degC"
    assert found["recommended"] is True
    machine = read_actuator(done / "a.toml")
    assert machine.active_effects == ("winding_heating",)
    assert machine["winding_heating.rise_degC"] == pytest.approx(size["value"], rel=1e-9)
    assert "winding_heating fitted on hot.csv" in machine.about["source"]


def test_what_diagnose_and_add_write_agree(done: Path) -> None:
    fitted, added = read_actuator(done / "d.toml"), read_actuator(done / "a.toml")
    assert fitted["winding_heating.rise_degC"] == pytest.approx(added["winding_heating.rise_degC"], rel=0.02)
    assert result(done / "d.json")["error"]["before"] == pytest.approx(result(done / "a.json")["error"]["before"], rel=1e-6)


def test_pages_show_size_and_standard_error(done: Path, tmp_path: Path) -> None:
    for name in ("d", "a"):
        page = (done / f"{name}.html").read_text(encoding="utf-8")
        assert re.search(r"<code>rise_degC</code> (59|60|61)(\.\d+)? ± \d(\.\d+)? degC", page), name
    assert run_ema("report", done / "d.json", done / "a.json", "-o", tmp_path / "both.html").code == 0
    both = (tmp_path / "both.html").read_text(encoding="utf-8")
    assert len(re.findall(r"rise_degC = (59|60|61)\.\d+ degC \[95 %: \d", both)) >= 2


@pytest.mark.slow
def test_csj_and_blk_stand_apart_from_effects(runs: dict[str, Path], tmp_path: Path) -> None:
    worn = written(tmp_path / "worn.csv", run_of(5, {"screw.csj_Nm": 0.2, "screw.blk_mm": 0.06}))
    repeats = [part for k in range(3) for part in ("--healthy", runs[f"healthy_{k}"])]
    assert run_ema("diagnose", REFERENCE, worn, *repeats, "--json", tmp_path / "d.json").code == 0
    found = result(tmp_path / "d.json")
    assert found["verdict"] == "adequate" and not any(one["accepted"] for one in found["effects"])
    check_effects(found["effects"])
    assert set(found["faults"]) == {"csj", "blk"}
    assert found["faults"]["csj"]["parameters"]["csj_Nm"] == pytest.approx(0.2, rel=0.01)
    assert found["faults"]["blk"]["parameters"]["blk_mm"] == pytest.approx(0.06, rel=0.03)


@pytest.mark.slow
def test_what_no_command_separates_is_said_with_what_would(tmp_path: Path) -> None:
    loaded = written(tmp_path / "loaded.csv", run_of(6, {"constant_load.torque_Nm": 0.05}))
    assert run_ema("diagnose", REFERENCE, loaded, "--json", tmp_path / "d.json").code == 0
    found = result(tmp_path / "d.json")
    assert set(next(one["class"] for one in found["effects"] if one["accepted"])) == {"constant_load", "coulomb_asymmetry"}
    assert found["rivals"] == ["coulomb_asymmetry"]
    assert "no command separates them; this would: turn the actuator over" in found["sentence"]
    # either is as good for the sizes of faults, and no second advice stands beside it
    assert found["next_experiment"].endswith(shlex.join(found["next"][0]))


def test_next_writes_its_keys(tmp_path: Path) -> None:
    ran = run_ema("next", REFERENCE, "--between", "constant_load", "coulomb_asymmetry", "--json", tmp_path / "n.json")
    assert ran.code == 0, ran.err
    found = result(tmp_path / "n.json")
    assert found["best"] is None and found["confused"] == [["constant_load", "coulomb_asymmetry"]] and found["advice"]
    assert all({"command", "separation", "pairs"} <= set(one) for one in found["options"])


def test_values_that_are_given_are_written_in_the_same_keys(tmp_path: Path) -> None:
    new = tmp_path / "new.toml"
    ran = run_ema("add", REFERENCE, "winding_heating", "--set", "rise_degC=30", "-o", new, "--json", tmp_path / "a.json")
    assert ran.code == 0, ran.err
    found = result(tmp_path / "a.json")
    assert found["actuator"] == str(new)
    assert found["parameters"] == {"effects.winding_heating.rise_degC": {"value": 30.0, "std": None, "unit": "degC", "at_bound": False}}
    assert set(found["error"]) == ERROR_KEYS and set(found["error"].values()) == {None}
    assert read_actuator(new)["winding_heating.rise_degC"] == 30.0
    assert found["replaced"] is None and ran.out == f"{new} written\n"
    again = tmp_path / "again.toml"
    ran = run_ema("add", new, "winding_heating", "--set", "rise_degC=40", "-o", again, "--json", tmp_path / "b.json")
    assert result(tmp_path / "b.json")["replaced"] == {"effects.winding_heating.rise_degC": 30.0}
    assert ran.out.startswith("Winding heating (winding_heating) was there with rise_degC = 30; it is now set to given values")


@pytest.mark.slow
def test_an_effect_that_is_there_is_refitted_and_said_so(runs: dict[str, Path], tmp_path: Path) -> None:
    old = tmp_path / "old.toml"
    assert run_ema("add", REFERENCE, "winding_heating", "--set", "rise_degC=10", "-o", old).code == 0
    ran = run_ema("add", old, "winding_heating", "--known", "--fit", runs["hot"], "-o", tmp_path / "new.toml")
    assert ran.code == 0, ran.err
    assert ran.out.startswith("Winding heating (winding_heating) was there and is refitted, rise_degC ")
    assert read_actuator(tmp_path / "new.toml")["winding_heating.rise_degC"] == pytest.approx(60.0, rel=0.05)
    ran = run_ema("identify", old, runs["hot"])
    assert ran.code == 0 and "is not in the model at this size" in ran.out


@pytest.mark.slow
def test_an_effect_of_the_file_that_the_healthy_runs_do_not_have_counts_for_today(tmp_path: Path) -> None:
    new, story = tmp_path / "new.toml", RECORDINGS / "story"
    assert run_ema("add", REFERENCE, "stribeck_friction", "--set", "rise=0.3", "-o", new).code == 0
    repeats = [part for k in range(1, 4) for part in ("--healthy", story / f"healthy_{k}.csv")]
    ran = run_ema("identify", new, story / "today.csv", *repeats, "--json", tmp_path / "answer.json")
    found = result(tmp_path / "answer.json")
    assert found["verdict"] == "fault" and found["baseline"]["without"] == ["stribeck_friction"]
    # what the record was made with; friction scatters by 0.4 % from run to run
    assert found["csj_Nm"]["shift_percent"] == pytest.approx(40.0, abs=2.0)
    assert found["blk_mm"]["shift_percent"] == pytest.approx(100.0, abs=2.0)
    assert "New since the healthy records: Stribeck friction (stribeck_friction)" in " ".join(ran.out.split())


def test_nothing_is_overwritten(runs: dict[str, Path], tmp_path: Path) -> None:
    there = tmp_path / "there.html"
    there.write_text("mine", encoding="utf-8")
    for arguments in (
        ("diagnose", REFERENCE, runs["hot"], "--report", there),
        ("diagnose", REFERENCE, runs["hot"], "--json", there),
        ("diagnose", REFERENCE, runs["hot"], "--fitted", there),
        ("add", REFERENCE, "winding_heating", "--fit", runs["hot"], "-o", tmp_path / "n.toml", "--report", there),
        ("add", REFERENCE, "winding_heating", "--set", "rise_degC=30", "-o", there),
        ("next", REFERENCE, "--between", "supply_sag", "winding_heating", "--json", there),
    ):
        assert complaint(run_ema(*arguments)) == f"{there}: exists already: choose another name or give --force"
        assert there.read_text(encoding="utf-8") == "mine"
    assert not (tmp_path / "n.toml").exists()
    assert complaint(run_ema("diagnose", REFERENCE, runs["hot"], "--report", runs["hot"], "--force")).startswith(
        f"{runs['hot']}: is read by this command"
    )


def _made(folder: Path, runs: dict[str, Path]) -> dict[str, Path]:
    """Records that cannot serve, by name, beside those of `runs`."""
    hot = run_of(1, HOT)
    part = {name: hot.recorded(name)[:150] for name in hot.present}
    records = {
        "short": replace(hot, **part),
        "rest": replace(hot, command_mm=np.zeros(hot.rows)),
        "milli": replace(hot, current_A=1e3 * hot.recorded("current_A")),
        "sign": replace(hot, current_A=-hot.recorded("current_A")),
        "flat": replace(hot, voltage_V=np.full(hot.rows, 12.0)),
        "dead": replace(run_of(12), current_A=np.zeros(hot.rows)),
        "healthy_milli": replace(run_of(12), current_A=1e3 * run_of(12).recorded("current_A")),
        "slow": replace(hot, period_s=0.002),
        "stuck": replace(hot, position_mm=np.zeros(hot.rows)),
    }
    found = {name: written(folder / f"{name}.csv", record) for name, record in records.items()}
    lines = runs["hot"].read_text(encoding="utf-8").splitlines()
    lines[500] = re.sub(r",[^,]*", ",nan", lines[500], count=1)
    found["nan"] = folder / "nan.csv"
    found["nan"].write_text("\n".join(lines) + "\n", encoding="utf-8")
    found["absent"] = folder / "absent.csv"
    return {**runs, **found}


REFUSED = {
    "a record that is not there": (("absent",), "absent.csv: there is no such file; check the path"),
    "NaN": (("nan",), 'nan.csv: row 501, command_mm: "nan" is not a finite number; fill in the measured value or record again'),
    "NaN in a healthy record": (("hot", "--healthy", "healthy_0", "--healthy", "nan"), "nan.csv: row 501"),
    "NaN in the record held out": (("hot", "--holdout", "nan"), "nan.csv: row 501"),
    "too short": (("short",), "short.csv has 150 rows, 0.15 s, too few for any filter: record 0.2 s or more, best a chirp of ten"),
    "a command that rests": (("rest",), "rest.csv: command_mm: the command never changes; record a command that moves the rod"),
    "another rate": (("slow",), "slow.csv: time_s: a row every 0.002 s, and the actuator records one every 0.001 s"),
    "a current in mA": (
        ("milli",),
        "milli.csv: the current is 1e+03 times the model's, as if it were in a thousandth of the unit: give current_A in A",
    ),
    "a current of the wrong sign": (("sign",), "sign.csv: the current runs opposite to the model: change the sign of current_A"),
    "a voltage that is constant": (
        ("flat",),
        "flat.csv: voltage_V does not change while the command does: check that the voltage is connected",
    ),
    "a rod that rests": (("stuck",), "stuck.csv: the rod moves 0 mm, no more than its sensor's noise: check that the drive was on"),
    "healthy of another command": (
        ("hot", "--healthy", "healthy_0", "--healthy", "other"),
        "other.csv: command_mm: neither the command of hot.csv nor that of a record held out: give healthy records of the same command",
    ),
    "one healthy record": (
        ("hot", "--healthy", "healthy_0"),
        "healthy_0.csv: one healthy record tells nothing of repeatability: record another under the same command and give both, or none",
    ),
    "a healthy record twice": (
        ("hot", "--healthy", "healthy_0", "--healthy", "healthy_0"),
        "healthy_0.csv: given twice: give every healthy run once",
    ),
    "the record as healthy": (
        ("hot", "--healthy", "hot", "--healthy", "healthy_0"),
        "hot.csv: healthy is the record itself, against which nothing has changed: leave it out of --healthy",
    ),
    "the record held out": (
        ("hot", "--holdout", "hot"),
        "hot.csv: held out is the record itself, which confirms anything: give --holdout another run, best of another command",
    ),
    "a healthy record held out": (
        ("hot", "--healthy", "healthy_0", "--healthy", "healthy_1", "--holdout", "healthy_1"),
        "healthy_1.csv: held out is one of the healthy records, which shows no effect",
    ),
    "a dead sensor in a healthy record": (
        ("hot", "--healthy", "healthy_0", "--healthy", "dead"),
        "dead.csv: current_A does not change, while that of hot.csv does: check that the sensor was connected",
    ),
    "a current in mA beside healthy ones": (
        ("milli", "--healthy", "healthy_0", "--healthy", "healthy_1"),
        "milli.csv: current_A is ",
    ),
    "another unit in a healthy record": (
        ("hot", "--healthy", "healthy_0", "--healthy", "healthy_milli"),
        "healthy_milli.csv: current_A is ",
    ),
}


@pytest.fixture(scope="module")
def bad(runs: dict[str, Path], tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    return _made(tmp_path_factory.mktemp("bad"), runs)


@pytest.mark.parametrize("what", REFUSED)
def test_wrong_records_are_refused_by_diagnose_and_add_alike(what: str, bad: dict[str, Path], tmp_path: Path) -> None:
    names, message = REFUSED[what]
    arguments = [bad.get(name, name) for name in names]
    new = tmp_path / "new.toml"
    for ran in (
        run_ema("diagnose", REFERENCE, *arguments, "--report", tmp_path / "d.html"),
        run_ema("add", REFERENCE, "winding_heating", "--fit", *arguments, "-o", new),
    ):
        said = complaint(ran)
        assert message in said and Path(said.split(":")[0].split(" ")[0]).name == message.split(":")[0].split(" ")[0]
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("winding_heatin", "--fit", "hot"), "effect winding_heatin: unknown (did you mean winding_heating, "),
        (("csj", "--fit", "hot"), "add csj: no effect but a value that every model has, screw.csj_Nm: ema identify finds it"),
        (("learned_torque", "--fit", "healthy_0"), "learned_torque: nothing in the record repeats in a way that it could hold"),
        (
            ("learned_torque", "--fit", "hot", "--known"),
            "learned_torque: a table that is learned, or no effect at all: --known takes the physical effects that ema effects lists",
        ),
        (
            ("winding_heating",),
            "add winding_heating: nothing to fit it to: give --fit REC, or its values with --set FIELD=VALUE and no other option",
        ),
        (
            ("winding_heating", "--set", "rise_degC=0"),
            "add winding_heating: rise_degC=0: at these values the effect is absent: give its size with --set",
        ),
        (
            ("winding_heating", "--set", "rise=3"),
            "effects.winding_heating.rise: unknown value (did you mean effects.winding_heating.rise_degC?)",
        ),
        (
            ("winding_heating", "--set", "rise_degC=1e9"),
            "--set effects.winding_heating.rise_degC = 1000000000.0: outside -80 .. 200 degC: give a value inside",
        ),
        (
            ("winding_heating", "--set", "rise_degC=3", "--fit", "hot"),
            "add winding_heating: --set rise_degC=3: with --fit the values come from the record: leave one of the two out",
        ),
        (
            ("winding_heating", "--set", "rise_degC=3", "--holdout", "hot"),
            "add winding_heating: nothing to fit it to: give --fit REC, or its values with --set FIELD=VALUE and no other option",
        ),
    ],
)
def test_wrong_additions_are_one_line(arguments: tuple[str, ...], message: str, runs: dict[str, Path], tmp_path: Path) -> None:
    new = tmp_path / "new.toml"
    assert complaint(run_ema("add", REFERENCE, *(runs.get(one, one) for one in arguments), "-o", new)).startswith(message)
    assert not new.exists()


@pytest.mark.slow
def test_an_effect_with_a_value_too_many_ends_in_its_special_case(tmp_path: Path) -> None:
    """Beside these two runs a Stribeck friction of two directions comes first, before wear is known; beside the wear nothing of its second direction is left."""
    story = RECORDINGS / "story"
    healthy = [part for number in (1, 2) for part in ("--healthy", story / f"healthy_{number}.csv")]
    assert run_ema("diagnose", REFERENCE, story / "today.csv", *healthy, "--json", tmp_path / "found.json").code == 0
    effects = json.loads((tmp_path / "found.json").read_text(encoding="utf-8"))["effects"]
    assert {one["name"] for one in effects if one["accepted"]} == {"stribeck_friction"}


def test_records_given_twice_do_not_confirm_themselves(runs: dict[str, Path], tmp_path: Path) -> None:
    copy = tmp_path / "copy.csv"
    copy.write_bytes(runs["hot"].read_bytes())
    message = "copy.csv: holds the same samples as hot.csv: give every run once"
    assert complaint(run_ema("diagnose", REFERENCE, runs["hot"], copy)) == message
    assert complaint(run_ema("add", REFERENCE, "stribeck_friction", runs["hot"], copy, "-o", tmp_path / "new.toml")) == message


def test_compare_says_which_signal_is_not_the_machines(runs: dict[str, Path], tmp_path: Path) -> None:
    """What a sensor that is not connected reads, or another unit, is no place where the model fails."""
    record = read_record(runs["hot"])
    for factor, words in (
        (0.0, "current_A does not change while the command does: check that the"),
        (-1.0, "change the sign of current_A"),
        (1e3, "give current_A in A"),
    ):
        other = tmp_path / f"current_{factor:g}.csv"
        write_record(other, record.with_columns({"current_A": factor * record.recorded("current_A")}))
        said = run_ema("compare", REFERENCE, other)
        assert said.code == 0 and words in " ".join(said.out.split())
    assert "tells nothing of the machine" not in run_ema("compare", REFERENCE, runs["hot"]).out


def test_identify_refuses_itself_as_healthy(runs: dict[str, Path]) -> None:
    assert complaint(run_ema("identify", REFERENCE, runs["hot"], "--healthy", runs["hot"])).startswith(
        "hot.csv: healthy is the record itself"
    )
    twice = run_ema("identify", REFERENCE, runs["hot"], "--healthy", runs["healthy_0"], "--healthy", runs["healthy_0"])
    assert complaint(twice) == "healthy_0.csv: given twice: give every healthy run once"


@pytest.mark.slow
def test_identify_blames_a_record_that_cannot_answer_and_no_effect(bad: dict[str, Path], tmp_path: Path) -> None:
    hot = run_of(1, HOT)
    alone = replace(hot, motor_position_mm=None, current_A=None, voltage_V=None)
    turned = written(tmp_path / "turned.csv", replace(alone, position_mm=-hot.position_mm))
    noisy = written(tmp_path / "noisy.csv", replace(alone, position_mm=np.random.default_rng(1).normal(0.0, 2.0, hot.rows)))
    for path, why in ((turned, "the rod position runs opposite to the model"), (noisy, "no more than its sensor's noise")):
        ran = run_ema("identify", REFERENCE, path, "--json", tmp_path / "i.json", "--force")
        assert ran.code == 0, ran.err
        found = result(tmp_path / "i.json")
        assert found["verdict"] == "undecided" and found["missing_effect"]["name"] is None
        assert any(why in reason for reason in found["reasons"])


ODD_RECORDS = {
    "500 rows": {"cut": 500},
    "position alone": {"keep": ()},
    "with speed_mm_s alone": {"keep": ("speed_mm_s",)},
    "voltage alone": {"keep": ("voltage_V",)},
    "current alone": {"keep": ("current_A",)},
    "triangle": {"text": "triangle:duration_s=4"},
    "step": {"text": "step"},
}
ODD_ACTUATORS: dict[str, dict[str, object]] = {
    "250 rows a second": {"record_every_steps": 4},
    "rod feedback": {"side": "rod"},
    "current mode": {"mode": "current", "current_scale_A": 25.0, "current_loop_s": 0.0005},
    "cascade": {"structure": "cascade", "position_gain_per_s": 60.0, "speed_gain_s_per_m": 8.0, "speed_integral_per_m": 100.0},
    "no play": {"blk_mm": 0.0},
}


def _odd(record: Record, cut: int | None = None, keep: tuple[str, ...] | None = None, **_: object) -> Record:
    """A record cut to its first rows, or with some signals only."""
    if cut is not None:
        record = replace(record, **{name: record.recorded(name)[:cut] for name in record.present})
    if keep is not None:
        record = replace(record, **{name: None for name in record.present if name not in ("command_mm", "position_mm", *keep)})
    return record


@pytest.mark.parametrize("odd", [pytest.param(odd, marks=() if "cut" in how else pytest.mark.slow) for odd, how in ODD_RECORDS.items()])
def test_odd_records_are_answered(odd: str, tmp_path: Path) -> None:
    how = ODD_RECORDS[odd]
    full = chirp_record(reference_actuator().changed(HOT), str(how.get("text", SHORT))).with_noise(NOISE, 1)
    check_named(
        REFERENCE,
        written(tmp_path / "rec.csv", _odd(full, **how)),
        "winding_heating",
        60.0,
        tmp_path,
        named=odd not in ("step", "voltage alone", "position alone", "with speed_mm_s alone"),
    )


@pytest.mark.slow
@pytest.mark.parametrize("odd", ODD_ACTUATORS)
def test_odd_actuators_are_answered(odd: str, tmp_path: Path) -> None:
    actuator = changed_actuator(tmp_path / "act.toml", **ODD_ACTUATORS[odd])
    # a winding does not show in the motion of a drive that gives the current
    effect, size = ("spring_load", 0.01) if odd == "current mode" else ("winding_heating", 60.0)
    hidden = {f"{effect}.{load_definitions().effect(effect).parameters[0].field}": size}
    check_named(actuator, written(tmp_path / "rec.csv", run_of(1, hidden, SHORT, actuator)), effect, size, tmp_path)


@pytest.mark.slow
def test_a_long_record_is_answered(tmp_path: Path) -> None:
    """More rows than 16 bits with a sign count."""
    check_named(REFERENCE, written(tmp_path / "rec.csv", run_of(1, HOT, "chirp:duration_s=33")), "winding_heating", 60.0, tmp_path)


def check_named(actuator: Path, record: Path, effect: str, size: float, folder: Path, named: bool = True) -> None:
    """diagnose names the effect among its class (without repeats a step shows too little for that, voltage without current not whether the winding or the friction takes it, and positions
    alone hot windings by 3.7 standard deviations of what units differ by, which one value of nine is off by chance too often), add --known finds its size, identify no fault."""
    ran = run_ema("diagnose", actuator, record, "--json", folder / "d.json", "--report", folder / "d.html")
    assert ran.code == 0, ran.err
    found = result(folder / "d.json")
    check_effects(found["effects"])
    if named:
        assert found["verdict"] == "missing" and effect in {name for one in found["effects"] if one["accepted"] for name in one["class"]}, (
            found["sentence"]
        )
    ran = run_ema("add", actuator, effect, "--known", "--fit", record, "-o", folder / "new.toml", "--json", folder / "a.json")
    assert ran.code == 0, ran.err
    fitted = next(iter(result(folder / "a.json")["parameters"].values()))
    assert abs(fitted["value"] - size) < max(4.0 * fitted["std"], 0.02 * size)
    ran = run_ema("identify", actuator, record, "--json", folder / "i.json")
    assert ran.code == 0, ran.err
    assert result(folder / "i.json")["verdict"] != "fault"
    ran = run_ema("identify", folder / "new.toml", record, "--json", folder / "i.json", "--force")
    assert ran.code == 0 and result(folder / "i.json")["verdict"] in ("healthy", "undecided")


def test_a_healthy_run_held_out_is_said_and_no_table_made(runs: dict[str, Path], tmp_path: Path) -> None:
    repeats = [part for k in range(2) for part in ("--healthy", runs[f"healthy_{k}"])]
    told = tmp_path / "told.json"
    ran = run_ema("diagnose", REFERENCE, runs["hot"], *repeats, "--holdout", runs["healthy_2"], "--json", told)
    found = json.loads(told.read_text(encoding="utf-8"))
    assert found["verdict"] == "unknown" and not any(effect["accepted"] for effect in found["effects"])
    said = " ".join(ran.out.split())
    assert (
        "winding heating (winding_heating) would explain it, but nothing is missing on the record held out, as on a run of the healthy machine"
        in said
    )
    assert "Next: give --holdout a run of the machine as it is in hot.csv" in said and "learned" not in said


def test_a_signal_that_does_not_change_is_said_by_identify(runs: dict[str, Path], tmp_path: Path) -> None:
    record = read_record(runs["hot"], read_actuator(REFERENCE))
    dead = written(tmp_path / "dead.csv", replace(record, current_A=np.zeros(record.rows)))
    assert (
        "dead.csv: current_A does not change and is left out: check that its sensor was connected"
        in run_ema("identify", REFERENCE, dead, "--no-guard").err
    )
    assert "left out" not in run_ema("identify", REFERENCE, runs["hot"], "--no-guard").err
