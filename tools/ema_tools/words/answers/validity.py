"""The judgement of a record, as a part of a result."""

from __future__ import annotations

from ema_tools.compare.validity import HIDES, RecordValidity
from ema_tools.results.validity import Remark, SignalEntry, Validity
from ema_tools.words.sentences.validity import sentence

# Of a signal beside which another one serves as well.
_NOT_NEEDED = "nothing that another motion or drive in the record does not show"


def validity(gate: RecordValidity) -> Validity:
    """All of it."""
    return Validity(
        gate.answerable,
        sentence(gate),
        {name: SignalEntry(there, None if there else HIDES.get(name, _NOT_NEEDED)) for name, there in gate.signals.items()},
        tuple(Remark(one.topic, one.severity, one.text, one.next or None) for one in gate.remarks),
        dict(gate.coverage),
    )
