"""The example firmware's configuration must be what `ema export` writes today for the reference actuator, remarks aside. Python's standard library alone."""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path


def without_remarks(text: str) -> str:
    """C without its comments."""
    return re.sub(r"\s*/\*.*?\*/", "", text, flags=re.DOTALL)


def main() -> int:
    """Entry point."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--python", type=Path, required=True, help="the Python of the tools")
    parser.add_argument("--root", type=Path, required=True, help="the project")
    parser.add_argument("header", type=Path, help="the header that the firmware compiles in")
    given = parser.parse_args()
    build = given.python.parents[2]
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "actuator.h"
        command = [str(given.python), "-B", "-m", "ema_tools", "export", str(given.root / "actuators" / "reference.toml"), "-o", str(out)]
        settings = {**os.environ, "EMA_LIBRARY_DIR": str(build / "lib"), "EMA_BIN_DIR": str(build / "bin"), "OPENBLAS_NUM_THREADS": "1"}
        done = subprocess.run(command, cwd=given.root / "tools", env=settings, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            print(f"ema export failed: {done.stderr.strip()}", file=sys.stderr)
            return 1
        text = out.read_text(encoding="utf-8")
    fresh = without_remarks(text)
    if "EMA_ACTUATOR" not in fresh or fresh != without_remarks(given.header.read_text(encoding="utf-8")):
        print(f"{given.header.name} is not what ema export writes: export actuators/reference.toml there again", file=sys.stderr)
        return 1
    print(f"{given.header.name}: {len(text.splitlines())} lines as exported")
    return 0


if __name__ == "__main__":
    sys.exit(main())
