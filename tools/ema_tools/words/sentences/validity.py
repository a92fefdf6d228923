"""Whether a record can answer, in words."""

from __future__ import annotations

from ema_tools.compare.validity import RecordValidity


def sentence(gate: RecordValidity) -> str:
    """The judgement in one sentence."""
    blocking = [remark for remark in gate.remarks if remark.severity == "blocks"]
    if blocking:
        return f"This record cannot answer: {blocking[0].text}."
    weak = [remark for remark in gate.remarks if remark.severity == "weakens"]
    if weak:
        return f"This record can answer, with {len(weak)} reservation{'s' if len(weak) > 1 else ''}: {'; '.join(remark.text for remark in weak)}."
    return "This record can answer: signals, clock, saturation and coverage are in order."
