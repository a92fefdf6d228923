"""The module as a library of PlatformIO: packed by its tool, and the outside project built from what is in the pack, with the flags that its manifest states."""

from __future__ import annotations

import argparse
import json
import shlex
import sys
import tarfile
from pathlib import Path

from outside import bits, bits_of_sources, expect, main, run, version_of


def check(arguments: argparse.Namespace) -> str:
    """The whole way; says what was run."""
    root, work = arguments.root, arguments.work
    home = {"PLATFORMIO_CORE_DIR": str(work / "core"), "PLATFORMIO_SETTING_ENABLE_TELEMETRY": "No"}
    said = run([Path(sys.executable).with_name("pio"), "pkg", "pack", root, "-o", work / "ema.tar.gz"], work, home)
    with tarfile.open(work / "ema.tar.gz") as pack:
        pack.extractall(work / "ema", filter="data")
    taken = work / "ema"
    manifest = json.loads((taken / "library.json").read_text(encoding="utf-8"))
    expect(manifest["version"] == version_of(root), f"library.json has version {manifest['version']}")
    foreign = sorted(
        {path.relative_to(taken).parts[0] for path in taken.rglob("*") if path.is_file()}
        - {"include", "src", "library.json", "LICENSE", "README.md", ".piopm"}
    )
    expect(not foreign, f"the pack holds {', '.join(foreign)} too: {said}")
    build = manifest["build"]
    flags = [word for line in build["flags"] for word in shlex.split(line)]
    includes = [taken / build["includeDir"]]
    stated = []
    while flags:
        word = flags.pop(0)
        if word == "-I":
            includes.append(taken / flags.pop(0))
        else:
            stated.append(word)
    expect(all(path.is_dir() for path in includes), "library.json: a folder of -I is not in the pack")
    built = bits(work, sorted((taken / build["srcDir"]).glob("*/*.c")), includes, stated)
    expect(built == bits_of_sources(root, work), "from PlatformIO's pack the bits are others")
    return "packed by PlatformIO, and the outside project built from the pack as its manifest says"


if __name__ == "__main__":
    sys.exit(main("platformio", check))
