"""Identifies one recorded case on the target and on the host, with several slices, and wants the same bits everywhere.

Three programs answer: `ema_answer` on the emulated board, the same source built for the host, and `ema_identify`, the host program, from the CSV file itself. Where a stored answer
is named, of a unit by its own model with grease and winding of the day, it takes the place of the last: the tools wrote it by the desk's float32 library.
Python's standard library alone.
"""

from __future__ import annotations

import argparse
import json
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

import emulate

# Lines of an answer that every slice must share, and how many of each, the values' own counted for one; only `slices` differs.
SHARED = {
    "case": 1,
    "seed": 1,
    "format": 1,
    "rows": 1,
    "estimate": 1,
    "std": 1,
    "half_95": 1,
    "shift_percent": 1,
    "objective_before": 1,
    "objective_after": 1,
    "residual_rms_mm": 1,
    "residual_correlation": 1,
    "evaluations": 1,
    "model_steps": 1,
    "random": 1,
    "stage": 1,
    "outcome": 1,
    "verdict": 1,
    "adequate": 1,
    "reasons": 1,
}
OF_A_VALUE = ("estimate", "std", "half_95", "shift_percent")
# Values that a session identifies: CSJ and BLK, and the unit's grease and winding.
VALUES = {"a": 2, "b": 2, "c": 2, "u": 4}
ROWS = 10000


class WrongAnswerError(Exception):
    """Why the answers do not agree, or are none."""


def shared_part(output: str, who: str, values: int = 2) -> tuple[str, int]:
    """The lines that must be equal, and the number of slices; `values`: how many were identified. Raises WrongAnswerError for an incomplete answer."""
    lines = [line for line in output.splitlines() if line]
    names = [line.split()[0] for line in lines]
    for name, once in {**SHARED, "slices": 1}.items():
        count = once * (values if name in OF_A_VALUE else 1)
        if names.count(name) != count:
            raise WrongAnswerError(f"{who}: {names.count(name)} lines `{name}` instead of {count}: {output.strip()[-200:]}")
    if f"rows {ROWS}" not in lines:
        raise WrongAnswerError(f"{who}: not fed with {ROWS} rows")
    slices = int(lines[names.index("slices")].split()[1])
    steps = int(lines[names.index("model_steps")].split()[1])
    if steps < 5 * ROWS:
        raise WrongAnswerError(f"{who}: {steps} model steps are no identification")
    return "\n".join(line for line in lines if not line.startswith("slices ")), slices


def compare(host: str, target: str, who: str) -> None:
    """Raises WrongAnswerError with the first line that differs."""
    for ours, theirs in zip(host.splitlines(), target.splitlines(), strict=True):
        if ours != theirs:
            raise WrongAnswerError(f"{who}: the target says `{theirs}`, the host `{ours}`")


def check_host_program(program: Path, recording: Path, seed: int, answer: str) -> None:
    """The host program reads the CSV file itself and must come to the bits of `answer`."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "result.json"
        done = subprocess.run(
            [str(program), "--reference", "--seed", str(seed), "--json", str(out), str(recording)],
            capture_output=True,
            text=True,
            check=False,
        )
        if done.returncode != 0:
            raise WrongAnswerError(f"{program.name}: {done.stderr.strip()}")
        result = json.loads(out.read_text(encoding="utf-8"))
    words = [line.split() for line in answer.splitlines()]
    bits = {name: [line[1] for line in words if line[0] == name] for name in SHARED}
    pairs = [
        (f"{fault}.{key}", result[fault][key], bits[key][place])
        for place, fault in enumerate(("csj_Nm", "blk_mm"))
        for key in ("estimate", "std", "shift_percent")
    ]
    pairs += [(key, result[f"{key}_mm2s"], bits[key][0]) for key in ("objective_before", "objective_after")]
    pairs += [("residual_rms_mm", result["residual_rms_mm"], bits["residual_rms_mm"][0])]
    for name, value, expected in pairs:
        if struct.pack(">f", value).hex() != expected:
            raise WrongAnswerError(f"{program.name}: {name} is {value!r}, the answer's bits are {expected}")
    for name in ("evaluations", "model_steps"):
        if str(result[name]) != bits[name][0]:
            raise WrongAnswerError(f"{program.name}: {name} is {result[name]}, the answer's {bits[name][0]}")


def check_stored(file: Path, answer: str) -> None:
    """Every name of the stored answer must have the answer's bits, whole numbers as they are printed."""
    stored: dict[str, list[str]] = json.loads(file.read_text(encoding="utf-8"))["answer"]
    words = [line.split() for line in answer.splitlines()]
    missing = set(SHARED) - {"case", "seed", "format", "rows", *stored}
    if missing:
        raise WrongAnswerError(f"{file.name}: no {min(missing)}: write it by the build's target `written`")
    for name, expected in stored.items():
        found = [line[1] for line in words if line[0] == name]
        if found != expected:
            raise WrongAnswerError(f"{file.name}: {name} is {' '.join(expected)}, the answer's {' '.join(found)}")


def check(given: argparse.Namespace) -> int:
    """The number of identifications on the target that were compared."""
    compared = 0
    reference = ""
    fewest = sys.maxsize
    for slice_steps in given.slices:
        arguments = [given.case, str(given.seed), str(slice_steps), "real", given.search]
        who = f"case {given.case}, seed {given.seed}, slice {slice_steps}"
        on_host = subprocess.run([str(given.host / "ema_answer"), *arguments], capture_output=True, text=True, check=False)
        host, host_slices = shared_part(on_host.stdout, f"{who}, host", VALUES[given.case])
        result = emulate.run(given.board, given.target, arguments)
        if result.exit_code != 0:
            raise WrongAnswerError(f"{who}: the target ended with {result.exit_code}: {result.output.strip()[-200:]}")
        target, target_slices = shared_part(result.output, f"{who}, target", VALUES[given.case])
        reference = reference or host
        compare(host, target, who)
        compare(reference, target, f"{who} against slice {given.slices[0]}")
        if host_slices != target_slices or target_slices >= fewest:
            raise WrongAnswerError(f"{who}: {target_slices} slices on the target, {host_slices} on the host")
        fewest = target_slices
        compared += 1
    if given.answer:
        check_stored(given.answer, reference)
    else:
        check_host_program(given.host / "ema_identify", given.recording, given.seed, reference)
    return compared


def main() -> int:
    """Entry point."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--board", required=True)
    parser.add_argument("--target", type=Path, required=True, help="ema_answer for the board")
    parser.add_argument("--host", type=Path, required=True, help="folder of the host's programs")
    parser.add_argument("--recording", type=Path, required=True)
    parser.add_argument("--case", required=True, choices=tuple(VALUES))
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--slices", type=int, nargs="+", required=True, help="model steps of a slice, growing")
    parser.add_argument("--search", choices=("annealer", "two_stages"), default="two_stages")
    parser.add_argument("--answer", type=Path, help="the stored answer of the desk's library, in the place of the host program's")
    given = parser.parse_args()
    try:
        compared = check(given)
    except (WrongAnswerError, FileNotFoundError) as error:
        print(error, file=sys.stderr)
        return 1
    print(f"case {given.case}, seed {given.seed}: {compared} identifications on the target, each with the host's bits")
    return 0 if compared == len(given.slices) else 1


if __name__ == "__main__":
    sys.exit(main())
