"""The flight's guarded verdict at the desk: the example firmware on a machine without hardware, its record read out, and the same table give the same bits."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from ema_tools.base.errors import InputError
from ema_tools.data.actuator import reference_actuator
from ema_tools.library.definitions import library_folder
from ema_tools.plant.native import FINDINGS, VERDICTS, Identification, SearchSettings, library
from ema_tools.plant.signatures_header import read_signatures
from support import EXPORTED, REFERENCE, ROOT, run_ema

EXAMPLE = ROOT / "examples" / "firmware"
HEADER = EXPORTED / "ace_signatures.h"
# The firmware's record is what it was fed, in counts: its values are what the session saw.
PROGRAM = """
#include "ace.c"
#include "ident/ema_record_row.h"
#include <stdio.h>

int main(void)
{
    static ace_report_t report;
    const ace_limits_t limits = {.slice_steps = 200U, .slice_us = 1000000U, .tick_late_us = 1000000U};
    ace_run(&limits, &report);
    const ema_record_t* const record = &ace.guarded.session.record;
    for (uint32_t row = 0; row < record->count; ++row) {
        printf("row %.9g %.9g %.9g\\n", (double)ema_command_at(&ace.chirp, row),
               (double)ema_record_value(record, row, (uint32_t)record->place[EMA_CHANNEL_POSITION]),
               (double)ema_record_value(record, row, (uint32_t)record->place[EMA_CHANNEL_CURRENT]));
    }
    const ema_result_t* const result = &report.result;
    const ema_finding_t* const finding = &report.finding;
    for (uint32_t i = 0; i < result->identified_count; ++i) {
        printf("real %a\\nreal %a\\nreal %a\\n", (double)result->identified[i].estimate, (double)result->identified[i].std,
               (double)result->identified[i].shift_percent);
    }
    printf("real %a\\nreal %a\\nreal %a\\n", (double)result->objective_before, (double)result->objective_after,
           (double)result->residual_rms_mm);
    printf("real %a\\nreal %a\\nreal %a\\nreal %a\\n", (double)finding->score, (double)finding->limit, (double)finding->size,
           (double)finding->energy);
    printf("real %a\\nreal %a\\n", (double)finding->moved[0], (double)finding->moved[1]);
    printf("whole %u %llu %llu %d %d %u\\n", (unsigned)result->evaluations, (unsigned long long)result->model_steps,
           (unsigned long long)result->random.state, (int)result->verdict, (int)result->adequate, (unsigned)result->reasons);
    printf("found %d %s %s\\n", (int)finding->kind, ema_effect_name(finding->effect), ema_effect_name(finding->runner_up));
    return 0;
}
"""
MACHINES = {
    "worn": (),
    "hidden": ("-DACE_PLANT_CSJ_NM=0.138f", "-DACE_PLANT_BLK_MM=0.033f", "-DACE_PLANT_DEAD_TIME_V=0.3f"),
}


@dataclass(frozen=True)
class Flight:
    """The firmware's record, command, position and current [rows, 3], and what it made of it."""

    rows: np.ndarray
    reals: list[float]
    whole: list[int]
    found: list[str]


@pytest.fixture(scope="module", params=MACHINES)
def flight(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Flight:
    """One flight of the example firmware."""
    compiler = os.environ.get("CC") or shutil.which("cc") or shutil.which("gcc")
    archive = library_folder() / "libema.a"
    if not compiler or not archive.is_file():
        pytest.skip("no C compiler, or libema.a is not built: build the project")
    folder = tmp_path_factory.mktemp("flight")
    (folder / "main.c").write_text(PROGRAM, encoding="utf-8")
    template = ROOT / "port" / "template"
    places = [f"-I{place}" for place in (ROOT / "include", ROOT / "src", EXAMPLE, EXPORTED, template)]
    sources = ["main.c", str(template / "ace_board.c"), str(template / "ace_plant.c"), str(archive), "-lm"]
    flags = ["-std=c11", "-O2", "-ffp-contract=off", *MACHINES[request.param]]
    subprocess.run([compiler, *flags, *places, *sources, "-o", "main"], cwd=folder, check=True)
    lines = subprocess.run([folder / "main"], capture_output=True, text=True, check=True).stdout.splitlines()
    words = [line.split() for line in lines]

    def those(kind: str) -> list[list[str]]:
        return [line[1:] for line in words if line[0] == kind]

    return Flight(
        np.array(those("row"), dtype=np.float64),
        [float.fromhex(line[0]) for line in those("real")],
        [int(word) for word in those("whole")[0]],
        those("found")[0],
    )


def _channels(flight: Flight) -> np.ndarray:
    channels = np.full((len(flight.rows), 4), np.nan)
    channels[:, 0], channels[:, 2] = flight.rows[:, 1], flight.rows[:, 2]
    return channels


def _reals(answer: Identification) -> list[float]:
    finding = answer.finding
    assert finding is not None
    reals = [number for one in answer.identified for number in (one.estimate, one.std, one.shift_percent)]
    reals += [answer.objective_before, answer.objective_after, answer.residual_rms_mm]
    return [*reals, finding.score, finding.limit, finding.size, finding.energy, *finding.moved]


def test_the_desk_gives_the_bits_of_the_flight(flight: Flight) -> None:
    values, options = reference_actuator().arrays()
    table = read_signatures(HEADER)
    answer = library(32).identify(values, options, flight.rows[:, 0], _channels(flight), SearchSettings(slice_steps=313), None, table)
    assert _reals(answer) == flight.reals
    evaluations, steps, random, verdict, adequate, _ = flight.whole
    assert (answer.evaluations, answer.model_steps, answer.random_state) == (evaluations, steps, random)
    assert (answer.verdict, answer.adequate) == (VERDICTS[verdict], bool(adequate))
    finding = answer.finding
    assert finding is not None
    assert (finding.kind, finding.effect or "none", finding.runner_up or "none") == (FINDINGS[int(flight.found[0])], *flight.found[1:])


def test_the_command_says_what_the_flight_said(flight: Flight, tmp_path: Path) -> None:
    path = tmp_path / "flight.csv"
    rows = [f"{place / 1000:.3f},{row[0]:.9g},{row[1]:.9g},{row[2]:.9g}" for place, row in enumerate(flight.rows)]
    path.write_text("\n".join(["time_s,command_mm,position_mm,current_A", *rows]) + "\n", encoding="utf-8")
    ran = run_ema("identify", REFERENCE, path, "--table", HEADER, "--json", tmp_path / "out.json")
    assert ran.code == 0, ran.err
    found = json.loads((tmp_path / "out.json").read_text())
    assert [found[key]["estimate"] for key in ("csj_Nm", "blk_mm")] == [flight.reals[0], flight.reals[3]]
    assert found["verdict"] == VERDICTS[flight.whole[3]]
    assert found["table"]["kind"] == FINDINGS[int(flight.found[0])]
    assert found["guard"] is None
    assert ("missing is inverter dead time (inverter_dead_time; size" in ran.out) == (found["table"]["kind"] == "missing")
    if found["table"]["kind"] == "missing":
        assert any("table of signatures" in reason for reason in found["reasons"])


@pytest.mark.parametrize(
    ("old", "new", "part"),
    [
        ("/* bins */", "/* bin */", "no bins"),
        ("U, /* patterns */", "1U, /* patterns */", "counts do not fit"),
        ("/* stribeck_friction */", "/* cogging_torque */", "another list of effects"),
        ("/* screw.csj_Nm */", "/* screw.blk_mm */", "another list of parameters"),
        ("static const int16_t ema_exported_values[] = {", "static const int16_t other[] = {", "no static const int16_t"),
        ("    {0, 5, 1, true,", "    {0, 5, 1, maybe,", "is no row"),
    ],
)
def test_a_header_that_is_none_is_refused(old: str, new: str, part: str, tmp_path: Path) -> None:
    text = HEADER.read_text()
    assert old in text
    path = tmp_path / "table.h"
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(InputError, match=r"table\.h") as error:
        read_signatures(path)
    assert part in str(error.value)
    assert "\n" not in str(error.value)


def test_a_table_of_another_machine_is_refused() -> None:
    record = np.zeros(200)
    values, options = reference_actuator().changed({"motor.resistance_ohm": 1.1}).arrays()
    with pytest.raises(InputError, match="belongs to another actuator"):
        library(32).identify(values, options, record, np.zeros((200, 4)), None, None, read_signatures(HEADER))
