"""The whole search of effects on a record: as `ema diagnose` makes it, and what it says beside healthy records where none that was fitted beside CSJ and BLK alone explains one."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field

from ema_tools.base.progress import Report, untold
from ema_tools.fit.confounded import confounded_with
from ema_tools.fit.evidence import FAR, FAR_ROUNDS, Evidence, settled
from ema_tools.fit.misfit import misfit
from ema_tools.fit.nuisance import ASKED, are_slight
from ema_tools.fit.refit import seen_from
from ema_tools.library.faults import FAULTS, effect_of
from ema_tools.library.registry import record_of
from ema_tools.select.baseline import granting, with_noise_of
from ema_tools.select.outcome import Diagnosis, Named
from ema_tools.select.search import diagnose
from ema_tools.select.sensors import Suspect, suspect
from ema_tools.select.strategies.strategy import LEAST_LIMIT

_SUPPLY_ROUNDS = 3  # of the search with the voltage that was given, as each finds it [effort]
_OTHER_SUPPLY = 7.5  # standard deviations of a day's supply at which a cause of another one is more probable [chance]


def diagnosed(evidence: Evidence, report: Report = untold, only: Collection[str] | None = None) -> tuple[Evidence, Diagnosis]:
    """The search among all effects and faults, or `only` these, and the evidence that it rests on.

    Without baseline records one effect is sought first: if it leaves more than white noise, the search goes on with the noise that the residual shows. An effect that comes out as slight as on every
    machine is left free then, and the search goes once more.
    """
    if evidence.relative:
        return _on_its_supply(evidence, diagnose(evidence, report, only), report, only)
    found = diagnose(evidence, lambda share, text: report(0.4 * share, text), only, 1)
    tried = found.rounds[0].fits
    fitted = seen_from(tried[0]) if tried else settled(evidence, {}, rounds=FAR_ROUNDS, reach=FAR)
    leaves_more = misfit(fitted.cost, evidence.floor, evidence.numbers) > 0.0
    if leaves_more or fitted.at_edge:
        evidence = with_noise_of(fitted) if leaves_more and len(evidence.channels) > 1 else evidence
        found = diagnose(evidence, lambda share, text: report(0.4 + 0.6 * share, text), only)
    fit = found.fit
    if fit is None:
        return evidence, found
    slight = [effect for effect in fit.effects if evidence.released(effect) and are_slight(evidence.actuator, fit.of_effect(effect))]
    if not slight:
        return evidence, found
    evidence = granting(evidence, slight)
    return evidence, diagnose(evidence, report, only)


def _on_its_supply(evidence: Evidence, found: Diagnosis, report: Report, only: Collection[str] | None) -> tuple[Evidence, Diagnosis]:
    """The same, or where the recorded voltage seems to be asked of a supply that gives another one than on any day, the search with the voltage that was given, if that names the supply besides."""
    must = {*map(effect_of, confounded_with("drive.supply_V")), *(one.name for one in found.named if one.accepted)}
    least = _OTHER_SUPPLY
    for _ in range(_SUPPLY_ROUNDS):
        beyond, std = _beyond_its_supply(evidence, found)
        if abs(beyond) < least:
            break
        given = evidence.on_supply((1.0 + evidence.supplied) * (1.0 + beyond * std) - 1.0)
        again = diagnose(given, report, only)
        if not must <= {one.name for one in again.named if one.accepted}:
            break
        evidence, found, least = given, again, 1.0
    return evidence, found


def _beyond_its_supply(evidence: Evidence, found: Diagnosis) -> tuple[float, float]:
    """By how many standard deviations the supply of which the voltage was asked is another one than on the baseline records' days, beside what was found; and one of these, relative."""
    place = next((place for place, one in enumerate(evidence.varies) if one.cause == ASKED), None)
    if place is None or "voltage_V" not in evidence.channels:
        return 0.0, 0.0
    deviations = found.fit.deviations() if found.fit is not None else settled(evidence, {}).best_deviations(reach=FAR)
    return float(deviations[len(evidence.spread) + place]), evidence.varies[place].std


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
