"""What to do next, by a result and the command that made it: one source for the terminal, the page and `next` of the JSON result."""

from __future__ import annotations

import shlex
from dataclasses import replace
from typing import TypeVar

from ema_tools.results.addition import Addition
from ema_tools.results.calibration import CalibrationResult
from ema_tools.results.comparison import ComparisonResult
from ema_tools.results.diagnosis import DiagnosisByBalanceResult, DiagnosisResult
from ema_tools.results.friction_map import MapResult
from ema_tools.results.identification import IdentificationResult
from ema_tools.words.page.results import shown
from ema_tools.words.page.several_page import own_answers
from ema_tools.words.page.sheet import Reply, line_of
from ema_tools.words.sentences.paths import with_paths

_Advised = Addition | ComparisonResult | DiagnosisResult | DiagnosisByBalanceResult | IdentificationResult | MapResult
_Stored = Addition | CalibrationResult | ComparisonResult | DiagnosisResult | DiagnosisByBalanceResult | IdentificationResult
Found = TypeVar("Found", bound=_Stored)

# Names of records that are still to be made.
_TO_BE_MADE = frozenset({"RECORD.csv", "NEXT.csv", "MORE.csv", "healthy_*.csv", "ACTUATOR.toml"})


def reply_to(found: _Advised | CalibrationResult) -> Reply:
    """The advice, as on the result's page; a calibrated model is compared with the first record that it was fitted to."""
    if isinstance(found, CalibrationResult):
        tokens = shlex.split(found.provenance.get("command", ""))
        record = next((token for token in tokens[3:] if token.endswith((".csv", ".mat", ".parquet"))), "RECORD.csv")
        return Reply("What next?", "See how well it holds", "", "", shlex.join(["ema", "compare", found.actuator, record]))
    return own_answers(shown(found, found.command, found.name or "")).replies[-1]


def sentence(reply: Reply) -> str:
    """The printed line."""
    return f"Next: {reply.short[:1].lower()}{reply.short[1:]}: {reply.command}"


def with_next(found: Found) -> Found:
    """The result with the argument lists of the advised commands, none where a record must be made first; of a diagnosis the sentences name the same command."""
    reply = reply_to(found)
    arguments = tuple(shlex.split(reply.command))
    runs = bool(arguments) and not _TO_BE_MADE & set(arguments)
    if isinstance(found, DiagnosisResult | DiagnosisByBalanceResult):
        line = line_of(found.provenance.get("command", ""))
        told = (
            with_paths(found.sentence, line.actuator, line.records, line.options.get("--healthy", ()))
            if line is not None
            else found.sentence
        )
        found = replace(found, sentence=told, next_experiment=sentence(reply) if reply.command else found.next_experiment)
    return replace(found, next=(arguments,) if runs else ())
