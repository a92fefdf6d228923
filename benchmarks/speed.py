"""Runs the C module's benchmark program and says on what machine."""

from __future__ import annotations

import platform
import subprocess
from dataclasses import dataclass
from pathlib import Path

from ema_tools.base.errors import InputError


@dataclass(frozen=True)
class Measured:
    """What the program printed, and the processor it ran on."""

    text: str
    processor: str


def measure(program: Path) -> Measured:
    """Run the benchmark program. Raises InputError when it is absent or fails."""
    try:
        done = subprocess.run([str(program)], capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError) as error:
        raise InputError(f"{program}: cannot be run ({error}): build the tests first (cmake --workflow --preset test)") from None
    return Measured(done.stdout.rstrip(), _processor())


def _processor() -> str:
    """Name of the processor as the system tells it."""
    information = Path("/proc/cpuinfo")
    if information.is_file():
        for line in information.read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()
