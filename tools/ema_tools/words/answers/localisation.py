"""Where a model fails, as a part of a result."""

from __future__ import annotations

from ema_tools.compare.comparison import UNITS, ErrorPart
from ema_tools.compare.localisation import Block, Channel, Where
from ema_tools.compare.readings import ReadingError
from ema_tools.results import localisation as result
from ema_tools.results.parts import Place
from ema_tools.select.sensors import Suspect
from ema_tools.words.sentences.comparison import place_name
from ema_tools.words.sentences.localisation import sentence
from ema_tools.words.sentences.sensors import is_outside_mechanics, reading_sentence, reading_words

# Terms of a balance that are listed.
_TERMS = 5


def localisation(found: Where, sensor: Suspect | None = None) -> result.Localisation:
    """All of it; `sensor`: whose own error explains it, where one does."""
    return result.Localisation(
        found.relative,
        sentence(found, sensor),
        tuple(map(_block, found.blocks)),
        tuple(map(_signal, found.channels)),
        tuple(map(_place, found.places)),
        found.pictures,
        _reading(found.reading) if found.reading is not None else None,
    )


def _reading(one: ReadingError) -> result.ReadingEntry:
    words, said = reading_words(one), f"{reading_sentence(one)}."
    return result.ReadingEntry(
        one.channel, one.kind, one.size, one.periods, 100.0 * one.share, one.balances, is_outside_mechanics(one), words, said
    )


def _block(block: Block) -> result.BlockEntry:
    terms = tuple(result.TermEntry(term.words, 100.0 * block.of_excess(term), term.coefficient) for term in block.terms[:_TERMS])
    return result.BlockEntry(
        block.name,
        block.unit,
        block.rms,
        block.floor_rms,
        block.relative_percent,
        100.0 * block.share,
        block.telling,
        terms,
        block.reason or None,
    )


def _signal(one: Channel) -> result.SignalErrorEntry:
    return result.SignalErrorEntry(one.name, UNITS[one.name], one.rms, one.floor_rms, 100.0 * one.share)


def _place(place: ErrorPart) -> Place:
    return Place(place_name(place), 100.0 * place.share, place.time_share, place.source, place.by, place.part)
