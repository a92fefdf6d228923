"""Spoilt records: no confident wrong answer, plain records stay decided, and docs/FAULTS.md is what this build gives."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks import faults
from ema_tools.data.records import read_record
from host_program import PROGRAM

pytestmark = PROGRAM


def test_some_faults_of_every_kind_that_is_quick() -> None:
    quick = [fault for fault in faults.FAULTS if fault.quick]
    assert len({fault.kind for fault in quick}) >= 9
    rows = faults.table(quick, noises_mm=(faults.NOISE_MM,))
    assert len(rows) == len(quick) * len(faults.MACHINES)
    assert [row for row in rows if not row.good] == []
    shown = faults.DOCUMENT.read_text(encoding="utf-8").splitlines()
    for row in rows:
        place = 2 + 2 * faults.MACHINES.index(row.machine) + 1
        line = next(line for line in shown if line.startswith(f"| {row.fault.kind} | {row.fault.strength} |"))
        assert line.strip("| ").split(" | ")[place] == faults.outcome(row), line


@pytest.mark.release
def test_document_is_what_this_build_gives() -> None:
    rows = faults.table()
    assert [row for row in rows if not row.good] == []
    assert faults.DOCUMENT.read_text(encoding="utf-8") == faults.document(rows)


def test_every_fault_changes_the_file() -> None:
    record = read_record(faults.ROOT / "recordings" / "healthy.csv")
    for fault in faults.FAULTS:
        random = np.random.Generator(np.random.PCG64(1))
        sheet = faults.sheet_of(record, 0.0, random)
        assert (fault.spoil(sheet, record, random).text() == sheet.text()) == (fault.kind == "none"), fault


def test_confident_wrong_answer_is_a_failure() -> None:
    machine, fault = faults.MACHINES[1], next(fault for fault in faults.FAULTS if not fault.decided)
    right = faults.Row(fault, machine, 0.0, None, "fault", (), (117.4, 25.0), (0.2, 2.0))
    assert right.right and right.good
    for wrong in (
        replace(right, verdict="healthy"),
        replace(right, shift_percent=(117.4, 30.5)),
        replace(right, shift_percent=(115.0, 25.0)),
    ):
        assert not wrong.good and faults.outcome(wrong) == "**wrong**"
    assert not replace(right, verdict="undecided").good
    assert replace(right, verdict="undecided", reasons=("a shift cannot be told",)).good
    plain = replace(right, fault=faults.FAULTS[0], verdict="undecided", reasons=("a shift cannot be told",))
    assert not plain.good
