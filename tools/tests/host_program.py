"""Running the built program `ema_identify` in a test."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
_FOLDER = os.environ.get("EMA_BIN_DIR")
_PATH = (Path(_FOLDER) if _FOLDER else ROOT / "build" / "bin") / "ema_identify"

# With a folder named, an absent program is a failure; without, there was no build.
PROGRAM = pytest.mark.skipif(not _FOLDER and not _PATH.exists(), reason="ema_identify is not built: build it, or set EMA_BIN_DIR")


def run(folder: Path, *arguments: str) -> subprocess.CompletedProcess[bytes]:
    """Runs the program in `folder`. Raises FileNotFoundError when it is not built."""
    return subprocess.run([_PATH, *arguments], cwd=folder, capture_output=True, timeout=120, check=False)
