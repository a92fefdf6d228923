"""An actuator and a record as the page's workbench takes them."""

from __future__ import annotations

import base64
import math
from collections.abc import Sequence

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.data.actuator import Actuator, row_of
from ema_tools.data.records import Record
from ema_tools.design.typical import typical_change
from ema_tools.fit.evidence import Evidence, slope_step
from ema_tools.fit.nuisance import ASKED, GAIN_SHARE, Spread
from ema_tools.fit.whitening import counted
from ema_tools.library.definitions import load_definitions
from ema_tools.library.faults import FAULTS
from ema_tools.results.workbench import BenchEntry, SpreadEntry, WeighedEntry
from ema_tools.tasks.export import header_text

# Longer records are left out: the page would grow beyond what a browser opens at once [layout]
_ROWS_MAX = 60_000


def bench(actuator: Actuator, record: Record, evidence: Evidence | None = None) -> BenchEntry | None:
    """The workbench's part of a result; None for a very long record, and for an actuator whose controller is not known, which cannot be simulated.

    `evidence`: by which a diagnosis weighs the record; the page's errors are then those of the diagnosis.
    """
    if record.rows > _ROWS_MAX or actuator.absent:
        return None
    usual: dict[str, float] = {}
    for effect in load_definitions().physical:
        usual |= typical_change(actuator, effect.name, _peak_current_A(actuator, record)) or {}
    return BenchEntry(
        # what the page makes of it is no calibration on those runs any more
        actuator=actuator.changed({}).written_text(),
        actuator_file=actuator.file or "actuator.toml",
        header=header_text(actuator),
        record_file=record.file,
        start_s=record.first_time_s,
        period_s=record.period_s,
        columns={name: _packed(record.recorded(name)) for name in record.present},
        usual=usual,
        weighed=_weighed(evidence) if evidence is not None else None,
    )


def _weighed(evidence: Evidence) -> WeighedEntry:
    target, weights = (
        {name: _packed(values) for name, values in zip(evidence.channels, of, strict=True)}
        for of in (evidence.target, evidence.whiten.weights)
    )
    zeros, gains = {}, {}
    # of the model as it stands, what a sensor's gain adds is no constant
    for signals in evidence.additive[len(evidence.varies) : len(evidence.additive) - len(evidence.slight)]:
        place = int(np.argmax(np.max(np.abs(signals), axis=1)))
        name = evidence.channels[place]
        if np.ptp(signals[place]) > 0.0:
            gains[name] = GAIN_SHARE[name]
        else:
            zeros[name] = float(signals[place, 0])
    # the recorded voltage alone is where the page has what it is asked of
    asked = next((one for one in evidence.varies if one.cause == ASKED), None)
    if asked is not None and "voltage_V" in evidence.channels:
        gains["voltage_V"] = asked.std
    varies = [one for one in evidence.varies if one.cause != ASKED]
    unit = evidence.unit
    return WeighedEntry(
        rows=counted(evidence.record.rows),
        target=target,
        weights=weights,
        # beside baseline records CSJ and BLK are sought: they have no prior
        spread=tuple(
            SpreadEntry(names=one.names, std=_whole_std(one, evidence.spread), relative=one.relative)
            for one in evidence.spread
            if not (one.cause or (evidence.relative and one.title in FAULTS.values()))
        ),
        zeros=zeros,
        gains=gains,
        unit={} if unit is None else {name: unit[row_of(name).name] for one in evidence.spread for name in one.names},
        slight=(
            *(one.changes(evidence.actuator, slope_step(one)) for one in varies),
            *(dict(changes) for changes in evidence.slight),
        ),
        sizes=(*map(slope_step, varies), *(1.0 for _ in evidence.slight)),
    )


def _whole_std(one: Spread, spread: Sequence[Spread]) -> float:
    """Standard deviation of a value with what causes that move several make of it."""
    by_causes = [
        share * other.std
        for other in spread
        if other.cause
        for name, share in zip(other.names, other.shares, strict=True)
        if name == one.title
    ]
    return math.hypot(one.std, *by_causes)


def _packed(values: Reals) -> str:
    return base64.b64encode(np.asarray(values, dtype="<f4").tobytes()).decode("ascii")


def _peak_current_A(actuator: Actuator, record: Record) -> float:
    """The largest current of the record; where it was not recorded, the most that the supply drives through the winding."""
    if record.current_A is not None:
        return float(np.max(np.abs(record.current_A)))
    return actuator["drive.supply_V"] / actuator["motor.resistance_ohm"]
