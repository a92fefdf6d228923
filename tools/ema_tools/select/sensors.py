"""Whether what is unknown looks like one sensor's own error: a reading that is off by a constant, by a factor, or late, while every other signal is as it should be."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ema_tools.fit.evidence import Evidence, settled

_LEAST_SHARE = 0.9  # so much of the excess must be one sensor's for it to be suspected: physics shows in more than one signal [judgement]
_TOLD_SHARE = 0.02  # a part of the error is told when it alone stands for so much of the excess [judgement]


@dataclass(frozen=True)
class Suspect:
    """A sensor that explains `share` of the excess and leaves `cost`: it reads `factor` times the signal plus `offset` (in the signal's unit), `late_s` late. Parts that hardly matter are 1, 0, 0."""

    channel: str
    share: float
    cost: float
    factor: float
    offset: float
    late_s: float


def suspect(evidence: Evidence) -> Suspect | None:
    """The sensor whose error explains what the model leaves; None where none does, or where there are no other signals to hold it against."""
    if len(evidence.channels) < 2:
        return None
    here = settled(evidence, {})
    excess = here.cost - evidence.expected_cost()
    if not excess > 0.0:
        return None
    best: Suspect | None = None
    for place, channel in enumerate(evidence.channels):
        signal = here.base[place]
        kinds = np.array([np.ones_like(signal), signal, -np.gradient(signal, evidence.record.period_s)])
        columns = []
        for kind in kinds:
            alone = np.zeros_like(here.base)
            alone[place] = kind
            columns.append(here.projected(alone))
        tall = np.column_stack(columns)
        sizes, *_ = np.linalg.lstsq(tall, here.residual, rcond=None)
        share = float(here.residual @ (tall @ sizes)) / excess
        if share < _LEAST_SHARE or (best is not None and share <= best.share):
            continue
        told = [float(np.sum((column * size) ** 2)) > _TOLD_SHARE * excess for column, size in zip(columns, sizes, strict=True)]
        offset, gain, late_s = (float(size) if tell else 0.0 for size, tell in zip(sizes, told, strict=True))
        best = Suspect(channel, min(share, 1.0), here.cost - share * excess, 1.0 + gain, offset, late_s) if any(told) else best
    return best
