"""Does what docs/FIRMWARE.md says, word for word, with the cross compiler: its first C block compiled with an exported configuration, in each of its three ways.

The blocks are taken from the page; a page that lacks one fails. Python's standard library alone.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
import tempfile
from pathlib import Path

BLOCK = re.compile(r"^```(c|cmake|sh)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
FUNCTIONS = ("ema_session_init", "ema_session_feed", "ema_session_run", "ema_session_result")
# Stands for the rest of the user's firmware.
MAIN = """#include <stdbool.h>
#include "ema/ema.h"
ema_status_t test_begin(void);
ema_status_t test_sample(float command_mm, float rod_mm);
bool test_slice(ema_status_t* status);
int main(void)
{
    ema_status_t status = test_begin();
    for (int k = 0; (status == EMA_OK) && (k < 200); ++k) {
        status = test_sample(0.01f * (float)k, 0.01f * (float)k);
    }
    while ((status == EMA_OK) && !test_slice(&status)) {
    }
    return (int)status;
}
"""
PROJECT = (
    "cmake_minimum_required(VERSION 3.25)\nproject(firmware LANGUAGES C)\nadd_executable(firmware main.c test.c)\n"
    "target_link_options(firmware PRIVATE --specs=nosys.specs -Wl,--gc-sections)\n"
)


class PageError(Exception):
    """What of the page does not work."""


def run(command: list[str], folder: Path) -> str:
    """The output of a command that must succeed."""
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise PageError(f"{' '.join(command)[:160]}: {(done.stdout + done.stderr).strip()[-800:]}")
    return done.stdout


def blocks_of(page: str) -> tuple[str, list[str], str]:
    """The page's first block of C, its CMake blocks and its command. Raises PageError when the page lacks C or has not two and one of the others."""
    found: dict[str, list[str]] = {"c": [], "cmake": [], "sh": []}
    for language, text in BLOCK.findall(page):
        found[language].append(text)
    if not found["c"] or len(found["cmake"]) != 2 or len(found["sh"]) != 1:
        raise PageError("the page has not a block of C, two of CMake and one command: keep them")
    return found["c"][0], found["cmake"], found["sh"][0]


def put_firmware(folder: Path, given: argparse.Namespace, code: str) -> None:
    """The user's own files."""
    folder.mkdir()
    (folder / "main.c").write_text(MAIN, encoding="utf-8")
    (folder / "test.c").write_text(code, encoding="utf-8")
    (folder / "ema_actuator_data.h").write_text(given.header.read_text(encoding="utf-8"), encoding="utf-8")


def check_linked(given: argparse.Namespace, program: Path) -> None:
    """The four functions must be in the program."""
    names = run([given.nm, str(program)], program.parent).split()
    missing = [name for name in FUNCTIONS if name not in names]
    if missing:
        raise PageError(f"{program}: {missing[0]} is not in it")


def check(given: argparse.Namespace, work: Path) -> int:
    """The number of ways that were taken."""
    code, ways, command = blocks_of(given.page.read_text(encoding="utf-8"))
    toolchain = [f"-DCMAKE_TOOLCHAIN_FILE={given.toolchain}", "-DCMAKE_BUILD_TYPE=Release"]
    built = work / "built"
    run([given.cmake, "-S", str(given.root), "-B", str(built), *toolchain, "-DEMA_TESTS=OFF", "-DEMA_HOST=OFF"], work)
    run([given.cmake, "--build", str(built), "--parallel", "2"], work)
    run([given.cmake, "--install", str(built), "--prefix", str(work / "place")], work)
    for number, way in enumerate(ways):
        folder = work / f"way{number}"
        put_firmware(folder, given, code)
        (folder / "ema").symlink_to(given.root)
        (folder / "CMakeLists.txt").write_text(PROJECT + way, encoding="utf-8")
        run([given.cmake, "-S", ".", "-B", "build", *toolchain, f"-DCMAKE_PREFIX_PATH={work / 'place'}"], folder)
        run([given.cmake, "--build", "build", "--target", "firmware", "--parallel", "2"], folder)
        check_linked(given, folder / "build" / "firmware")
    folder = work / "copied"
    put_firmware(folder, given, code)
    for part in ("include", "src"):
        (folder / part).symlink_to(given.root / part)
    flags = given.flags + " -Os -ffunction-sections -fdata-sections"
    run(["sh", "-c", f"CC={given.compiler} CFLAGS='{flags}'\n{command}"], folder)
    own = (
        f"{given.compiler} {flags} -std=c11 -ffp-contract=off -Iinclude --specs=nosys.specs -Wl,--gc-sections main.c test.c *.o -o firmware"
    )
    run(["sh", "-c", own], folder)
    check_linked(given, folder / "firmware")
    return len(ways) + 1


def main() -> int:
    """Entry point."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--root", type=Path, required=True, help="the project")
    parser.add_argument("--cmake", required=True)
    parser.add_argument("--toolchain", type=Path, required=True)
    parser.add_argument("--compiler", required=True)
    parser.add_argument("--flags", required=True, help="the compiler's flags for the core")
    parser.add_argument("--nm", required=True)
    parser.add_argument("--header", type=Path, required=True, help="an exported configuration")
    parser.add_argument("page", type=Path)
    given = parser.parse_args()
    try:
        with tempfile.TemporaryDirectory() as folder:
            ways = check(given, Path(folder))
    except (PageError, OSError) as error:
        print(f"{given.page.name}: {error}", file=sys.stderr)
        return 1
    print(f"{given.page.name}: its code builds in {ways} ways")
    return 0


if __name__ == "__main__":
    sys.exit(main())
