"""Whether what is unknown looks like one sensor's own error: a reading that is off by a constant, by a factor, or late, or in any other way, while every other signal is as it should be."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ema_tools.compare.readings import LEAST_SHARE
from ema_tools.fit.evidence import Evidence, settled
from ema_tools.select.known_machine import KnownMachine, MachineFit

_TOLD_SHARE = 0.02  # a part of the error is told when it alone stands for so much of the excess [judgement]
_FEWEST = 3  # of which two are left to agree with each other [judgement]
VOLTAGE = "voltage_V"
CLOCK = "time_s"
_EVENLY = 0.3  # correlation of neighbours beyond which what is late is no jitter: a delay that changes [judgement]


@dataclass(frozen=True)
class Suspect:
    """A sensor that explains `share` of the excess and leaves `cost`: it reads `factor` times the signal plus `offset` (in the signal's unit), `late_s` late. Parts that hardly matter are 1, 0, 0;
    where all are, what it reads is none of these, and shows in no other signal."""

    channel: str
    share: float
    cost: float
    factor: float
    offset: float
    late_s: float

    @property
    def has_form(self) -> bool:
        """Whether it is a factor, an offset or a delay."""
        return (self.factor, self.offset, self.late_s) != (1.0, 0.0, 0.0)


def suspect(evidence: Evidence) -> Suspect | None:
    """The sensor whose error explains most of what the model leaves; None where none does, or where there are no other signals to hold it against."""
    # what varies from run to run would take a part of it
    return _most_telling(evidence.of_known or evidence, LEAST_SHARE)


def likelier_sensor(evidence: Evidence, cost: float) -> Suspect | None:
    """The sensor whose error leaves less of a record than `cost`, beside all that varies; None where none does."""
    found = _most_telling(evidence, 0.0)
    if found is None or found.cost >= cost:
        return None
    sized = _most_telling(evidence.of_known or evidence, 0.0)
    return replace(sized, share=found.share, cost=found.cost) if sized is not None and sized.channel == found.channel else found


def _most_telling(evidence: Evidence, least: float) -> Suspect | None:
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
        if share < least or (best is not None and share <= best.share):
            continue
        told = [float(np.sum((column * size) ** 2)) > _TOLD_SHARE * excess for column, size in zip(columns, sizes, strict=True)]
        offset, gain, late_s = (float(size) if tell else 0.0 for size, tell in zip(sizes, told, strict=True))
        best = Suspect(channel, min(share, 1.0), here.cost - share * excess, 1.0 + gain, offset, late_s) if any(told) else best
    return best


def odd_signal(evidence: Evidence) -> Suspect | None:
    """The one signal without which the others are those of the machine that healthy records show, with CSJ and BLK of today, or the recorder's clock; None where there is none, or more than one."""
    if not evidence.relative or len(evidence.channels) < _FEWEST:
        return None
    known = KnownMachine(evidence)
    base_of_all = known.base({})
    whole = base_of_all.cost - known.floor
    found = []
    for channel in evidence.channels:
        others = KnownMachine(evidence.without(channel))
        base = others.base({})
        if others.plain(base):
            found.append(Suspect(channel, 1.0 - max(base.cost - others.floor, 0.0) / whole, base.cost, 1.0, 0.0, 0.0))
    return found[0] if len(found) == 1 else _jitter(known, base_of_all)


def without_voltage(evidence: Evidence) -> Evidence | None:
    """The other signals beside healthy runs, where they are enough to be asked without the voltage: a drive may record what it asks of a supply that gives less."""
    enough = evidence.relative and VOLTAGE in evidence.channels and len(evidence.channels) > _FEWEST
    return evidence.without(VOLTAGE) if enough else None


def _jitter(known: KnownMachine, base: MachineFit) -> Suspect | None:
    """The recorder's clock, where every row is early or late by some time of its own that is the same in all signals; `late_s` is its rms."""
    evidence = known.evidence
    run = known.signals(base.values)
    weights = 1.0 / np.sqrt(np.mean(evidence.noise, axis=1, keepdims=True))
    left, slope = weights * (evidence.target - run), weights * -np.gradient(run, evidence.record.period_s, axis=1)
    steep = np.sum(slope**2, axis=0)
    late_s = np.sum(slope * left, axis=0) / np.maximum(steep, 1e-12 * float(np.max(steep)))
    # a time for each row takes off the noise of one signal, whatever is there
    explained = float(np.sum(steep * late_s**2)) - late_s.size
    excess = float(np.sum(left**2)) - left.size
    beside = np.sqrt(steep[1:] * steep[:-1])
    alike = float(np.sum(beside * late_s[1:] * late_s[:-1]) / np.sum(beside * late_s[1:] ** 2))
    share = explained / excess if excess > 0.0 else 0.0
    if share < LEAST_SHARE or abs(alike) > _EVENLY:
        return None
    return Suspect(CLOCK, min(share, 1.0), known.floor, 1.0, 0.0, float(np.sqrt(explained / np.sum(steep))))
