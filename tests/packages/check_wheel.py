"""The tools as a wheel: built from the project, installed into an environment of its own, used from an empty folder.

Run by a Python that has scikit-build-core.
"""

from __future__ import annotations

import argparse
import json
import sys
import zipfile
from pathlib import Path

from outside import PackageError, expect, main, run

# What only benchmarks and tests use.
WORKSHOP = {"benchmarks", "truth", "reference", "reference_model", "vectors", "tests"}

# Where the installed package and all that it loaded lie, one a line.
WHERE = """
import ema_tools
from ema_tools.plant import native
native.library(32), native.library(64)
print(ema_tools.__file__)
print(*(line.split()[-1] for line in open("/proc/self/maps") if "libema" in line), sep="\\n")
"""


def built(root: Path, work: Path) -> Path:
    """The wheel, after a look at what is in it."""
    run(
        [sys.executable, "-I", "-m", "pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation", "-w", work / "dist", root],
        work,
        {"CMAKE_BUILD_PARALLEL_LEVEL": "2"},
    )
    wheels = list((work / "dist").glob("ema_tools-*.whl"))
    expect(len(wheels) == 1, f"{len(wheels)} wheels were built")
    held = set(zipfile.ZipFile(wheels[0]).namelist())
    wanted = {
        str(path.relative_to(root / "tools"))
        for path in (root / "tools/ema_tools").rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }
    wanted |= {
        f"ema_tools/shipped/{path.relative_to(root)}"
        for folder in ("actuators", "recordings")
        for path in (root / folder).rglob("*")
        if path.is_file()
    }
    # the page's workbench
    wanted.add("ema_tools/lib/ema.wasm")
    missing = sorted(wanted - held)
    expect(not missing, f"the wheel lacks {', '.join(missing[:5])} (ema.wasm needs the packages clang and lld)")
    # benchmarks, truth plant, reference model, vectors and tests stay in the project
    built_here = ("ema_tools/lib/", wheels[0].name.split("-py3")[0] + ".dist-info/")
    foreign = sorted(name for name in held - wanted if not name.startswith(built_here))
    foreign += sorted(name for name in held if not WORKSHOP.isdisjoint(Path(name).parts))
    expect(not foreign, f"the wheel holds what is not shipped: {', '.join(foreign[:5])}")
    return wheels[0]


def check(arguments: argparse.Namespace) -> str:
    """The whole way; says what was run."""
    root, work = arguments.root, arguments.work
    wheel = built(root, work)
    run([sys.executable, "-I", "-m", "venv", work / "venv"], work)
    python, ema = work / "venv/bin/python", work / "venv/bin/ema"
    run(
        [
            python,
            "-I",
            "-m",
            "pip",
            "install",
            "--quiet",
            "--no-compile",
            "--only-binary",
            ":all:",
            "-c",
            root / "tools/requirements.txt",
            wheel,
        ],
        work,
    )
    empty = work / "empty"
    empty.mkdir()
    lines = run([python, "-I", "-c", WHERE], empty).split()
    expect(len(lines) >= 3 and all(Path(line).is_relative_to(work / "venv") for line in lines), f"loaded from elsewhere: {lines}")
    noise = "position_mm=0.002,current_A=0.03"
    run([ema, "simulate", "reference", "--command", "chirp", "-o", "today.csv", "--set", "screw.csj_Nm=0.207", "--noise", noise], empty)
    run([ema, "identify", "reference", "today.csv", "--json", "identified.json"], empty)
    found = json.loads((empty / "identified.json").read_text(encoding="utf-8"))
    expect(found["verdict"] == "fault", f"half as much dry friction again is {found['verdict']}")
    expect(abs(found["csj_Nm"]["shift_percent"] - 50.0) < 2.0, f"CSJ +50 % is read as {found['csj_Nm']['shift_percent']:.1f} %")
    dead_time = "effects.inverter_dead_time.drop_V=0.5"
    run([ema, "simulate", "reference", "--command", "chirp", "-o", "hidden.csv", "--set", dead_time, "--noise", noise], empty)
    run([ema, "diagnose", "reference", "hidden.csv", "--json", "diagnosed.json", "--report", "page.html"], empty)
    found = json.loads((empty / "diagnosed.json").read_text(encoding="utf-8"))
    first = found["effects"][0]["name"] if found["effects"] else "nothing"
    expect(found["verdict"] == "missing" and first == "inverter_dead_time", f"a dead time is diagnosed as {found['verdict']}, {first}")
    page = (empty / "page.html").read_text(encoding="utf-8")
    expect("uPlot" in page and "charting library was not there" not in page, "the page has no curves")
    expect("data-workbench" in page, "the page has no workbench")
    run([ema, "export", "reference", "-o", "ema_actuator_data.h"], empty)
    try:
        run([ema, "compare", "references", "today.csv"], empty)
    except PackageError:
        return f"{wheel.name}: simulate, identify, diagnose and export from an empty folder"
    raise PackageError("an actuator that is not there was compared")


if __name__ == "__main__":
    sys.exit(main("wheel", check))
