"""What the whole search of effects says of a record beside healthy ones, where none that was fitted beside CSJ and BLK alone explains it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from ema_tools.fit.evidence import Evidence
from ema_tools.library.faults import FAULTS
from ema_tools.library.registry import record_of
from ema_tools.select.outcome import Named
from ema_tools.select.search import diagnose
from ema_tools.select.sensors import Suspect, suspect
from ema_tools.select.strategies.strategy import LEAST_LIMIT


@dataclass(frozen=True)
class WholeSearch:
    """The one effect that is missing, with CSJ and BLK beside it, by name, where they changed; or the sensor whose own error it looks like; neither where more than one effect is missing or
    none explains it."""

    effect: Named | None = None
    faults: Mapping[str, float] = field(default_factory=dict)
    sensor: Suspect | None = None


def _less_than_none(one: Named) -> bool:
    """Whether a bend of the law of friction is negative: it stands for a law in another form."""
    return record_of(one.name).adds and next(iter(one.values.values())) < 0.0


def searched(unit: Evidence) -> WholeSearch:
    """The search on evidence that healthy records stand behind."""
    found, sensor = diagnose(unit), suspect(unit)
    explains = found.verdict == "missing" and found.fit is not None
    if sensor is not None and not (explains and sensor.cost >= found.cost_after - LEAST_LIMIT):
        return WholeSearch(sensor=sensor)
    effects = [one for one in found.named if one.accepted and one.name not in FAULTS]
    if not explains or found.fit is None or len(effects) != 1 or _less_than_none(effects[0]):
        return WholeSearch()
    return WholeSearch(effects[0], {name: found.fit.values[name] for name in FAULTS.values() if name in found.fit.values})
