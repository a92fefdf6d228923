"""The module installed by CMake: found by find_package and by pkg-config, for this machine and for a Cortex-M; and the flags that each build takes."""

from __future__ import annotations

import argparse
import json
import shlex
import shutil
import sys
from pathlib import Path

from outside import environment, expect, main, run

HERE = Path(__file__).resolve().parent
ALONE = ("-DEMA_TESTS=OFF", "-DEMA_HOST=OFF")


def installed(root: Path, work: Path, name: str, *options: str) -> tuple[Path, str]:
    """The module built with `options` and installed; its prefix, and the command that compiles a file of it."""
    run(["cmake", "-S", root, "-B", work / name, *ALONE, *options], work)
    run(["cmake", "--build", work / name, "-j2"], work)
    run(["cmake", "--install", work / name, "--prefix", work / f"{name}_prefix"], work)
    return work / f"{name}_prefix", command_of(work / name)


def command_of(build: Path) -> str:
    """How a configured build compiles its first file."""
    return str(json.loads((build / "compile_commands.json").read_text(encoding="utf-8"))[0]["command"])


def levels(command: str) -> list[str]:
    """The optimisation that a compiler is asked for, in its order."""
    return [word for word in shlex.split(command) if word.startswith("-O")]


def check_flags(root: Path, work: Path) -> None:
    """Nothing stands over what the user says."""
    asked = {
        "default": ((), ["-O3"]),
        "flags": (("-DCMAKE_C_FLAGS=-Os",), ["-Os"]),
        "release": (("-DCMAKE_C_FLAGS_RELEASE=-O1",), ["-O1"]),
        "same": (("-DCMAKE_C_FLAGS_RELEASE=-O3 -DNDEBUG",), ["-O3"]),
        "kind": (("-DCMAKE_BUILD_TYPE=MinSizeRel",), ["-Os"]),
    }
    for name, (options, wanted) in asked.items():
        for _ in range(2):  # configured once more it stays so
            run(["cmake", "-S", root, "-B", work / f"flags_{name}", *ALONE, *options], work)
        command = command_of(work / f"flags_{name}")
        expect(levels(command) == wanted, f"{' '.join(options) or 'no flags'}: compiled with {levels(command)}, not {wanted}")
        expect(("-DNDEBUG" in command) == (name in ("same", "kind")), f"{name}: the user's -DNDEBUG is not as he has it: {command}")


def check(arguments: argparse.Namespace) -> str:
    """The whole way; says what was run."""
    root, work = arguments.root, arguments.work
    project = shutil.copytree(HERE / "project", work / "project")
    check_flags(root, work)
    prefix, _ = installed(root, work, "native")
    moved = prefix.rename(work / "moved")
    run(["cmake", "-S", project, "-B", work / "found", f"-DCMAKE_PREFIX_PATH={moved}"], work)
    run(["cmake", "--build", work / "found"], work)
    by_cmake = run([work / "found/outside"], work)
    expect(by_cmake.startswith("0 ok: "), f"found by find_package: {by_cmake}")

    package = next(moved.rglob("ema.pc")).parent
    flags = run(["pkg-config", "--cflags", "--libs", "ema"], work, {"PKG_CONFIG_PATH": str(package)})
    expect(
        run(["pkg-config", "--modversion", "ema"], work, {"PKG_CONFIG_PATH": str(package)}).strip() == "0.1.0", "ema.pc has another version"
    )
    compiler = environment().get("CC", "cc")
    run([compiler, "-std=c11", "main.c", *shlex.split(flags), "-o", "by_pkg_config"], project)
    by_pkg_config = run([project / "by_pkg_config"], work)
    expect(by_cmake == by_pkg_config, f"by pkg-config {by_pkg_config}, by find_package {by_cmake}")
    ways = "find_package, pkg-config"
    reached = run([compiler, "-std=c11", "-M", "main.c", *shlex.split(flags)], project)
    missing = sorted(header.name for header in moved.rglob("ema_*.h") if header.name not in reached)
    expect(not missing, f"ema/ema.h does not include {', '.join(missing)}: add them")
    if shutil.which("c++"):
        run(
            ["c++", "-std=c++11", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "headers.cpp", *shlex.split(flags), "-o", "from_cpp"],
            project,
        )
        run([project / "from_cpp"], work)
        ways += ", C++11"

    if shutil.which("arm-none-eabi-gcc") is None:
        return f"{ways}; no arm-none-eabi-gcc on this machine, so no cross build"
    toolchain = f"-DCMAKE_TOOLCHAIN_FILE={root / 'cmake/cortex-m4f.cmake'}"
    prefix, command = installed(root, work, "arm", toolchain)
    expect(levels(command) == ["-Os"], f"without an operating system: compiled with {levels(command)}, not -Os")
    names = sorted(path.name for path in prefix.rglob("*.a"))
    expect(names == ["libema.a"], f"without an operating system: {names} are installed, not libema.a alone")
    run(
        [
            "cmake",
            "-S",
            project,
            "-B",
            work / "arm_found",
            toolchain,
            f"-DCMAKE_PREFIX_PATH={prefix}",
            "-DCMAKE_FIND_ROOT_PATH_MODE_PACKAGE=BOTH",
        ],
        work,
    )
    run(["cmake", "--build", work / "arm_found"], work)
    run(["cmake", "-S", root, "-B", work / "arm_flags", *ALONE, toolchain, "-DCMAKE_C_FLAGS=-mcpu=cortex-m4 -mthumb -O2"], work)
    expect(levels(command_of(work / "arm_flags")) == ["-O2"], "the user's -O2 on a target without an operating system is not the last word")
    run(["cmake", "-S", project, "-B", work / "arm_folder", toolchain, f"-DEMA_FOLDER={root}"], work)
    command = command_of(work / "arm_folder")
    expect(not levels(command), f"a folder of a project without a build type: compiled with {levels(command)}, not as the project is")
    run(["cmake", "--build", work / "arm_folder", "-j2"], work)
    return f"{ways}, and a Cortex-M4F by find_package and as a folder; flags of the user's stay"


if __name__ == "__main__":
    sys.exit(main("install", check))
