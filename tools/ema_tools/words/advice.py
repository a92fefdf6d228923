"""What to do next, by a result alone: one source for the terminal, the page and `next` of the JSON result.

The commands form a graph that ends: compare -> diagnose -> add -> diagnose or identify, and identify -> add where an effect is missing. Each `add` writes a new model; nothing else leads
back. An end is a verdict, or one reason with what to record.
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeVar

from ema_tools.library.display_names import listed, within
from ema_tools.library.registry import separable
from ema_tools.plant.native import REASONS
from ema_tools.results.addition import Addition
from ema_tools.results.calibration import CalibrationResult
from ema_tools.results.comparison import ComparisonResult
from ema_tools.results.diagnosis import DiagnosisByBalanceResult, DiagnosisResult
from ema_tools.results.friction_map import MapResult
from ema_tools.results.identification import IdentificationResult
from ema_tools.results.parts import together
from ema_tools.words.command_line import CommandLine, line_of, new_file, new_model
from ema_tools.words.sentences.paths import with_paths

Advised = Addition | CalibrationResult | ComparisonResult | DiagnosisResult | DiagnosisByBalanceResult | IdentificationResult | MapResult
_Stored = Addition | CalibrationResult | ComparisonResult | DiagnosisResult | DiagnosisByBalanceResult | IdentificationResult
Found = TypeVar("Found", bound=_Stored)

# Names of records that are still to be made, and of files that nobody gave.
_TO_BE_MADE = frozenset({"RECORD.csv", "NEXT.csv", "MORE.csv", "healthy_*.csv", "ACTUATOR.toml"})
# Beginning of a reason that says nothing of the model.
UNUSABLE = "nothing can be told from this record"

# What to do about a reason for an undecided verdict, by the module's bit.
_FOR_REASON = {
    1: "Let the session run to its end before reading its verdict.",
    2: "Run `ema compare` on this record: it says in which block, at which frequency and speed the error sits.",
    4: "Widen the bounds in the [search] table and run again.",
    8: "Raise evaluation_budget in the [search] table and run again.",
    16: "Record more chirps: four halve the standard error.",
    32: "Record the reference chirp instead of this command.",
    64: "Calibrate the healthy values again, on a record of this very actuator.",
    128: "Use the command that the table was learned from, or learn it from records that reach as far as this one.",
    256: "Run `ema diagnose` on this record with healthy ones: it says how sure the name is, and what stands beside it.",
    512: "Run the ground test that the table was exported for, or export one for this command.",
    1024: "Run the ground test again, without a sample missed.",
}


@dataclass(frozen=True)
class Advice:
    """What to do in a few words, why, how it is meant (a `Reply`'s tone), and the command as an argument list; none where nothing is to be run."""

    short: str
    more: str = ""
    tone: str = ""
    arguments: tuple[str, ...] = ()

    @property
    def command(self) -> str:
        """The command as it is typed."""
        return shlex.join(self.arguments)

    @property
    def runs(self) -> bool:
        """Whether there is a command whose files all exist already."""
        return bool(self.arguments) and not _TO_BE_MADE & set(self.arguments)

    @property
    def reason(self) -> str:
        """What to do and why, without a stop at the end."""
        repeats = self.more.casefold().startswith(self.short.casefold())
        return (self.more if repeats else ": ".join(filter(None, (self.short, self.more)))).rstrip(".")

    @property
    def printed(self) -> str:
        """The line on the terminal."""
        if not self.arguments:
            return f"Next: {self.reason[:1].lower()}{self.reason[1:]}."
        return f"Next: {self.short[:1].lower()}{self.short[1:]}: {self.command}"


def with_next(found: Found) -> Found:
    """The result with the argument lists of the advised commands, none where a record must be made first; of a diagnosis the sentences name the same command."""
    advice = advice_of(found)
    if isinstance(found, DiagnosisResult | DiagnosisByBalanceResult):
        line = _line(found)
        told = with_paths(found.sentence, line.actuator, line.records, line.options.get("--healthy", ()))
        found = replace(
            found, sentence=told, next_experiment=advice.printed if advice.arguments else found.next_experiment or advice.printed
        )
    return replace(found, next=(advice.arguments,) if advice.runs else ())


def advice_of(found: Advised) -> Advice:
    """The advice after any result."""
    if isinstance(found, Addition):
        return after_addition(found)
    if isinstance(found, ComparisonResult):
        return after_comparison(found)
    if isinstance(found, IdentificationResult):
        return after_identification(found)
    if isinstance(found, MapResult):
        return after_map(found)
    if isinstance(found, CalibrationResult):
        return after_calibration(found)
    return after_diagnosis(found)


def advice_for_reason(reason: str) -> str:
    """What to do about one of the module's reasons for an undecided verdict; empty when nothing is known."""
    return next((text for bit, text in _FOR_REASON.items() if REASONS[bit] == reason), "")


def _line(found: Advised) -> CommandLine:
    return line_of(found.provenance.get("command", "")) or CommandLine("ACTUATOR.toml", ("RECORD.csv",), {})


def _ema(*words: str, more: Iterable[str] = ()) -> tuple[str, ...]:
    return ("ema", *words, *more)


def _record(line: CommandLine) -> str:
    return line.records[0] if line.records else "RECORD.csv"


def read_sizes(actuator: str, line: CommandLine, *options: str) -> Advice:
    """To identify CSJ and BLK, where the model holds."""
    arguments = _ema("identify", actuator, _record(line), more=line.again(*options))
    return Advice("Read CSJ and BLK", "friction and backlash with intervals, as the actuator reads them", "", arguments)


def after_comparison(found: ComparisonResult) -> Advice:
    """Identify where the model explains the record, else diagnose."""
    line = _line(found)
    if found.explained and found.channels:
        return read_sizes(line.actuator, line, "--healthy")
    if found.explained:
        return Advice("Nothing: the model explains the record", "a record of another motion would try it further", "good")
    arguments = _ema("diagnose", line.actuator, _record(line), more=line.again("--healthy"))
    return Advice("Ask what is missing", "with healthy records of the machine behind --healthy, where there are any", "", arguments)


def after_calibration(found: CalibrationResult) -> Advice:
    """Compare the calibrated model with the first record that it was fitted to."""
    tokens = shlex.split(found.provenance.get("command", ""))
    record = next((token for token in tokens[3:] if token.endswith((".csv", ".mat", ".parquet"))), "RECORD.csv")
    return Advice("See how well it holds", "", "", _ema("compare", found.actuator, record))


def after_map(found: MapResult) -> Advice:
    """Diagnose where the model is off at some speed, else calibrate."""
    line = line_of(found.provenance.get("command", "")) or CommandLine(found.actuator, tuple(found.records), {})
    if any(point.outside for point in found.points):
        arguments = _ema("diagnose", line.actuator, *line.records, "--method", "balance")
        return Advice("Ask what is missing", "by the balance of forces, over all these records", "", arguments)
    return Advice(
        "Take the values over",
        "into the model of this machine",
        "",
        _ema("calibrate", line.actuator, *line.records, "-o", "calibrated.toml"),
    )


def after_addition(found: Addition) -> Advice:
    """Identify with the new model where it leaves no more than noise, else diagnose with it again."""
    line = _line(found)
    if found.recommended is False:
        reason = found.reason or "it is not recommended"
        if "--known" in shlex.split(found.provenance.get("command", "")):
            arguments = _ema("diagnose", line.actuator, _record(line), more=line.again("--holdout"))
            return Advice("Ask what else could be missing", f"this effect is not kept: {reason}", "unsure", arguments)
        return Advice("Do not keep it", reason, "unsure")
    by_balance = found.method == "balance"
    if found.error.explained and not by_balance:
        # the new file names its baseline records
        return read_sizes(found.actuator, line)
    records = line.records or ("RECORD.csv",)
    arguments = _ema("diagnose", found.actuator, *(records if by_balance else records[:1]), more=line.again("--holdout"))
    return Advice("Diagnose with it again", "until nothing is missing", "", arguments)


def after_diagnosis(found: DiagnosisResult | DiagnosisByBalanceResult) -> Advice:
    """Identify where nothing is missing, add what is, or say what would decide."""
    line, by_balance = _line(found), isinstance(found, DiagnosisByBalanceResult)
    healthy, record = line.again("--healthy"), _record(line)
    if not found.gate.answerable:
        wanted = next((remark.next for remark in found.gate.remarks if remark.severity == "blocks" and remark.next), "")
        return Advice("Record again", wanted, "unsure")
    if found.verdict == "adequate":
        if not by_balance and found.error.leaves_much:
            told = "something that is in no effect of the library stands beside it, and sizes may be off for that (--report draws what is left)"
            return Advice("Look at the pictures", told, "unsure")
        if not by_balance:
            return read_sizes(line.actuator, line, "--healthy")
        return Advice("Nothing is to be added", found.next_experiment.removeprefix("Next: "), "good")
    left_out = next((remark for remark in found.gate.remarks if remark.topic == "asked voltage"), None)
    if left_out is not None and found.verdict == "missing":
        told = "call its column terminal_voltage_V where it is measured at the motor, else take it out, and diagnose again: as what the controller asks for it contradicts all other signals"
        return Advice("Decide on the voltage", told, "unsure")
    between = together(found.effects, found.rivals)
    if found.verdict == "missing" and not by_balance and separable(between):
        told = f"{listed([within(name) for name in between])} explain this record equally well"
        return Advice("Record what separates them", told, "unsure", _ema("next", line.actuator, "--between", *between))
    accepted = [effect.name for effect in found.effects if effect.accepted]
    if found.verdict == "missing" and accepted:
        fitted = line.options.get("--fitted")
        if fitted:
            records = line.records if by_balance else (record,)
            # the new file names its baseline records; by the balance it has today's effects, which the healthy records lack
            again = _ema("diagnose", fitted[0], *records, more=line.again("--holdout"))
            if found.error.explained and not by_balance:
                return read_sizes(fitted[0], line)
            return Advice("Diagnose with the new model", "", "", again)
        if by_balance and healthy:
            # ema add fits to the records of today alone
            again = _ema("diagnose", line.actuator, *line.records, *healthy, *line.again("--holdout"))
            return Advice("Put it into the model", "then diagnose again", "", (*again, "--fitted", new_model(record, accepted)))
        if by_balance or accepted[0].startswith("learned_"):
            del accepted[1:]
        return Advice("Put it into the model", "then diagnose again", "", _added(line, accepted))
    if isinstance(found, DiagnosisResult) and found.sensor is not None:
        return Advice("Check the sensor", found.sensor.next, "unsure")
    learned = found.unknown.learned if found.unknown is not None else None
    if learned is not None and (not found.next_experiment or "ema add" in found.next_experiment):
        arguments = _ema("add", line.actuator, learned.effect, "--fit", record, *healthy, "-o", new_model(record, [learned.effect]))
        return Advice("Put it in as a learned table", "or write the effect where its physics is known", "", arguments)
    wanted = found.next_experiment.removeprefix("Next: ")
    pictures = "look at the pictures (--report), and "
    if wanted and not wanted.startswith(pictures) and not by_balance:
        return Advice("Record again", wanted, "unsure")
    if isinstance(found, DiagnosisResult) and found.mode == "without healthy repeats":
        told = "beside runs of the same command on the healthy machine, best five, which take off what it always has"
        return Advice("Ask again", told, "unsure", _ema("diagnose", line.actuator, record, "--healthy", "healthy_*.csv"))
    return Advice("Look at the pictures", wanted.replace(pictures, "then "), "unsure")


def _added(line: CommandLine, effects: Sequence[str]) -> tuple[str, ...]:
    records = line.records or ("RECORD.csv",)
    files = [word for record in records for word in ("--fit", record)]
    options = line.again("--healthy", "--holdout")
    return _ema("add", line.actuator, *effects, *files, *options, "-o", new_model(records[0], effects))


def after_identification(found: IdentificationResult) -> Advice:
    """Follow a verdict, put a missing effect in, or say what to record."""
    line = _line(found)
    guard, effect, record = found.guard, found.missing_effect, _record(line)
    healthy = line.again("--healthy")
    objection = guard.objection if guard is not None else None
    diagnose = _ema("diagnose", line.actuator, record, *healthy)
    if found.verdict != "undecided":
        return _put_in((found.sentence,), found, record) or _follow(found, line)
    unusable = next((reason for reason in found.reasons if reason.startswith(UNUSABLE)), "")
    if unusable:
        return Advice("Record again", unusable, "unsure")
    # with its own values free the model explains the record: a diagnosis would find nothing missing
    explained = found.error is not None and bool(found.error.explained)
    if effect is not None and effect.name is not None and not (explained and found.baseline is None):
        if objection == "rival":
            told = f"this record does not tell {within(effect.name)} from a fault"
            return Advice("Record what tells them apart", told, "unsure", _ema("next", line.actuator, "--between", "csj", effect.name))
        told = "the model has the effect and the healthy records lack it, and with that counted there is no verdict either"
        again = _ema("identify", line.actuator, "NEXT.csv", more=healthy)
        return _put_in(found.reasons, found, record) or Advice("Record today's machine again", told, "unsure", again)
    if found.sensor is not None:
        return Advice("Check the sensor", "scale, zero and delay; then record again", "unsure", diagnose)
    if objection == "signals":
        again = _ema("identify", line.actuator, "NEXT.csv", more=healthy)
        return Advice("Check the sensors and record again", "the rod position and the other signals contradict each other", "unsure", again)
    if (objection == "unknown" or (guard is None and not found.adequate)) and not explained:
        return Advice("Ask what is missing", "it looks at every signal", "", diagnose)
    if objection in ("open", "healthy") or explained:
        # those there are and the new ones: the same command would say the same again
        more = [*healthy, "MORE.csv"] if healthy else ["--healthy", "healthy_*.csv"]
        again = _ema("identify", line.actuator, record, *more)
        return Advice("Record more healthy runs", "on days that differ, and ask again beside them", "unsure", again)
    advice = next((told for reason in found.reasons if (told := advice_for_reason(reason))), "").replace("`", "")
    if not found.adequate:
        return Advice("Ask what is missing", advice, "", diagnose)
    # the same command on the same record would say the same again
    again = _ema("identify", line.actuator, "NEXT.csv", *(healthy or ["--healthy", "healthy_*.csv"]))
    return Advice("Record again, and ask", advice, "unsure", again)


def _put_in(told: Sequence[str], found: IdentificationResult, record: str) -> Advice | None:
    """The command that puts a missing effect into the model, where one of the sentences has it, with a file name next to the record."""
    command = next((match[0] for sentence in told if (match := re.search(r"ema add .+?(?= puts it in)", sentence))), "")
    if not command or found.missing_effect is None:
        return None
    written = new_model(record, [found.missing_effect.name or "effect"])
    arguments = tuple(written if word == "NEW.toml" else word for word in shlex.split(command))
    short = "Put it into the model" if found.verdict == "undecided" else "Put the effect into the model"
    return Advice(short, "then identify again with the new file", "", arguments)


def _follow(found: IdentificationResult, line: CommandLine) -> Advice:
    """What follows a verdict: its doubts first, then the unit over its dates."""
    record, healthy = _record(line), line.again("--healthy")
    if found.guard is None and found.table is None:
        again = _ema("identify", line.actuator, record, *healthy)
        return Advice("Hold it against all signals", "this is what the onboard module says alone", "", again)
    if found.verdict == "fault" and found.error is not None and found.error.leaves_much:
        return Advice("Ask what else there is", "the fault stands beside it", "", _ema("diagnose", line.actuator, record, *healthy))
    short = "Repair, and follow it" if found.verdict == "fault" else "Nothing; follow it"
    if found.verdict == "healthy" and found.baseline is not None and found.baseline.without:
        short = f"Find the cause of {listed([within(name) for name in found.baseline.without])}, and follow it"
    kept = line.options.get("--json")
    if kept:
        told = "over its dates: put the unit's earlier results before this one"
        return Advice(short, told, "", _ema("report", kept[-1], "-o", new_file(Path("unit.html"))))
    # not kept so far: the same again, with a file named after the record
    file = new_file(Path(Path(record).with_suffix(".json").name))
    keep = _ema("identify", line.actuator, record, *line.again("--healthy", "--table", "--weight"), "--json", file)
    return Advice(short, "over its dates: keep the result, then ema report draws it beside earlier ones", "", keep)
