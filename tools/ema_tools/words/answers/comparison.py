"""The result of `ema compare`."""

from __future__ import annotations

from ema_tools.compare.comparison import UNITS, BalanceError, Comparison, ErrorPart
from ema_tools.results import comparison as result
from ema_tools.results.parts import CurvesEntry, ErrorsEntry, Place, Provenance
from ema_tools.tasks.model_error import ModelError
from ema_tools.words.sentences.comparison import place_name, sentence


def comparison(
    found: Comparison, provenance: Provenance, curves: CurvesEntry | None = None, error: ModelError | None = None
) -> result.ComparisonResult:
    """What was found on the record; `error`: of the model on it, None where nothing can be simulated."""
    return result.ComparisonResult(
        name=found.record,
        channels={
            name: result.ChannelErrorEntry(error.rmse, error.relative_percent, UNITS[name]) for name, error in found.channels.items()
        },
        balances={name: _balance(error) for name, error in found.balances.items()},
        where=tuple(map(_place, found.where)),
        sentence=sentence(found, error),
        error=error_entry(error),
        today=None if error is None else dict(error.today),
        unlocated_event_steps=found.simulation.unlocated_event_steps if found.simulation is not None else 0,
        provenance=provenance,
        curves=curves,
    )


def error_entry(error: ModelError | None) -> ErrorsEntry | None:
    """The weighted error as a result holds it."""
    return None if error is None else ErrorsEntry(error.given, error.fitted, error.noise_level)


def _balance(error: BalanceError) -> result.BalanceErrorEntry:
    if error.reason:
        return result.BalanceErrorEntry(None, None, error.unit, reason=error.reason)
    return result.BalanceErrorEntry(
        error.rms, error.relative_percent, error.unit, error.noise_rms, error.method_rms, error.resting_percent, error.excess_percent
    )


def _place(place: ErrorPart) -> Place:
    return Place(place_name(place), 100.0 * place.share, place.time_share, place.source, place.by, place.part, place.share)
