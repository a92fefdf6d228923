"""Runs the fuzz targets, each from its kept corpus, and fails when one finds something or did not run.

The short run is the test `fuzz` of `cmake --workflow --preset fuzz`. The long one, after it: `cmake --build --preset fuzz-long`, which goes on in rounds until the
targets together have made ten million executions. What a round finds worth keeping stays in the build folder and is begun from in the next; --keep brings the smallest
of it into the project's corpus. An input on which a property fails is written into the work folder and named; give it to the program to see the failure again.
Python's standard library alone.
"""

from __future__ import annotations

import argparse
import re
import shutil
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

CORPUS = Path(__file__).resolve().parent / "corpus"
# Longest input in bytes by target; a recording needs a hundred rows before it is one.
LENGTHS = {"fuzz_csv": 4096, "fuzz_config_text": 1024, "fuzz_config": 512, "fuzz_effects": 256, "fuzz_session": 512, "fuzz_image": 512}
# Memory and time of one execution: beyond them it is a finding.
MEMORY_MB = 1024
LONGEST_S = 25
# What --keep leaves of a target's corpus.
KEPT_BYTES = 50_000
KEPT_FILES = 80


class FuzzError(Exception):
    """What was found, or why nothing was run."""


@dataclass(frozen=True)
class Ran:
    """One round of one target."""

    target: str
    executions: int
    seconds: float
    edges: int
    inputs: int


def corpus_of(target: str, corpus: Path) -> list[Path]:
    """The kept inputs of a target. Raises FuzzError when there are none."""
    folder = corpus / target
    files = sorted(path for path in folder.iterdir() if path.is_file()) if folder.is_dir() else []
    if not files:
        raise FuzzError(f"{target}: no kept inputs in {folder}: restore them, or make some with --keep")
    return files


def program_of(target: str, programs: Path) -> Path:
    """The built program. Raises FuzzError when it is not there."""
    program = programs / target
    if not program.is_file():
        raise FuzzError(f"{target}: {program} is not built: run cmake --workflow --preset fuzz")
    return program


def run(target: str, programs: Path, corpus: Path, work: Path, seconds: int, least: int, seed: int) -> Ran:
    """One round. Raises FuzzError for a finding, and for fewer than `least` executions beyond the corpus."""
    program = program_of(target, programs)
    kept = corpus_of(target, corpus)
    own, found = work / target / "corpus", work / target / "found"
    own.mkdir(parents=True, exist_ok=True)
    found.mkdir(parents=True, exist_ok=True)
    words = corpus / f"{target}.dict"
    command = [
        str(program),
        f"-max_total_time={seconds}",
        f"-max_len={LENGTHS.get(target, 512)}",
        f"-timeout={LONGEST_S}",
        f"-rss_limit_mb={MEMORY_MB}",
        "-print_final_stats=1",
        f"-seed={seed}",
        f"-artifact_prefix={found}/",
        *([f"-dict={words}"] if words.is_file() else []),
        str(own),
        str(corpus / target),
    ]
    begun = time.monotonic()
    done = subprocess.run(command, capture_output=True, text=True, errors="replace", check=False)
    took = time.monotonic() - begun
    if done.returncode != 0:
        tail = [line for line in done.stderr.splitlines() if re.search(r"property|runtime error|ERROR|SUMMARY|Test unit written", line)]
        raise FuzzError(f"{target}: ended with {done.returncode}:\n  " + "\n  ".join(tail or done.stderr.splitlines()[-10:]))
    count = re.search(r"stat::number_of_executed_units:\s*(\d+)", done.stderr)
    executions = int(count.group(1)) if count else 0
    if executions < len(kept) + least:
        raise FuzzError(
            f"{target}: {executions} executions where at least {len(kept)} kept inputs and {least} more were to run: give it more --seconds"
        )
    edges = [int(number) for number in re.findall(r"\bcov: (\d+)", done.stderr)]
    return Ran(target, executions, took, max(edges, default=0), sum(1 for _ in own.iterdir()) + len(kept))


def keep(target: str, programs: Path, corpus: Path, work: Path) -> int:
    """Brings the smallest inputs that reach everything reached into the corpus, within its limits; returns how many it holds then."""
    with tempfile.TemporaryDirectory() as folder:
        merged = Path(folder) / target
        merged.mkdir()
        sources = [path for path in (corpus / target, work / target / "corpus") if path.is_dir()]
        command = [str(program_of(target, programs)), "-merge=1", f"-max_len={LENGTHS.get(target, 512)}", str(merged), *map(str, sources)]
        subprocess.run(command, capture_output=True, check=True)
        chosen: list[Path] = []
        size = 0
        for path in sorted(merged.iterdir(), key=lambda path: (path.stat().st_size, path.name)):
            size += path.stat().st_size
            if size <= KEPT_BYTES and len(chosen) < KEPT_FILES:
                chosen.append(path)
        # inputs with a name of their own were written by hand and stay
        (corpus / target).mkdir(parents=True, exist_ok=True)
        for path in (corpus / target).iterdir():
            if re.fullmatch(r"[0-9a-f]{40}", path.name):
                path.unlink()
        for path in chosen:
            shutil.copyfile(path, corpus / target / path.name)
    return len(list((corpus / target).iterdir()))


def told(ran: list[Ran]) -> str:
    """A table of all rounds, summed by target."""
    lines = [f"{'target':<18}{'executions':>12}{'per second':>12}{'edges':>8}{'inputs':>8}"]
    for target in dict.fromkeys(one.target for one in ran):
        own = [one for one in ran if one.target == target]
        executions, seconds = sum(one.executions for one in own), sum(one.seconds for one in own)
        lines.append(f"{target:<18}{executions:>12}{executions / seconds:>12.0f}{max(one.edges for one in own):>8}{own[-1].inputs:>8}")
    lines.append(f"{'together':<18}{sum(one.executions for one in ran):>12}")
    return "\n".join(lines)


def main(arguments: list[str] | None = None) -> int:
    """0 when nothing was found; 1, with what was, otherwise."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("targets", nargs="+", help="names of the programs")
    parser.add_argument("--programs", type=Path, required=True, help="folder of the built programs")
    parser.add_argument("--work", type=Path, required=True, help="folder for new inputs and findings")
    parser.add_argument("--corpus", type=Path, default=CORPUS, help="folder of the kept inputs")
    parser.add_argument("--seconds", type=int, default=10, help="of one round of one target")
    parser.add_argument("--executions", type=int, default=0, help="go on in rounds until the targets together made so many")
    parser.add_argument("--least", type=int, default=200, help="executions that a round must make beyond the kept inputs")
    parser.add_argument("--seed", type=int, default=1, help="of the first round")
    parser.add_argument("--jobs", type=int, default=1, help="targets at a time")
    parser.add_argument("--keep", action="store_true", help="afterwards bring the smallest inputs into the project's corpus")
    options = parser.parse_args(arguments)
    ran: list[Ran] = []
    seed = options.seed
    try:
        while not ran or sum(one.executions for one in ran) < options.executions:
            with ThreadPoolExecutor(options.jobs) as pool:
                ran += pool.map(
                    lambda target, seed=seed: run(
                        target, options.programs, options.corpus, options.work, options.seconds, options.least, seed
                    ),
                    options.targets,
                )
            seed += 1
            if options.executions:
                print(f"{told(ran)}\n", flush=True)
        if options.keep:
            for target in options.targets:
                print(f"{target}: {keep(target, options.programs, options.corpus, options.work)} inputs kept")
    except FuzzError as error:
        print(error, file=sys.stderr)
        return 1
    print(told(ran))
    return 0


if __name__ == "__main__":
    sys.exit(main())
