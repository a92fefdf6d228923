"""One walk: runs the first command, then exactly what each result advises, until a verdict, or until nothing can be run; and judges the end by the truth."""

from __future__ import annotations

import contextlib
import io
import json
import os
import shlex
import sys
import tempfile
import time
import traceback
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from benchmarks.loop.trials import Trial, Truth

MOST_COMMANDS = 6
# A shift is wrong where it is off by more than its interval and more than this share of the healthy value: what is stated, whatever the healthy value is read as.
_OFF = 0.1
_NAMES = {"csj": "csj_Nm", "blk": "blk_mm"}


@dataclass(frozen=True)
class Answer:
    """Exit code of a command, what it printed, and its JSON result; empty where it wrote none."""

    code: int
    out: str
    err: str
    result: Mapping[str, Any]


Command = Callable[[Sequence[str], Path, str], Answer]


@dataclass
class Walk:
    """What happened. `end`: verdict, open, circle, error or long; `steps`: command, sentence, advice as printed and seconds of each; `unprinted`: advised commands that no `Next:` line has."""

    end: str = "long"
    steps: list[dict[str, Any]] = field(default_factory=list)
    unprinted: list[str] = field(default_factory=list)
    results: list[Mapping[str, Any]] = field(default_factory=list)

    @property
    def result(self) -> Mapping[str, Any]:
        """The last result; empty before the first."""
        return self.results[-1] if self.results else {}


def ema(arguments: Sequence[str], folder: Path, answer: str) -> Answer:
    """Runs an `ema` command in `folder` inside this process; its result goes to `answer`, or to the file that the command names itself."""
    from ema_tools.cli import main

    given = arguments[arguments.index("--json") + 1] if "--json" in arguments else None
    words = [*arguments, *(() if given else ("--json", answer))]
    written = folder / (given or answer)
    out, err = io.StringIO(), io.StringIO()
    before, place, code = sys.argv, Path.cwd(), 0
    sys.argv = words
    os.chdir(folder)
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            main()
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else int(end.code is not None)
    except Exception:
        code = 70
        err.write(traceback.format_exc())
    finally:
        sys.argv = before
        os.chdir(place)
    result = json.loads(written.read_text(encoding="utf-8")) if code == 0 and written.is_file() else {}
    return Answer(code, out.getvalue(), err.getvalue(), result)


def _is_verdict(result: Mapping[str, Any]) -> bool:
    """Whether a result ends a walk: a verdict of `identify`, or by the balance that nothing is missing, or which value has changed."""
    if result["command"] == "identify":
        return bool(result["verdict"] != "undecided")
    if result["command"] != "diagnose" or result.get("method") != "balance":
        return False
    changed = any(fault["accepted"] for fault in result["faults"].values())
    return bool(result["verdict"] == "adequate" or (result["verdict"] == "missing" and (changed or not result["next"])))


def walked(first: Sequence[str], folder: Path, run: Command = ema) -> Walk:
    """Runs `first` and then what each result advises, in order."""
    walk, waiting, done = Walk(), [list(first)], set[str]()
    while waiting and len(walk.steps) < MOST_COMMANDS:
        arguments = waiting.pop(0)
        line = shlex.join(arguments)
        if line in done:
            walk.end = "circle"
            walk.steps.append({"command": line, "sentence": "the same command as before", "next": "", "seconds": 0.0})
            return walk
        done.add(line)
        begun = time.monotonic()
        answer = run(arguments, folder, f"answer_{len(walk.steps) + 1}.json")
        advice = [text for text in answer.out.splitlines() if text.startswith("Next: ")]
        failed = answer.code != 0 or "Traceback" in answer.out + answer.err or not answer.result
        sentence = answer.err.strip()[-2000:] or f"exit code {answer.code}, no result" if failed else _sentence(answer.result)
        walk.steps.append(
            {"command": line, "sentence": sentence, "next": " | ".join(advice), "seconds": round(time.monotonic() - begun, 1)}
        )
        if failed:
            # records that the first command refuses are said to be too little: nothing was advised before
            walk.end = "error" if len(walk.steps) > 1 or "Traceback" in sentence or not answer.err.startswith("ema: ") else "open"
            return walk
        walk.results.append(answer.result)
        commands = [list(command) for command in answer.result.get("next", ())]
        walk.unprinted += [text for text in map(shlex.join, commands) if not any(printed.endswith(f": {text}") for printed in advice)]
        if _is_verdict(answer.result):
            walk.end = "verdict"
            return walk
        waiting = commands or waiting
    if not waiting:
        walk.end = "open"
    return walk


def _sentence(result: Mapping[str, Any]) -> str:
    parts = [f"[{result['verdict']}]" if result.get("verdict") else "", result.get("sentence") or "", *result.get("reasons", ())]
    return " ".join(filter(None, parts))


def judged(walk: Walk, truth: Truth) -> tuple[str, str]:
    """right, wrong or undecided, and why; an end that is no verdict is undecided, or what it is where that is a mistake of the advice."""
    if walk.end != "verdict":
        return ("undecided", "") if walk.end == "open" else (walk.end, "")
    verdict = walk.result["verdict"]
    if truth.today is None or truth.healthy is None:
        return _judged_by_balance(walk.results, truth)
    # wear is more friction and more play
    worn = any(shift > 0.0 for shift in truth.faults.values())
    if verdict == "healthy":
        return ("wrong", "a fault called healthy") if worn else ("right", "")
    if not worn:
        return "wrong", "healthy called a fault"
    for name, key in _NAMES.items():
        found, shift = walk.result[key], truth.today[name] / truth.healthy[name] - 1.0
        low, high = (end / found["healthy"] - 1.0 for end in found["interval95"])
        if not low <= shift <= high and abs(0.01 * found["shift_percent"] - shift) > _OFF:
            return (
                "wrong",
                f"{key} {found['shift_percent']:+.1f} % [{100.0 * low:.1f} .. {100.0 * high:.1f}] instead of {100.0 * shift:+.1f} %",
            )
    return "right", ""


def _judged_by_balance(results: Sequence[Mapping[str, Any]], truth: Truth) -> tuple[str, str]:
    """By what the diagnoses accepted, which is in the model of those that followed."""
    hidden, accepted = {*truth.effects, *truth.faults}, dict[str, set[str]]()
    for result in results:
        if result["command"] == "diagnose":
            accepted |= {effect["name"]: {effect["name"], *effect["class"]} for effect in result["effects"] if effect["accepted"]}
            accepted |= {name: {name} for name, fault in result["faults"].items() if fault["accepted"]}
    # every machine of benchmarks.machines has bristle friction
    accepted.pop("presliding", None)
    if not accepted:
        missed = " and ".join(sorted(hidden))
        return ("wrong", f"{missed} called healthy") if truth.faults else ("undecided", f"{missed} missed") if hidden else ("right", "")
    if not hidden:
        return "wrong", f"healthy called {', '.join(accepted)}"
    named = any(hidden & alike for alike in accepted.values())
    return ("right", "") if named else ("wrong", f"{', '.join(accepted)} instead of {' and '.join(sorted(hidden))}")


def perform(trial: Trial, run: Command = ema, keep: Path | None = None) -> dict[str, Any]:
    """The row of a walk in a folder of its own, which is removed at the end unless `keep` names it."""
    with tempfile.TemporaryDirectory(prefix="walk_") if keep is None else contextlib.nullcontext(keep) as name:
        folder = Path(name).resolve()
        first, truth = trial.prepare(folder)
        walk = walked(first, folder, run)
    judgement, why = judged(walk, truth)
    sizes = {key: walk.result[key]["estimate"] for key in _NAMES.values() if key in walk.result}
    return {
        "key": trial.key,
        **asdict(trial),
        "end": walk.end,
        "judged": judgement,
        "why": why,
        "verdict": walk.result.get("verdict"),
        "sizes": sizes,
        "healthy": truth.healthy,
        "today": truth.today,
        "steps": walk.steps,
        "unprinted": walk.unprinted,
    }
