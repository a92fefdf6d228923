"""What the example firmware compiles in must be what `ema export` writes today: configuration and table of signatures, remarks aside.

Without --actuator it is that of the reference actuator, and the runs of the healthy machine that the table needs, five, are simulated here, with the noise of sensors and the scatter of
friction that a machine has; else those of --healthy are taken. The configuration must be equal to the letter. A number of the table may be off by what two machines' linear algebra makes it.
With --image a binary image, which holds the reference actuator and beside it that unit with the table of the header, must be
equal to the byte. With --write all of them are written instead. Python's standard library alone.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

NOISE = "position_mm=0.002,current_A=0.03"
# Dry friction of the healthy runs: its scatter from run to run.
LEVELS_NM = (0.1375, 0.1383, 0.1377, 0.1386, 0.1379)
# What two machines' linear algebra may make of a count of 16 bits, and of a real.
COUNTS = 2
SHARE = 1e-4
LEAST = 1e-12
# What the image calls the unit of --actuator.
UNIT = "unit"
REAL = re.compile(r"EMA_R\((.*?)\)")
LINE_OF_COUNTS = re.compile(r"^(?: *-?\d+,)+$", re.MULTILINE)


class ExportError(Exception):
    """Why nothing was exported, or what differs."""


def without_remarks(text: str) -> str:
    """C without its comments."""
    return re.sub(r"\s*/\*.*?\*/", "", text, flags=re.DOTALL)


def numbers_of(text: str) -> tuple[str, list[float], list[int]]:
    """C with a mark for each real and each line of counts, the reals, and the counts."""
    reals: list[float] = []
    counts: list[int] = []

    def real(match: re.Match[str]) -> str:
        reals.append(float.fromhex(match[1]) if "x" in match[1] else float(match[1]))
        return "real"

    def line(match: re.Match[str]) -> str:
        counts.extend(int(word) for word in match[0].split(",") if word.strip())
        return "counts"

    return REAL.sub(real, LINE_OF_COUNTS.sub(line, without_remarks(text))), reals, counts


def table_problem(old: str, fresh: str) -> str:
    """How the two tables differ beyond the last digits; empty when they do not."""
    (text, reals, counts), (fresh_text, fresh_reals, fresh_counts) = numbers_of(old), numbers_of(fresh)
    if text != fresh_text or "EMA_SIGNATURES" not in text or len(counts) < 1000:
        return "another shape"
    apart: list[tuple[float, float]] = [(ours, now) for ours, now in zip(counts, fresh_counts, strict=True) if abs(ours - now) > COUNTS]
    apart += [(ours, now) for ours, now in zip(reals, fresh_reals, strict=True) if abs(ours - now) > SHARE * abs(now) + LEAST]
    return f"{len(apart)} of {len(counts) + len(reals)} numbers: {apart[0][0]} is now {apart[0][1]}" if apart else ""


def ema(given: argparse.Namespace, *words: object) -> None:
    """Runs the tool. Raises ExportError."""
    build = given.python.parents[2]
    settings = {**os.environ, "EMA_LIBRARY_DIR": str(build / "lib"), "EMA_BIN_DIR": str(build / "bin"), "OPENBLAS_NUM_THREADS": "1"}
    command = [str(given.python), "-B", "-m", "ema_tools", *map(str, words)]
    done = subprocess.run(command, cwd=given.root / "tools", env=settings, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise ExportError(f"ema {words[0]} failed: {done.stderr.strip()}")


def export(given: argparse.Namespace, folder: Path) -> tuple[str, str]:
    """Configuration and table as they are written today. Raises ExportError."""
    actuator = given.actuator or given.root / "actuators" / "reference.toml"
    healthy: list[object] = [word for record in given.healthy for word in ("--healthy", record)]
    for seed, level in enumerate(() if given.actuator else LEVELS_NM, start=1):
        record = folder / f"healthy{seed}.csv"
        ema(
            given,
            "simulate",
            actuator,
            "--command",
            "chirp",
            "--noise",
            NOISE,
            "--seed",
            seed,
            "--set",
            f"screw.csj_Nm={level}",
            "-o",
            record,
        )
        healthy += ["--healthy", record]
    ema(given, "export", actuator, "-o", folder / "actuator.h", "--signatures", folder / "signatures.h", *healthy)
    return (folder / "actuator.h").read_text(encoding="utf-8"), (folder / "signatures.h").read_text(encoding="utf-8")


def export_image(given: argparse.Namespace, folder: Path) -> bytes:
    """The image as it is written today, its table that of the header. Raises ExportError."""
    ema(given, "export", given.root / "actuators" / "reference.toml", "--image", folder / "reference.bin")
    beside = ("--beside", folder / "reference.bin", "--table", given.table)
    ema(given, "export", given.actuator, "--image", folder / "both.bin", "--name", UNIT, *beside)
    return (folder / "both.bin").read_bytes()


def main() -> int:
    """Entry point."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--python", type=Path, required=True, help="the Python of the tools")
    parser.add_argument("--root", type=Path, required=True, help="the project")
    parser.add_argument("--actuator", type=Path, help="the actuator; the reference actuator where absent")
    parser.add_argument("--healthy", type=Path, nargs="+", default=[], help="its healthy runs")
    parser.add_argument("--image", type=Path, help="the binary image that holds the unit, too")
    parser.add_argument("--write", action="store_true", help="write all of them instead of comparing")
    parser.add_argument("header", type=Path, help="the configuration that the firmware compiles in")
    parser.add_argument("table", type=Path, help="its table of signatures")
    given = parser.parse_args()
    # the tools run in a folder of their own; the Python stays the link that it is
    given.python, given.root = Path(os.path.abspath(given.python)), given.root.resolve()
    given.header, given.table = given.header.resolve(), given.table.resolve()
    given.actuator = given.actuator and given.actuator.resolve()
    given.image = given.image and given.image.resolve()
    given.healthy = [record.resolve() for record in given.healthy]
    try:
        with tempfile.TemporaryDirectory() as folder:
            header, table = export(given, Path(folder))
            if given.write:
                given.header.write_text(header, encoding="utf-8")
                given.table.write_text(table, encoding="utf-8")
            image = export_image(given, Path(folder)) if given.image else b""
    except (ExportError, OSError) as error:
        print(error, file=sys.stderr)
        return 1
    if given.write:
        if given.image:
            given.image.write_bytes(image)
        print(f"{given.header.name} and {given.table.name} written")
        return 0
    problems = []
    fresh = without_remarks(header)
    if "EMA_ACTUATOR" not in fresh or fresh != without_remarks(given.header.read_text(encoding="utf-8")):
        problems.append(f"{given.header.name} is not what ema export writes")
    difference = table_problem(given.table.read_text(encoding="utf-8"), table)
    if difference:
        problems.append(f"{given.table.name} is not what ema export writes: {difference}")
    if given.image and given.image.read_bytes() != image:
        problems.append(f"{given.image.name} is not what ema export writes")
    for problem in problems:
        print(f"{problem}: write it anew with --write", file=sys.stderr)
    print(f"{given.header.name}, {given.table.name}: {len(header.splitlines())} and {len(table.splitlines())} lines compared")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
