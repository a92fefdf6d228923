"""What is left after the best known effects, as a part of a result."""

from __future__ import annotations

from collections.abc import Sequence

from ema_tools.compare.localisation import short
from ema_tools.compare.unexplained import LearnedTable, Ranked, Unknown
from ema_tools.results import unexplained as result
from ema_tools.words.sentences.unexplained import first_sentence, learned_sentence, sentence


def unexplained(unknowns: Sequence[Unknown], table: LearnedTable | None = None) -> result.Unexplained:
    """The unknowns, and the learned effect that could stand for the first."""
    return result.Unexplained(first_sentence(unknowns), tuple(map(_unknown, unknowns)), _learned(table) if table is not None else None)


def _unknown(one: Unknown) -> result.UnknownEntry:
    return result.UnknownEntry(
        one.balance, one.what, one.unit, one.rms, one.floor_rms, sentence(one), tuple(map(_ranked, one.ranked)), one.pictures
    )


def _ranked(one: Ranked) -> result.RankedEntry:
    return result.RankedEntry(one.axis, one.friction, 100.0 * max(0.0, one.explained), 100.0 * one.of_excess)


def _learned(one: LearnedTable) -> result.LearnedEntry:
    return result.LearnedEntry(
        one.effect, one.axis, one.unit, one.first, one.last, short(one.nodes), 100.0 * one.explained, learned_sentence(one)
    )
