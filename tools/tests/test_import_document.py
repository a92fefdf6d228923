"""docs/IMPORT.md tells the truth: its walk, its map, its tables. The walk is skipped where the measured files are not there."""

from __future__ import annotations

import json
import re
import shlex
import tomllib
from dataclasses import fields
from pathlib import Path

import pytest

from ema_tools.data.motion_records import COLUMNS
from ema_tools.data.tables.table_map import COLUMN_KEYS, NUMBERS, QUANTITIES, WORDS
from ema_tools.data.tables.text import DECIMALS, DELIMITERS, Stated
from shown_output import blocks, missing_from
from support import ROOT, complaint, lead_screw_folder, run_ema

DOCUMENT = ROOT / "docs" / "IMPORT.md"
TEXT = DOCUMENT.read_text(encoding="utf-8")


def test_the_walk_is_what_the_commands_do(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    data = lead_screw_folder()
    monkeypatch.chdir(tmp_path)
    (tmp_path / data.name).symlink_to(data)
    draft, table, refusal, *_ = blocks(DOCUMENT)
    shown_draft, shown_table, _ = blocks(DOCUMENT, "text")
    (completed,) = blocks(DOCUMENT, "toml")
    ran = run_ema(*shlex.split(draft)[1:])
    assert ran.code == 0, ran.err
    assert missing_from(shown_draft, ran.out) == ""
    drafted = tomllib.loads(Path("build/map.toml").read_text(encoding="utf-8"))
    wanted = tomllib.loads(completed)
    # signs and what the data sheets say is all that is written by hand
    for name, column in wanted["columns"].items():
        assert {**drafted["columns"][name], **({"sign": -1} if "sign" in column else {})} == column
    Path("build/map.toml").write_text(completed, encoding="utf-8")
    ran = run_ema(*shlex.split(table)[1:])
    assert ran.code == 0, ran.err
    assert missing_from(shown_table, ran.out) == ""
    head, mark, tail = completed.partition("[columns.torque_Nm]")
    Path("map.toml").write_text(head + mark + tail.replace("sign = -1\n", ""), encoding="utf-8")
    assert complaint(run_ema("import", "table", data.name, "--map", "map.toml", "-o", "other")) == refusal.strip()


@pytest.mark.slow
def test_the_drives_missing_effects_are_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A constant load, a swing once per turn and friction's bump, which its makers measured, and nothing else."""
    data = lead_screw_folder()
    monkeypatch.chdir(tmp_path)
    (tmp_path / data.name).symlink_to(data)
    _, table, _, diagnose, refit, _, mapped = blocks(DOCUMENT)
    Path("build").mkdir()
    Path("build/map.toml").write_text(blocks(DOCUMENT, "toml")[0], encoding="utf-8")
    assert run_ema(*shlex.split(table)[1:]).code == 0
    ran = run_ema(*shlex.split(diagnose)[1:], "--json", "found.json")
    assert ran.code == 0, ran.err
    assert missing_from(blocks(DOCUMENT, "text")[2], ran.out) == ""
    found = json.loads(Path("found.json").read_text(encoding="utf-8"))
    assert (found["verdict"], found["method"]) == ("missing", "balance")
    accepted = [one["class"] for one in found["effects"] if one["accepted"]]
    assert len(accepted) == 3
    for wanted in ("constant_load", "cogging_torque", "stribeck_friction"):
        assert any(wanted in alike for alike in accepted), wanted
    assert found["error"]["holdout_after"] < 0.6 * found["error"]["holdout_before"]
    assert run_ema("compare", "build/drive/found.toml", "build/drive/start_stop_50.csv").code == 0
    for command in (*refit.strip().splitlines(), mapped.strip()):
        ran = run_ema(*shlex.split(command)[1:], "--json", "refit.json", "--force")
        assert ran.code == 0, ran.err
    pairs = json.loads(Path("refit.json").read_text(encoding="utf-8"))["both_ways"]
    least = min(pairs, key=lambda one: one["friction_Nm"])
    assert 4.0 < least["speed_rad_s"] < 6.5 and 1.05 < pairs[0]["friction_Nm"] / least["friction_Nm"] < 1.15


def test_the_tables_name_every_entry_and_nothing_else() -> None:
    said = set(re.findall(r"`(\w+)`", TEXT[TEXT.index("## Entries of the map") :]))
    known = {*COLUMN_KEYS, *NUMBERS, *QUANTITIES, *WORDS, *COLUMNS, "time_s", *(one.name for one in fields(Stated))}
    assert known <= said
    assert said - known <= {"true"}
    for name in (*DELIMITERS, *DECIMALS):
        assert f'`"{name}"`' in TEXT
