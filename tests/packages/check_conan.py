"""The module as a package of Conan 2: created from the recipe, and the outside project built and run with what it installed."""

from __future__ import annotations

import argparse
import re
import sys
from pathlib import Path

from outside import bits_of_sources, expect, main, run, version_of

HERE = Path(__file__).resolve().parent


def check(arguments: argparse.Namespace) -> str:
    """The whole way; says what was run."""
    root, work = arguments.root, arguments.work
    conan = Path(sys.executable).with_name("conan")
    # a home of its own, and no server: what the package needs is in it
    home = {"CONAN_HOME": str(work / "home")}
    run([conan, "profile", "detect"], work, home)
    project = work / "project"
    project.mkdir()
    for path in (HERE / "project/main.c", HERE / "project/CMakeLists.txt", HERE / "conan_project/conanfile.py"):
        (project / path.name).write_bytes(path.read_bytes())
    said = run([conan, "create", root, "--no-remote", "--test-folder", project], work, home)
    version = version_of(root)
    expect(f"ema/{version}" in said, f"conan made another version than {version}")
    found = re.search(r"^0 ok: .*$", said, re.MULTILINE)
    expect(found is not None, f"the outside project did not run:\n{said[-3000:]}")
    same = found is not None and found.group(0) == bits_of_sources(root, work).strip()
    expect(same, "from Conan's package the bits are others")
    return f"ema/{version} created by Conan, and the outside project run with it"


if __name__ == "__main__":
    sys.exit(main("conan", check))
