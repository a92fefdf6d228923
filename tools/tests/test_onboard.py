"""The table of signatures: what is exported names a hidden effect in C as an independent computation does; what does not serve is refused."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks import onboard as benchmark
from ema_tools.base.errors import InputError
from ema_tools.data.actuator import Actuator, reference_actuator
from ema_tools.data.records import Record
from ema_tools.library.definitions import library_folder
from ema_tools.plant.native import SearchSettings
from ema_tools.tasks import signature_table as onboard
from ema_tools.tasks.export import fingerprint, header_text, signatures_text
from ema_tools.tasks.onboard_search import run as run_search
from ema_tools.tasks.signature_table import Signatures, judge, residual_of, signatures
from shared_results import shared_result
from support import ROOT, chirp_record, complaint, run_ema

NOISE = {"position_mm": 0.002, "motor_position_mm": 0.002, "current_A": 0.03, "voltage_V": 0.01}
PROGRAM = """
#include <stdio.h>
#include <stdlib.h>
#include "actuator.h"
#include "signatures.h"
static ema_real rows[6U * 20000U];
/* CSJ and BLK of the known machine, slice, file; prints the print, then what is found */
int main(int count, char** words)
{
    ema_actuator_t known = EMA_ACTUATOR;
    ema_record_config_t config = {.buffer = rows, .buffer_bytes = sizeof rows, .format = EMA_RECORD_REAL, .keep = {true, false, true, false}};
    ema_record_t record;
    static ema_onboard_t onboard;
    ema_finding_t found;
    if (count != 5 || ema_record_init(&record, &config) != EMA_OK) {
        return 2;
    }
    known.params.csj_Nm = (ema_real)atof(words[1]);
    known.params.blk_mm = (ema_real)atof(words[2]);
    FILE* const file = fopen(words[4], "r");
    double one[3];
    while (file && fscanf(file, "%lf %lf %lf", &one[0], &one[1], &one[2]) == 3) {
        const ema_sample_t sample = {(ema_real)one[0], {(ema_real)one[1], 0, (ema_real)one[2], 0}};
        if (ema_record_append(&record, &sample) != EMA_OK) {
            return 3;
        }
    }
    const ema_status_t status = ema_onboard_start(&onboard, &EMA_SIGNATURES, &known, &record, 0);
    printf("%u %d\\n", (unsigned)ema_onboard_fingerprint(&EMA_ACTUATOR), (int)status);
    while (status == EMA_OK && ema_onboard_run(&onboard, (uint32_t)atoi(words[3])) > 0U) { }
    if (status != EMA_OK || ema_onboard_result(&onboard, &found) != EMA_OK) {
        return 4;
    }
    printf("%d %s %s %a %a %a %a %a %a\\n", (int)found.kind, ema_effect_name(found.effect), ema_effect_name(found.runner_up), (double)found.score,
           (double)found.size, (double)found.energy, (double)found.limit, (double)found.moved[0], (double)found.moved[1]);
    return 0;
}
"""
GUARDED = """
#include <stdio.h>
#include "actuator.h"
#include "signatures.h"
#include "ema/ema.h"
static ema_real rows[6U * 20000U];
static ema_guarded_t guarded;
int main(int count, char** words)
{
    ema_record_config_t record = {.buffer = rows, .buffer_bytes = sizeof rows, .format = EMA_RECORD_REAL, .keep = {true, false, true, false}};
    ema_session_config_t config;
    ema_result_t result;
    ema_finding_t found;
    FILE* const file = (count == 2) ? fopen(words[1], "r") : NULL;
    double one[3];
    if (!file || ema_session_config_default(&config, &EMA_ACTUATOR, &record) != EMA_OK || ema_guarded_init(&guarded, &config, &EMA_SIGNATURES) != EMA_OK) {
        return 2;
    }
    while (fscanf(file, "%lf %lf %lf", &one[0], &one[1], &one[2]) == 3) {
        const ema_sample_t sample = {(ema_real)one[0], {(ema_real)one[1], 0, (ema_real)one[2], 0}};
        if (ema_guarded_feed(&guarded, &sample) != EMA_OK) {
            return 3;
        }
    }
    while (ema_guarded_phase(&guarded) != EMA_GUARDED_DONE) {
        if (ema_guarded_run(&guarded, 200U) != EMA_OK) {
            return 4;
        }
    }
    if (ema_guarded_result(&guarded, &result, &found) != EMA_OK) {
        return 5;
    }
    printf("%d %u %u %s %.9g %.9g %.9g %.9g\\n", (int)result.verdict, (unsigned)result.reasons, (unsigned)result.evaluations, ema_effect_name(found.effect),
           (double)result.identified[0].estimate, (double)result.identified[1].estimate, (double)result.identified[0].std, (double)result.identified[1].std);
    return 0;
}
"""
KINDS = ("adequate", "missing", "unknown", "none")


def _record(actuator: Actuator, seed: int, seconds: float = 10.0) -> Record:
    return chirp_record(actuator, f"chirp:duration_s={seconds:g}", 32).with_noise(NOISE, seed)


@pytest.fixture(scope="module")
@shared_result
def table() -> Signatures:
    """Of the reference actuator, with three healthy runs whose friction scatters."""
    healthy = [
        _record(reference_actuator().changed({"screw.csj_Nm": 0.138 * (1.0 + 0.004 * step)}), 10 + k)
        for k, step in enumerate((-1.0, 0.3, 0.8))
    ]
    return signatures(reference_actuator(), healthy)


def _built(folder: Path, table: Signatures, source: str) -> Path:
    """A program with the module and the exported headers; the test is skipped where nothing builds it."""
    compiler = os.environ.get("CC") or shutil.which("cc") or shutil.which("gcc")
    archive = library_folder() / "libema.a"
    if not compiler or not archive.is_file():
        pytest.skip("no C compiler, or libema.a is not built: build the project")
    (folder / "actuator.h").write_text(header_text(table.actuator), encoding="utf-8")
    (folder / "signatures.h").write_text(signatures_text(table), encoding="utf-8")
    (folder / "main.c").write_text(source, encoding="utf-8")
    flags = ["-std=c11", "-pedantic-errors", "-Wall", "-Wextra", "-Wdouble-promotion", "-Werror"]
    subprocess.run([compiler, *flags, f"-I{ROOT / 'include'}", "main.c", str(archive), "-lm", "-o", "main"], cwd=folder, check=True)
    return folder


def _run(folder: Path, record: Record, *words: str) -> list[list[str]]:
    np.savetxt(folder / "record.txt", np.column_stack([record.command_mm, record.position_mm, record.recorded("current_A")]), fmt="%.9g")
    done = subprocess.run([folder / "main", *words, "record.txt"], cwd=folder, capture_output=True, text=True, check=False)
    return [line.split() for line in done.stdout.splitlines()]


@pytest.fixture(scope="module")
def program(table: Signatures, tmp_path_factory: pytest.TempPathFactory) -> Callable[..., list[list[str]]]:
    """Runs the module with the exported table on a record."""
    folder = _built(tmp_path_factory.mktemp("onboard"), table, PROGRAM)

    def run(record: Record, known: Actuator, steps: int = 200) -> list[list[str]]:
        return _run(folder, record, f"{known['screw.csj_Nm']:.9g}", f"{known['screw.blk_mm']:.9g}", str(steps))

    return run


HIDDEN = {
    "nothing": {},
    "inertia_change": {"inertia_change.change": 0.1},
    "supply_sag": {"supply_sag.sag": 0.04},
    "pitch_ripple": {"pitch_ripple.ratio": 0.05, "pitch_ripple.phase_rad": 1.0},
    "sensor_offset": {"sensor_offset.offset_mm": -0.02},
    "spring_load": {"spring_load.stiffness_Nm_per_mm": 0.004},
    "csj": {"screw.csj_Nm": 0.16},
}


@pytest.mark.parametrize("hidden", HIDDEN)
def test_module_and_desk_say_the_same(hidden: str, table: Signatures, program: Callable[..., list[list[str]]]) -> None:
    record = _record(reference_actuator().changed(HIDDEN[hidden]), 99)
    known = table.actuator.changed(HIDDEN[hidden]) if hidden == "csj" else table.actuator
    desk = judge(table, residual_of(table, record, known), known)
    (printed, status), found = program(record, known)
    assert int(printed) == fingerprint(table.actuator)
    assert int(status) == 0
    assert KINDS[int(found[0])] == desk.kind == ("adequate" if hidden in ("nothing", "csj") else "missing")
    if desk.kind == "missing":
        assert found[1] == desk.scored[0].effect == hidden
        assert found[2] == desk.scored[1].effect
        assert float.fromhex(found[4]) == pytest.approx(next(iter(HIDDEN[hidden].values())), rel=0.15)
    values = [float.fromhex(word) for word in found[3:]]
    expected = [desk.scored[0].score, desk.scored[0].size, desk.energy, desk.limit, desk.moved["csj"], desk.moved["blk"]]
    assert values == pytest.approx(expected, rel=5e-3, abs=0.05)


def test_slices_do_not_matter(table: Signatures, program: Callable[..., list[list[str]]]) -> None:
    record = _record(reference_actuator().changed(HIDDEN["pitch_ripple"]), 5)
    assert program(record, table.actuator, 1) == program(record, table.actuator, 977) == program(record, table.actuator, 100_000)


def test_another_command_says_nothing(table: Signatures, program: Callable[..., list[list[str]]]) -> None:
    record = _record(reference_actuator(), 7)
    shifted = record.with_columns({"command_mm": record.command_mm + 0.02})
    cut = replace(record, **{name: record.recorded(name)[:-1] for name in record.present})
    assert [program(other, table.actuator)[1][0] for other in (record, shifted, cut)] == ["0", "3", "3"]


def test_shifts_start_the_search(table: Signatures) -> None:
    record = _record(reference_actuator().changed({"screw.csj_Nm": 0.145, "screw.blk_mm": 0.05}), 3)
    moved = judge(table, residual_of(table, record)).moved
    assert moved["csj"] == pytest.approx(0.007, rel=0.25)
    assert moved["blk"] == pytest.approx(0.017, rel=0.25)


def test_session_behind_the_table(table: Signatures, tmp_path: Path) -> None:
    """A fault is found as without the table, by the two runs beside it and one at the healthy values; beside an effect it is taken back, and the effect is named."""
    folder = _built(tmp_path, table, GUARDED)
    worn = {"screw.csj_Nm": 0.16, "screw.blk_mm": 0.05}
    record = _record(reference_actuator().changed(worn), 21)
    plain = run_search(reference_actuator(), record, SearchSettings(), 32)
    ((verdict, reasons, runs, _, *values),) = _run(folder, record)
    assert (verdict, reasons, plain.verdict) == ("1", "0", "fault")
    assert int(runs) <= plain.evaluations + 3
    for value, estimate in zip(values, plain.identified, strict=False):
        assert float(value) == pytest.approx(estimate.estimate, abs=0.2 * estimate.std)
    ((verdict, reasons, _, effect, *_),) = _run(folder, _record(reference_actuator().changed({**worn, "inertia_change.change": 0.1}), 22))
    assert verdict == "2"
    assert int(reasons) & 256
    assert effect == "inertia_change"


@pytest.mark.slow
def test_benchmark_counts(table: Signatures) -> None:
    """The document's figures, from three records whose answers are known."""
    healthy = tuple(_record(reference_actuator(), 40 + k) for k in range(3))
    kept = [benchmark.Kept("healthy", "", "", _record(reference_actuator(), 50))]
    kept += [
        benchmark.Kept("effect", "inertia_change", "medium", _record(reference_actuator().changed({"inertia_change.change": 0.1}), 51))
    ]
    kept += [benchmark.Kept("effect", "supply_sag", "large", _record(reference_actuator().changed({"inertia_change.change": 0.1}), 52))]
    row = benchmark.naming([benchmark.Known(reference_actuator(), healthy, tuple(kept))], onboard.SIGNALS, 25.0)
    assert row[3:] == ["0 of 0, 0 among three", "1 of 1, 1 among three", "0 of 1, 0 among three", "0 of 1"]
    answers = [benchmark.guarded(table, one) for one in kept]
    assert benchmark.verdicts(answers[:1])[0] == "| nothing | 1 | 1 | 0 | 0 |  |"
    assert benchmark.verdicts(answers)[3].endswith("| 1 | 1 |")
    block = benchmark.placed(f"a\n{benchmark.BEGIN}\nold\n{benchmark.END}\nb", f"{benchmark.BEGIN}\nnew\n{benchmark.END}")
    assert block == f"a\n{benchmark.BEGIN}\nnew\n{benchmark.END}\nb"
    with pytest.raises(InputError, match="no place for the figures"):
        benchmark.placed("a", "b")


def test_rows_are_of_length_one_and_free_of_faults(table: Signatures) -> None:
    """A pattern's rows meet neither CSJ nor BLK, whatever their size; with the scatter's share they would have length one."""
    lengths = np.linalg.norm(table.rows.reshape(len(table.rows), -1), axis=1)
    assert np.all(lengths < 1.0 + 1e-9)
    assert np.all(lengths > 0.1)
    moved = residual_of(table, _record(reference_actuator().changed({"screw.blk_mm": 0.04}), 1))
    still = residual_of(table, _record(reference_actuator(), 1))
    white = (moved - still) * table.weight[:, None]
    products = np.einsum("kcb,cb->k", table.rows, white)
    effects = products[table.nuisances : table.nuisances + sum(one.rows for one in table.patterns)]
    blk = products[table.faults[1].row]
    assert abs(blk) > 20.0 * np.max(np.abs(effects))


def test_a_machine_that_is_its_model_is_not_warned_of(table: Signatures) -> None:
    assert table.warning is None
    assert max(table.misfit.values()) < 2.0
    assert table.summary().warning is None


@pytest.mark.slow
def test_table_keeps_to_its_size() -> None:
    actuator = reference_actuator()
    healthy = [_record(actuator, k, 40.0) for k in range(2)]
    made = signatures(actuator, healthy)
    assert onboard.TABLE_BYTES_MAX / 2 < 2 * made.numbers <= onboard.TABLE_BYTES_MAX
    assert made.bin_rows > 40


def test_runs_that_do_not_serve_are_refused(table: Signatures) -> None:
    actuator = reference_actuator()
    one, other = _record(actuator, 1), _record(actuator, 2)
    with pytest.raises(InputError, match="1 healthy record tells nothing"):
        signatures(actuator, [one])
    with pytest.raises(InputError, match="not the command of"):
        signatures(actuator, [one, other.with_columns({"command_mm": other.command_mm * 1.1})])
    with pytest.raises(InputError, match="current_A: not recorded"):
        signatures(actuator, [one, replace(other, current_A=None)])
    with pytest.raises(InputError, match="--signals curent_A: unknown signal"):
        signatures(actuator, [one, other], ("curent_A",))


def test_export_writes_the_table(tmp_path: Path) -> None:
    story = ROOT / "recordings" / "story"
    actuator = ROOT / "actuators" / "reference.toml"
    healthy = [word for k in (1, 2, 3) for word in ("--healthy", story / f"healthy_{k}.csv")]
    ran = run_ema("export", actuator, "-o", tmp_path / "a.h", "--signatures", tmp_path / "s.h", "--json", tmp_path / "e.json", *healthy)
    assert ran.code == 0, ran.err
    assert "KiB of signatures in position_mm, current_A" in ran.out
    told = json.loads((tmp_path / "e.json").read_text(encoding="utf-8"))["table"]
    # a data sheet is no calibrated machine
    assert min(told["misfit"].values()) > 15.0
    assert ran.err == f"ema: {told['warning']}\n"
    assert told["warning"].startswith("--signatures: current_A: reference.toml misses the healthy records by 2")
    assert "static const ema_signatures_t EMA_SIGNATURES" in (tmp_path / "s.h").read_text(encoding="utf-8")
    again = run_ema("export", actuator, "-o", tmp_path / "b.h", "--signatures", tmp_path / "s.h", *healthy)
    assert complaint(again).endswith("s.h: exists already: choose another name or give --force")
    assert not (tmp_path / "b.h").exists()
    assert "two or more" in complaint(run_ema("export", actuator, "-o", tmp_path / "c.h", "--signatures", tmp_path / "t.h"))
    assert run_ema("export", actuator, "-o", tmp_path / "c.h", *healthy).code == 2
