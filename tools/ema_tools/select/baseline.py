"""Evidence from records: against healthy repeats of the same command where there are any, else against the model alone.

With repeats the model is first brought to the healthy machine: its parameters are fitted to the mean of the repeats, and standing effects that this mean shows are
put in. The record is then compared with that mean, so that what the model still lacks, which is in both, drops out. Noise is estimated per channel and frequency from how
the repeats differ, after the share that a scatter of the machine's own parameters explains (friction, grease, winding) has been taken off. Without repeats the
record is compared with the model itself, and the parameters are free within what a data sheet leaves open.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.base.errors import InputError
from ema_tools.base.noise import resolution, white_noise
from ema_tools.base.parallel import each
from ema_tools.base.progress import Report
from ema_tools.data.actuator import Actuator
from ema_tools.data.records import Record, start_of
from ema_tools.fit import nuisance as spreads
from ema_tools.fit.evidence import FAR, FAR_ROUNDS, Evidence, View, directions_of, measured_channels, settled, simulate_channels
from ema_tools.fit.whitening import Whitener, counted, incoherent_power, least_noise, lines_of, noise_between
from ema_tools.plant.native import CHANNELS
from ema_tools.select.run_to_run import days_of, freed, without_days
from ema_tools.select.search import standing_effects

# An effect that is just beyond what counts as slight here may come out just within it where it is refitted, and then nobody would hold what it does [chance]
_SLIGHT_MARGIN = 1.25


def common_channels(records: Sequence[Record]) -> tuple[str, ...]:
    """Signals that every record has."""
    return tuple(name for name in CHANNELS if all(record.channel(name) is not None for record in records))


def same_command(record: Record, other: Record) -> bool:
    """Whether two records run the same command."""
    return other.rows == record.rows and bool(np.allclose(other.command_mm, record.command_mm, atol=1e-6))


# Days differ by a factor of three at most from one another (benchmark's machines), one that is faulty by dozens; of three records, the median may be anything's neighbour [measured]
_ODD, _ODD_OF_THREE = 8.0, 24.0


def _check_repeats(actuator: Actuator, record: Record, healthy: Sequence[Record]) -> None:
    for other in healthy:
        if not same_command(record, other):
            raise InputError(f"{other.file}: command_mm: not the command of {record.file}: give healthy records of the same command")
    if len(healthy) < 2:
        raise InputError(
            f"{healthy[0].file}: one healthy record tells nothing of repeatability: record another under the same command and give both, or none"
        )
    check_none_odd(actuator, healthy)


def check_none_odd(actuator: Actuator, healthy: Sequence[Record]) -> None:
    """Raises InputError, naming the file, where one of several records of one command lies far from all others, whatever the days of the machine `actuator` may have been."""
    channels = common_channels(healthy)
    runs = np.array([measured_channels(one, channels) for one in healthy])
    beyond = runs - np.median(runs, axis=0)
    most = _ODD if len(healthy) > 3 else _ODD_OF_THREE
    apart = _far_of(beyond)
    if np.max(apart) > most:
        noise = np.maximum([white_noise(signal) for signal in runs[0]], least_noise(runs[0]))
        days = days_of(actuator, healthy[0], channels, start_of(actuator, healthy[0]))
        apart = _far_of(np.array([without_days(one, days, noise) for one in beyond]))
    odd = int(np.argmax(apart))
    if apart[odd] > most:
        raise InputError(
            f"{healthy[odd].file}: {apart[odd]:.3g} times as far from the healthy records' median as the others are: leave it out, or diagnose it by itself"
        )


def _far_of(beyond: Reals) -> Reals:
    """How far each record lies from the others, [records], as a multiple of the usual distance, in the signal where that is most, by what it differs from all [records, channels, rows]; two
    records are alike far."""
    far = np.sqrt(np.mean(beyond**2, axis=2))
    usual = np.median(far, axis=0)
    return np.asarray(np.max(np.divide(far, usual, out=np.ones_like(far), where=usual > 0.0), axis=1))


def _zeros_of_sensors(channels: Sequence[str], signals: Reals) -> Reals:
    """Constants [k, channels, rows], one for each signal [channels, rows] whose sensor may have a zero of its own."""
    found = []
    for place, name in enumerate(channels):
        if name in spreads.OFFSET_CHANNELS:
            constant = np.zeros_like(signals)
            constant[place] = spreads.OFFSET_SHARE * float(np.sqrt(np.mean(signals[place] ** 2)))
            found.append(constant)
    return np.array(found).reshape(-1, *signals.shape)


def _gains_of_sensors(channels: Sequence[str], signals: Reals) -> Reals:
    """Signals [k, channels, rows], one for each of the model's `signals` [channels, rows] whose sensor may be off by a factor; of the recorded ones the noise would shrink with the factor."""
    found = []
    for place, name in enumerate(channels):
        if name in spreads.GAIN_SHARE:
            share = np.zeros_like(signals)
            share[place] = spreads.GAIN_SHARE[name] * signals[place]
            found.append(share)
    return np.array(found).reshape(-1, *signals.shape)


def _slight_effects(
    actuator: Actuator, record: Record, channels: tuple[str, ...], start_mm: float, wanted: Sequence[Mapping[str, float]]
) -> Reals:
    """What the effects that every machine has a little of make of the signals, [k, channels, rows]."""
    here = simulate_channels(actuator, record, channels, start_mm)
    found = each(lambda changes: simulate_channels(actuator.changed(changes), record, channels, start_mm) - here, wanted)
    return np.array(found).reshape(-1, *here.shape)


def _effect_of(changes: Mapping[str, float]) -> str:
    return next(iter(changes)).split(".")[1]


def _still_slight(wanted: Sequence[Mapping[str, float]], deviations: Reals) -> list[Mapping[str, float]]:
    """Those whose effects are as slight as on every machine by their `deviations` [k], or a little more: a larger one is to be named, not taken for granted."""
    effects = [_effect_of(changes) for changes in wanted]
    size = {effect: np.hypot.reduce([at for name, at in zip(effects, deviations, strict=True) if name == effect]) for effect in effects}
    return [changes for changes, effect in zip(wanted, effects, strict=True) if size[effect] <= _SLIGHT_MARGIN * spreads.SLIGHT_REACH]


def healthy_model(
    actuator: Actuator, record: Record, mean: Reals, power: Reals, channels: tuple[str, ...], report: Report | None = None
) -> Actuator:
    """The actuator fitted to the mean [channels, rows] of healthy repeats, whose noise power by line is `power`, with the standing effects that it shows."""
    start = start_of(actuator, record)
    found = Evidence(
        actuator,
        record,
        channels,
        mean,
        spreads.of_healthy_machine(actuator, channels),
        Whitener.of(power, record.rows),
        power,
        _zeros_of_sensors(channels, mean),
        start,
    )
    standing = standing_effects(found, report)
    deviations = standing.deviations() if standing is not None else settled(found, {}).deviations
    effects = dict(standing.values) if standing is not None else {}
    return actuator.changed({**effects, **spreads.moved(actuator, found.spread, deviations)})


def _mean_and_level(healthy: Sequence[Record], channels: tuple[str, ...]) -> tuple[Reals, Reals, Reals]:
    """Runs [count, channels, rows], their mean [channels, rows], and how much they differ from it, rms, [channels]."""
    runs = np.array([measured_channels(other, channels) for other in healthy])
    mean = runs.mean(axis=0)
    return runs, mean, np.maximum(np.sqrt(np.mean((runs - mean) ** 2, axis=(0, 2))), least_noise(mean))


def against_known(known: Actuator, record: Record, healthy: Sequence[Record], channels: tuple[str, ...]) -> Evidence:
    """Evidence of a record against healthy repeats of its command, of a machine that the model knows."""
    runs, mean, level = _mean_and_level(healthy, channels)
    count = len(healthy)
    deviations = runs - mean
    least = least_noise(mean)
    start = start_of(known, record)
    usual = spreads.from_run_to_run(known)
    here, directions = directions_of(known, record, channels, start, usual)
    shares = np.linalg.lstsq(
        (directions / level[:, None]).reshape(len(usual), here.size).T, (deviations / level[:, None]).reshape(count, -1).T, rcond=None
    )[0]
    widths = spreads.widths_shown(known, usual, np.asarray(shares, dtype=np.float64))
    left = deviations - np.einsum("kr,kcn->rcn", shares, directions)
    power = noise_between(left, least)
    widen = 1.0 + 1.0 / count
    spread = tuple(replace(one, std=one.std * float(width) * float(np.sqrt(widen))) for one, width in zip(usual, widths, strict=True))
    # a repeat against the mean of the others scatters a little more than the record against the mean of them all
    shrink = np.sqrt(widen / (1.0 + 1.0 / (count - 1)))
    repeats = tuple(here + (runs[k] - np.delete(runs, k, axis=0).mean(axis=0)) * shrink for k in range(count))
    target = here + measured_channels(record, channels) - mean
    whiten = Whitener.of(widen * power, record.rows)
    return Evidence(
        known,
        record,
        channels,
        target,
        spread,
        whiten,
        power,
        np.empty((0, *target.shape)),
        start,
        repeats,
        counting=_counting(np.array([resolution(record.recorded(name)) for name in channels]), power, whiten),
        freedom=spreads.USUAL_WEIGHT + count - 1.0,
    )


def _counting(steps: Reals, power: Reals, whiten: Whitener) -> float:
    """What sensors that count in `steps` [channels] add to a record's cost and to no repeat's.

    Repeats go the same way, and where their noise is smaller than a count their counts err alike: that drops out of them, and not out of a record that goes another way, which errs as much again.
    `power` [channels, lines] is what differs among the repeats, sensor noise and what of the counts' errors the noise tells apart; the rest follows from it.
    """
    squares = np.where(steps > 0.0, steps, 1.0) ** 2
    alike = np.where(steps > 0.0, squares * np.interp(power.mean(axis=1) / squares, *_counts_alike()), 0.0)
    return float(np.sum(whiten.weights**2 * (2.0 * alike)[:, None]))


@functools.cache
def _counts_alike() -> tuple[Reals, Reals]:
    """What differs among counts of one way, and what their errors have alike, both variances in squares of a count, rising with the noise, [k]: a rounded value errs as a saw tooth of the true one,
    of whose harmonics Gaussian noise leaves its characteristic function (B. Widrow, I. Kollar, Quantization Noise, 2008, chapter 4)."""
    noise = np.linspace(0.0, 1.0, 201)
    harmonic = np.arange(1.0, 200.5)[:, None]
    alike = np.sum(np.exp(-((2.0 * np.pi * harmonic * noise) ** 2)) / (2.0 * (np.pi * harmonic) ** 2), axis=0)
    return noise**2 + 1.0 / 12.0 - alike, alike


def alone_against_known(evidence: Evidence, known: Actuator, record: Record) -> Evidence:
    """Evidence of a record of another command about the machine `known`, with the noise that was seen in `evidence`."""
    names = evidence.channels
    measured = np.array([record.recorded(name) for name in names])
    lines = lines_of(record.rows)
    place = np.linspace(0.0, 1.0, lines)
    power = np.array([np.interp(place, np.linspace(0.0, 1.0, one.size), one) for one in evidence.noise])
    power = np.maximum(power, least_noise(measured)[:, None] ** 2)
    level = np.array([white_noise(signal) for signal in measured])
    floor = float(np.sum(np.minimum(1.0, (level**2)[:, None] / power))) * counted(record.rows) / lines
    additive = _zeros_of_sensors(names, measured)
    return Evidence(
        known,
        record,
        names,
        measured,
        spreads.from_run_to_run(known),
        Whitener.of(power, record.rows),
        power,
        additive,
        start_of(known, record),
        floor=floor,
    )


def _against_repeats(
    actuator: Actuator, record: Record, healthy: Sequence[Record], channels: tuple[str, ...], report: Report | None
) -> Evidence:
    _, mean, level = _mean_and_level(healthy, channels)
    flat = np.broadcast_to((level**2)[:, None], (len(channels), lines_of(record.rows))) / len(healthy)
    known = healthy_model(actuator, record, mean, flat, channels, report)
    return against_known(known, record, healthy, channels)


def _against_own(actuator: Actuator, record: Record, healthy: Sequence[Record], channels: tuple[str, ...]) -> Evidence:
    """Evidence against the baseline records that the actuator's file names, to which its model without later effects is fitted already."""
    before = actuator.before_baseline()
    evidence = against_known(before, record, healthy, channels)
    if before is actuator:
        return evidence
    # a baseline record with the effects that came later
    with_effects = simulate_channels(actuator, record, channels, evidence.start_mm)
    added = with_effects - simulate_channels(before, record, channels, evidence.start_mm)
    return evidence.of_machine(actuator, added)


def gather(
    actuator: Actuator, record: Record, healthy: Sequence[Record] = (), channels: Sequence[str] | None = None, report: Report | None = None
) -> Evidence:
    """Evidence of a record, against two or more healthy repeats of its command where there are any, in the signals that all have or in `channels`.

    Raises InputError for repeats of another command or too few of them.
    """
    names = tuple(channels) if channels else common_channels([record, *healthy])
    if healthy:
        _check_repeats(actuator, record, healthy)
        if actuator.baseline is not None and actuator.baseline.before is not None and actuator.baseline.covers(healthy):
            return freed(_against_own(actuator, record, healthy, names))
        return freed(_against_repeats(actuator, record, healthy, names, report))
    return _of_data_sheet(actuator, record, names, ())


def granting(evidence: Evidence, effects: Sequence[str]) -> Evidence:
    """Evidence without repeats again, with `effects` granted: a search that had them to name has found them as slight as on every machine."""
    granted = _of_data_sheet(evidence.actuator, evidence.record, evidence.channels, effects)
    return replace(granted, whiten=evidence.whiten, noise=evidence.noise, floor=evidence.floor)


def with_noise_of(fitted: View) -> Evidence:
    """Evidence without baseline records again, with the noise of each signal by frequency as the residual of a fit shows it: sensors' noise need not be white."""
    evidence = fitted.evidence
    rows = evidence.record.rows
    residual = evidence.whiten.signals(fitted.residual[: fitted.residual.size - fitted.deviations.size], rows)
    seen = incoherent_power(residual)
    power = np.maximum(seen, least_noise(evidence.target)[:, None] ** 2)
    floor = float(np.sum(seen / power)) * counted(rows) / lines_of(rows)
    return replace(evidence, whiten=Whitener.of(power, rows), noise=power, floor=floor)


def _of_data_sheet(actuator: Actuator, record: Record, names: tuple[str, ...], granted: Sequence[str]) -> Evidence:
    """Evidence of a unit that is known by its data sheet alone, with the `granted` effects and those that a first look finds slight among what every machine has."""
    measured = measured_channels(record, names)
    start = start_of(actuator, record)
    noise = np.array([white_noise(signal) for signal in measured])
    level = np.maximum(noise, least_noise(measured))
    power = np.broadcast_to((level**2)[:, None], (len(names), lines_of(record.rows)))
    floor = float(np.sum((noise / level) ** 2)) * counted(record.rows)

    def with_slight(unit: Actuator, wanted: Sequence[Mapping[str, float]]) -> Evidence:
        gains = _gains_of_sensors(names, simulate_channels(unit, record, names, start))
        additive = np.concatenate([_zeros_of_sensors(names, measured), gains, _slight_effects(unit, record, names, start, wanted)])
        return Evidence(
            actuator,
            record,
            names,
            measured,
            spreads.of_unit(actuator),
            Whitener.of(power, record.rows),
            power,
            additive,
            start,
            floor=floor,
            slight=tuple(wanted),
            unit=unit,
        )

    # what a slight effect makes hangs on the unit's friction: first as the data sheet has it, then as the record shows it
    slight = [changes for changes in spreads.slight() if _effect_of(changes) not in actuator.active_effects]
    first = with_slight(actuator, slight)
    deviations = settled(first, {}, settled(first, {}).deviations, rounds=FAR_ROUNDS, reach=FAR).deviations
    unit = actuator.changed(spreads.moved(actuator, first.spread, deviations))
    kept = {_effect_of(changes) for changes in _still_slight(slight, deviations[deviations.size - len(slight) :])} | set(granted)
    return with_slight(unit, [changes for changes in slight if _effect_of(changes) in kept])
