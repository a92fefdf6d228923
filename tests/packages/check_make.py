"""The module's files in another project, by make: two include paths, effects left out by a macro, the bits of CMake's build."""

from __future__ import annotations

import argparse
import shutil
import sys
from pathlib import Path

from outside import expect, main, run

HERE = Path(__file__).resolve().parent


def check(arguments: argparse.Namespace) -> str:
    """The whole way; says what was run."""
    root, work = arguments.root, arguments.work
    project = shutil.copytree(HERE / "project", work / "project")
    shutil.copytree(root / "include", work / "ema/include")
    shutil.copytree(root / "src", work / "ema/src")
    said = {}
    for name, defines in {
        "all": "",
        "none": "-DEMA_EFFECTS_CHOSEN=1",
        "used": "-DSTRIBECK_RISE=0.3f",
        "held": "-DSTRIBECK_RISE=0.3f -DEMA_EFFECTS_CHOSEN=1 -DEMA_WITH_stribeck_friction=1",
        "fixed": "-DEMA_EFFECTS_CHOSEN=1 -DEMA_ONLY_PI=1 -DEMA_ONLY_VOLTAGE=1 -DEMA_ONLY_EXACT=1 -DEMA_ONLY_CHECKED=1",
        "left_out": "-DSTRIBECK_RISE=0.3f -DEMA_EFFECTS_CHOSEN=1 -DEMA_WITH_cogging_torque=1",
    }.items():
        # the bits hang on no optimization either, and without it the compiler takes a third of the time
        optimized = [] if name == "all" else ["CFLAGS=-O0"]
        run(["make", "-B", f"EMA={work / 'ema'}", f"DEFINES={defines}", *optimized], project)
        said[name] = run([project / "outside"], project)
    expect(
        said["all"].startswith("0 ok: ") and said["all"] == said["none"] == said["fixed"], f"without effects the bits are others: {said}"
    )
    expect(
        said["used"].startswith("0 ok: ") and said["used"] == said["held"] != said["all"], f"an effect that is held has other bits: {said}"
    )
    expect(said["left_out"].startswith("12 "), f"an effect that is left out is not refused: {said['left_out']}")
    return "all effects, none, one alone, and one kind of actuator"


if __name__ == "__main__":
    sys.exit(main("make", check))
