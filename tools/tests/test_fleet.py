"""`ema fleet`: which recordings there are, that each is judged once whatever happens on the way, and what is said of the units."""

from __future__ import annotations

import csv
import json
import os
import shutil
import signal
import sys
from collections.abc import Iterator
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pytest

from ema_tools.base.errors import InputError
from ema_tools.data.manifest import read_manifest
from ema_tools.results import store
from ema_tools.results.codec import to_json
from ema_tools.results.provenance import provenance
from ema_tools.results.reading import read_result
from ema_tools.results.store import FleetRow, drop_superseded, keys, read_rows, write_part
from ema_tools.tasks import fleet as tasks_fleet
from ema_tools.tasks.fleet import RESULTS, Batch, firsts_first, judge, planned, run_fleet
from ema_tools.tasks.history import LIMITS, histories, limits_of
from ema_tools.words.answers.fleet import fleet_result
from ema_tools.words.page.fleet import fleet_page, unit_page
from support import RECORDINGS, REFERENCE, ROOT, complaint, run_ema

UNIT = RECORDINGS / "unit"
FIRST = datetime(2026, 1, 1, tzinfo=UTC)


def make_fleet(folder: Path, units: int, *, bad: bool = False) -> Path:
    """Units by folder names: calibrated ones, since calibrating takes seconds."""
    folder.mkdir()
    for number in range(units):
        own = folder / f"unit{number}"
        own.mkdir()
        for name in ("unit.toml", "healthy_1.csv", "healthy_2.csv", "healthy_3.csv"):
            shutil.copy(UNIT / name, own)
        shutil.copy(UNIT / "sound.csv", own / "2026-05-01.csv")
        shutil.copy(UNIT / "worn.csv", own / "2026-06-01T0930.csv")
    if bad:
        (folder / "unit0" / "2026-07-01.csv").write_text("time_s,command_mm,position_mm\n0,0,nan\n", encoding="utf-8")
    return folder


def test_folders_and_names_say_what_is_there(tmp_path: Path) -> None:
    entries = read_manifest(make_fleet(tmp_path / "fleet", 2))
    assert len(entries) == 10
    assert {one.unit for one in entries} == {"unit0", "unit1"}
    dated = {one.file.name: one for one in entries if one.unit == "unit1"}
    assert dated["2026-06-01T0930.csv"].date == datetime(2026, 6, 1, 9, 30, tzinfo=UTC)
    assert [one.file.name for one in entries if one.unit == "unit0"][:3] == ["healthy_1.csv", "healthy_2.csv", "healthy_3.csv"]
    assert {name for name, one in dated.items() if one.kind == "healthy"} == {"healthy_1.csv", "healthy_2.csv", "healthy_3.csv"}
    assert {one.actuator.name for one in entries} == {"unit.toml"}


@pytest.mark.parametrize("ending", ["csv", "parquet"])
def test_a_manifest_says_it_where_there_is_one(tmp_path: Path, ending: str) -> None:
    rows = [
        {"unit": "left", "file": "a.csv", "date": "2026-03-04T10:00:00+02:00", "kind": "healthy", "actuator": "x.toml"},
        {"unit": "left", "file": "2026-03-05.csv", "date": "", "kind": "", "actuator": "x.toml"},
    ]
    if ending == "csv":
        with (tmp_path / "manifest.csv").open("w", encoding="utf-8", newline="") as stream:
            stream.write("# of one aircraft\n")
            writer = csv.DictWriter(stream, list(rows[0]))
            writer.writeheader()
            writer.writerows(rows)
    else:
        import pyarrow
        import pyarrow.parquet

        pyarrow.parquet.write_table(pyarrow.Table.from_pylist(rows), tmp_path / "manifest.parquet")
    first, second = read_manifest(tmp_path)
    assert (first.unit, first.date, first.kind) == ("left", datetime(2026, 3, 4, 8, tzinfo=UTC), "healthy")
    assert (second.date.date().isoformat(), second.kind, second.actuator) == ("2026-03-05", "test", tmp_path / "x.toml")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("unit,date\na,2026-01-01\n", "manifest.csv: no column file: its columns are unit, file, date, kind, actuator"),
        ("unit,file\na,\n", "manifest.csv: row 1: file: not there"),
        ("unit,file,date\na,r.csv,4.3.2026\n", "manifest.csv: row 1: date = 4.3.2026: write it as 2026-03-31"),
        ("unit,file,kind\na,r.csv,new\n", "manifest.csv: row 1: kind = new: write one of healthy, test"),
        ("unit,file\na,r.csv\n", "manifest.csv: row 1: no actuator: name its TOML file"),
        ("unit,file\n", "no recordings there"),
    ],
)
def test_a_wrong_manifest_is_named(tmp_path: Path, text: str, said: str) -> None:
    (tmp_path / "manifest.csv").write_text(text, encoding="utf-8")
    assert said in complaint(run_ema("fleet", tmp_path, "-o", tmp_path / "out"))


def test_a_wrong_folder_is_named(tmp_path: Path) -> None:
    assert "no folder" in complaint(run_ema("fleet", tmp_path / "none", "-o", tmp_path / "out"))
    fleet = make_fleet(tmp_path / "fleet", 1)
    shutil.copy(REFERENCE, fleet / "unit0" / "second.toml")
    assert "second.toml and unit.toml: which is the actuator?" in complaint(run_ema("fleet", fleet, "-o", tmp_path / "out"))
    assert "--limit csj=-3: write csj=PERCENT" in complaint(run_ema("fleet", fleet, "-o", tmp_path / "out", "--limit", "csj=-3"))


def row(number: int, shift: float, *, unit: str = "a", std: float = 0.5, day: float | None = None) -> FleetRow:
    """A reading of CSJ; BLK stays."""
    ends = {"csj_low_percent": shift - 1.96 * std, "csj_high_percent": shift + 1.96 * std}
    return FleetRow(
        f"{unit}{number}",
        unit,
        FIRST + timedelta(days=float(number if day is None else day)),
        f"{number}.csv",
        "test",
        "a.toml",
        verdict="healthy",
        adequate=True,
        csj_shift_percent=shift,
        blk_shift_percent=0.0,
        blk_low_percent=-1.0,
        blk_high_percent=1.0,
        **ends,
    )


def test_rows_are_kept_whole_and_once(tmp_path: Path) -> None:
    rows = [row(number, 0.1 * number) for number in range(5)]
    assert write_part(tmp_path, rows[:3]) == write_part(tmp_path, rows[:3])
    write_part(tmp_path, [*rows[3:4], replace(rows[4], status="bad", reason="gone", csj_shift_percent=None)])
    assert keys(tmp_path) == {one.key for one in rows}
    read = {one.key: one for one in read_rows(tmp_path)}
    assert read[rows[1].key] == rows[1]
    assert read[rows[4].key].reason == "gone"
    assert len(list(read_rows(tmp_path))) == 5


def test_a_part_of_another_version_is_read_or_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import pyarrow
    import pyarrow.parquet

    part = write_part(tmp_path, [row(1, 3.0)])
    table = pyarrow.parquet.read_table(part)
    older = table.drop_columns(["effect", "wall_s"]).append_column("gone_since", pyarrow.array(["x"]))
    pyarrow.parquet.write_table(older, part)
    assert list(read_rows(tmp_path)) == [row(1, 3.0)]
    monkeypatch.setattr(store, "VERSION", 2)
    later = write_part(tmp_path, [row(2, 3.0)])
    monkeypatch.undo()
    with pytest.raises(InputError, match="rows of version 2, written by a later version of the tools"):
        list(read_rows(tmp_path))
    later.write_bytes(b"no parquet")
    with pytest.raises(InputError, match="not a readable part of the results: remove it"):
        keys(tmp_path)


def drifting(unit: str, slope: float, seed: int) -> Iterator[FleetRow]:
    """Readings of a unit that wears from its tenth day on."""
    noise = np.random.default_rng(seed).normal(0.0, 0.5, 40)
    return (row(day, slope * max(0, day - 10) + float(noise[day]), unit=unit) for day in range(40))


def test_units_are_told_apart_by_urgency() -> None:
    rows = [*drifting("slow", 0.3, 1), *drifting("still", 0.0, 2), *drifting("fast", 1.2, 3), *drifting("falls", -0.5, 4)]
    found = histories(rows, LIMITS)
    assert [one.unit for one in found][:2] == ["fast", "slow"]
    by_unit = {one.unit: {trend.name: trend for trend in one.trends} for one in found}
    fast = by_unit["fast"]["csj"]
    assert fast.change.changed
    assert fast.life is not None
    # from its last day at 34.8 % to 50 %, at 1.2 % a day
    assert fast.life.low < (50.0 - 1.2 * 29) / 1.2 < fast.life.high
    assert abs(fast.change.since - 10.0) <= 3.0
    assert not by_unit["still"]["csj"].change.changed
    assert by_unit["falls"]["csj"].change.by < 0.0
    assert by_unit["falls"]["csj"].life is None
    assert not by_unit["fast"]["blk"].change.changed


def test_what_the_model_does_not_explain_does_not_count() -> None:
    rows = [*(row(day, 0.1 * (day % 2)) for day in range(20)), *(replace(row(day, 40.0), adequate=False) for day in range(20, 40))]
    (found,) = histories(rows, LIMITS)
    assert not any(trend.change.changed for trend in found.trends)
    assert len(found.rows) == 40


def test_limits_are_stated_in_words() -> None:
    assert limits_of("csj=30") == {"csj": 30.0, "blk": LIMITS["blk"]}
    for wrong in ("csj", "csj=0", "friction=3", "blk=inf"):
        with pytest.raises(InputError, match="--limit"):
            limits_of(wrong)


def test_pages_and_result_say_the_same(tmp_path: Path) -> None:
    units = histories(
        [*drifting("a<b", 1.2, 3), *drifting("still", 0.0, 2), replace(row(50, 0.0, unit="still"), status="bad", reason="r <x>")], LIMITS
    )
    result = fleet_result(units, LIMITS, 0.01, 81, 2.0, provenance("ema fleet F -o D"))
    path = tmp_path / "f.json"
    path.write_text(json.dumps(to_json(result)), encoding="utf-8")
    assert read_result(path) == result
    page = fleet_page(result, {"a<b": "units/1.html", "still": "units/2.html"}, "ema fleet F -o D")
    assert "1 of 2 units drifts. a&lt;b reaches a limit first, that of CSJ in " in page
    assert "a<b" not in page
    assert "1 recording could not be judged." in page
    assert "still does not drift." in page
    assert "<script" not in page
    own = unit_page(result.units[1], units[1].rows, "../fleet.html", "ema fleet F -o D")
    assert "r &lt;x&gt;" in own
    assert own.count("<tr>") == 1 + 41


def test_a_units_first_batch_comes_before_its_others_and_each_once() -> None:
    batches = [
        Batch(unit, "a.toml", (), unit, (), (str(place),), "out", False) for unit in "abcde" for place in range(3 if unit != "c" else 1)
    ]
    order = list(firsts_first(batches, 2))
    assert [f"{one.unit}{one.keys[0]}" for one in order[:6]] == ["a0", "b0", "a1", "a2", "b1", "b2"]
    assert sorted(map(id, order)) == sorted(map(id, batches))
    for unit in "abcde":
        assert [one.keys for one in order if one.unit == unit] == [one.keys for one in batches if one.unit == unit]


@pytest.mark.slow
def test_every_recording_is_judged_once(tmp_path: Path) -> None:
    """Also with a worker that is killed on the way; and one worker finds what two do."""
    import psutil

    fleet = make_fleet(tmp_path / "fleet", 3, bad=True)
    entries = read_manifest(fleet)
    batches, wanted = planned(entries, tmp_path / "two", guarded=False)
    killed: list[int] = []

    def kill_one(good: int, bad: int) -> None:
        if not killed:
            workers = [one for one in psutil.Process().children(recursive=True) if "spawn_main" in " ".join(one.cmdline())]
            killed.append(workers[-1].pid)
            workers[-1].kill()

    assert run_fleet(batches, workers=2, done=kill_one) == (16, 1)
    assert killed
    rows = list(read_rows(tmp_path / "two" / RESULTS))
    assert sorted(one.key for one in rows) == sorted(wanted.values())
    assert planned(entries, tmp_path / "two", guarded=False)[0] == []
    by_file = {Path(one.file).relative_to(fleet).as_posix(): one for one in rows}
    assert by_file["unit0/2026-07-01.csv"].status == "bad"
    assert "2026-07-01.csv: row 2" in by_file["unit0/2026-07-01.csv"].reason
    assert by_file["unit2/2026-06-01T0930.csv"].verdict == "fault"
    assert by_file["unit2/2026-05-01.csv"].verdict == "healthy"

    one_worker, _ = planned([one for one in entries if one.unit == "unit0"], tmp_path / "one", guarded=False)
    run_fleet(one_worker, workers=1)
    alone_rows = list(read_rows(tmp_path / "one" / RESULTS))
    assert len(alone_rows) == 6
    for alone in alone_rows:
        beside = by_file[Path(alone.file).relative_to(fleet).as_posix()]
        assert replace(alone, wall_s=None) == replace(beside, wall_s=None)


@pytest.mark.slow
def test_the_command_goes_on_where_it_stopped(tmp_path: Path) -> None:
    fleet = make_fleet(tmp_path / "fleet", 1)
    out = tmp_path / "out"
    ran = run_ema("fleet", fleet, "-o", out, "--workers", "1", "--json", tmp_path / "f.json")
    assert ran.code == 0, ran
    assert "5 of 5 recordings judged now" in ran.out
    assert json.loads((tmp_path / "f.json").read_text(encoding="utf-8"))["units"][0]["records"] == 5
    shutil.copy(UNIT / "worn.csv", fleet / "unit0" / "2026-08-01.csv")
    (fleet / "unit0" / "2026-09-01.csv").write_text("x\n", encoding="utf-8")
    ran = run_ema("fleet", fleet, "-o", out, "--workers", "1")
    assert "2 of 7 recordings judged now" in ran.out
    assert "2026-09-01.csv" in ran.err
    assert {path.name for path in out.iterdir()} == {"fleet.html", "results", "units"}
    assert "unit0" in (out / "fleet.html").read_text(encoding="utf-8")
    assert ran.code == 0
    # another healthy run makes another model of the unit: all is judged anew, and what was judged before makes room
    shutil.copy(UNIT / "healthy_1.csv", fleet / "unit0" / "healthy_4.csv")
    ran = run_ema("fleet", fleet, "-o", out, "--workers", "1")
    assert "8 of 8 recordings judged now" in ran.out
    assert len(list(read_rows(out / RESULTS))) == 8


def test_a_unit_with_two_actuator_files_is_bad_and_the_others_are_judged(tmp_path: Path) -> None:
    fleet = make_fleet(tmp_path / "fleet", 2)
    shutil.copy(REFERENCE, fleet / "other.toml")
    rows = [
        (f"unit{unit}", f"unit{unit}/{name}.csv", f"unit{unit}/unit.toml") for unit in (0, 1) for name in ("2026-05-01", "2026-06-01T0930")
    ]
    rows[1] = (*rows[1][:2], "other.toml")
    with (fleet / "manifest.csv").open("w", encoding="utf-8", newline="") as file:
        csv.writer(file).writerows([("unit", "file", "actuator"), *rows])
    batches, wanted = planned(read_manifest(fleet), tmp_path / "out", guarded=False)
    assert [judge(batch) for batch in batches] == [(0, 2), (2, 0)]
    kept = {(one.unit, Path(one.file).name): one for one in read_rows(tmp_path / "out" / RESULTS)}
    for name in ("2026-05-01.csv", "2026-06-01T0930.csv"):
        assert kept["unit0", name].reason == "unit0: other.toml and unit.toml: a unit has one actuator file: name the same one in its rows"
        assert kept["unit1", name].status == "ok"
    units = {one.unit: one for one in histories(kept.values(), LIMITS)}
    assert len(units["unit0"].bad) == 2
    # mended, its recordings are judged anew
    rows[1] = (*rows[1][:2], "unit0/unit.toml")
    with (fleet / "manifest.csv").open("w", encoding="utf-8", newline="") as file:
        csv.writer(file).writerows([("unit", "file", "actuator"), *rows])
    again, after = planned(read_manifest(fleet), tmp_path / "out", guarded=False)
    assert [len(batch.entries) for batch in again] == [2]
    assert {key for key in wanted if wanted[key] != after[key]} == {one for one in wanted if one[0] == "unit0"}


@pytest.mark.slow
def test_a_cluster_elsewhere_finds_what_this_machine_does(tmp_path: Path) -> None:
    """The command on a scheduler with workers of its own, by its address; where none answers it says so."""
    from distributed import LocalCluster

    fleet = make_fleet(tmp_path / "fleet", 1, bad=True)
    with LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, host="127.0.0.1", silence_logs=50
    ) as cluster:
        address = cluster.scheduler_address
        ran = run_ema("fleet", fleet, "-o", tmp_path / "there", "--scheduler", address, "--json", tmp_path / "f.json")
        assert ran.code == 0, ran
        assert "6 of 6 recordings judged now" in ran.out
        assert "2026-07-01.csv" in ran.err
        # the cluster is not the command's: it is still there, and asked once more has nothing to do
        assert "0 of 6 recordings judged now" in run_ema("fleet", fleet, "-o", tmp_path / "there", "--scheduler", address).out
    batches, _ = planned(read_manifest(fleet), tmp_path / "here", guarded=False)
    for batch in batches:
        judge(batch)
    there, here = ({one.key: replace(one, wall_s=None) for one in read_rows(tmp_path / place / RESULTS)} for place in ("there", "here"))
    assert there == here
    (fleet / "unit0" / "2026-08-01.csv").write_text("x\n", encoding="utf-8")
    assert "no cluster answers there" in complaint(run_ema("fleet", fleet, "-o", tmp_path / "there", "--scheduler", address))
    wrong = run_ema("fleet", fleet, "-o", tmp_path / "there", "--scheduler", address, "--workers", "2")
    assert "--workers is of this machine" in wrong.err


@pytest.mark.parametrize("built", [True, False])
def test_without_dask_a_cluster_is_refused_with_what_installs_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, built: bool) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    monkeypatch.setattr(sys, "prefix", str(tmp_path / "venv"))
    (tmp_path / "venv").mkdir()
    if built:
        (tmp_path / "venv" / "run.stamp").touch()
    installs = f"cmake --build {tmp_path} --target venv_fleet" if built else f"{sys.executable} -m pip install dask distributed"
    batches, _ = planned(read_manifest(make_fleet(tmp_path / "fleet", 1)), tmp_path / "out", guarded=False)
    with pytest.raises(InputError) as refused:
        run_fleet(batches, scheduler="tcp://127.0.0.1:1")
    assert str(refused.value) == f"--scheduler needs Dask, which is not installed: run {installs}, or leave --scheduler out"


def test_a_later_version_of_the_tools_reads_what_an_earlier_one_wrote(tmp_path: Path) -> None:
    """The part was written by version 1 of the rows, and is kept as it is."""
    shutil.copy(Path(__file__).with_name("fleet_rows_1.parquet"), tmp_path / "part-kept.parquet")
    first, second = read_rows(tmp_path)
    assert first == row(1, 3.0)
    assert second == replace(row(2, 4.5), status="bad", reason="a.csv: row 7: not a number")


def test_rows_that_are_superseded_make_room(tmp_path: Path) -> None:
    older, other = row(1, 3.0), row(2, 3.0)
    newer = replace(older, key="newer")
    write_part(tmp_path, [older, other])
    wanted = {("a", "1.csv"): "newer", ("a", "2.csv"): other.key}
    drop_superseded(tmp_path, wanted)
    assert set(read_rows(tmp_path)) == {older, other}, "the older row stays until the newer is there"
    write_part(tmp_path, [newer])
    drop_superseded(tmp_path, wanted)
    assert set(read_rows(tmp_path)) == {newer, other}


def deadly(batch: Batch) -> tuple[int, int]:
    """Judges a batch, and takes its worker along where a recording is among them."""
    if any(entry.file.name.startswith("2026-06") for entry in batch.entries):
        os.kill(os.getpid(), signal.SIGKILL)
    return judge(batch)


@pytest.mark.slow
def test_a_recording_that_kills_its_worker_is_bad_and_the_others_are_judged(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fleet = make_fleet(tmp_path / "fleet", 1)
    batches, wanted = planned(read_manifest(fleet), tmp_path / "out", guarded=False)
    monkeypatch.setattr(tasks_fleet, "judge", deadly)
    # the workers find the function by its name in this file
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(Path(__file__).parent), str(ROOT / "tools")]))
    assert run_fleet(batches, workers=1) == (5, 1), "five recordings, one of them bad"
    rows = list(read_rows(tmp_path / "out" / RESULTS))
    assert sorted(one.key for one in rows) == sorted(wanted.values())
    (bad,) = [one for one in rows if one.status == "bad"]
    assert "2026-06-01T0930.csv: every worker that judged it was killed" in bad.reason


def test_an_undecided_last_record_near_a_large_shift_is_in_the_headline() -> None:
    rows = [*(row(day, 0.1 * (day % 2)) for day in range(20)), replace(row(20, 0.0), verdict="undecided", blk_shift_percent=77.0)]
    rows += [row(day, 0.1 * (day % 2), unit="still") for day in range(20)]
    result = fleet_result(histories(rows, LIMITS), LIMITS, 0.01, 41, 2.0, provenance("ema fleet F -o D"))
    assert result.sentence.startswith("None of 2 units is known to drift. Undecided near a large shift in the last record: a (BLK +77")
    sentences = {unit.unit: unit.sentence for unit in result.units}
    assert "undecided near BLK +77" in sentences["a"]
    assert sentences["still"] == "still does not drift."
