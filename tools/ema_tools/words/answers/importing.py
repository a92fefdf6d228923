"""The results of `ema import draft` and `ema import table`."""

from __future__ import annotations

from ema_tools.base.files import readable
from ema_tools.data.tables.draft import Draft
from ema_tools.results.files import DraftResult, ImportedFile, ImportedRecord, SignalSource, TableImportResult
from ema_tools.results.parts import Provenance
from ema_tools.tasks.import_table import TablesImported
from ema_tools.words.sentences.importing import remark_text


def draft(found: Draft, source: str, target: str, provenance: Provenance) -> DraftResult:
    """What was guessed of a file."""
    guessed = {one.target: one.column.name for one in found.guesses if one.target}
    remarks = tuple(f"{one.target}: {one.said}" for one in found.guesses if one.target and one.said)
    return DraftResult(
        "import draft", readable(source), readable(target), guessed, found.open_entries, (*remarks, *found.remarks), provenance
    )


def tables(found: TablesImported, provenance: Provenance) -> TableImportResult:
    """What became of a maker's files."""
    files = tuple(
        ImportedFile(
            readable(one.path),
            tuple(
                ImportedRecord(readable(place), record.rows, record.period_s, record.present)
                for record, place in zip(one.records, places, strict=True)
            ),
            tuple(remark_text(remark) for remark in one.remarks),
        )
        for one, places in zip(found.files, found.places, strict=True)
    )
    stated = ("screw.", "motor.", "gearbox.")
    values = {name: number for name, number in found.actuator.values.items() if name.startswith(stated) and found.actuator.has(name)}
    signals = {name: SignalSource(origin, column) for name, (origin, column) in found.signals.items()}
    remarks = tuple(remark_text(remark) for remark in found.remarks)
    return TableImportResult(
        "import table", found.mapped.file, readable(found.actuator_path), values, found.estimated, files, signals, remarks, provenance
    )
