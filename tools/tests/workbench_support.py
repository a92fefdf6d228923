"""What the tests of the workbench share: its scripts in Node, and records on their way there."""

from __future__ import annotations

import base64
import json
import shutil
import subprocess
from collections.abc import Mapping, Sequence
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ema_tools.data.actuator import Actuator
from ema_tools.data.records import Record
from ema_tools.library.definitions import load_definitions
from ema_tools.plant.native import CHANNELS, SearchSettings
from ema_tools.words.page.workbench import module_path

ASSETS = Path(str(resources.files("ema_tools.words.page"))) / "assets"
_SCRIPT = Path(__file__).with_name("workbench_node.cjs")
NODE = shutil.which("node")

needs_node = pytest.mark.skipif(NODE is None, reason="no node: install the package nodejs to run the workbench's scripts")
needs_module = pytest.mark.skipif(
    not module_path().is_file(), reason=f"no ema.wasm in {module_path().parent}: install clang and lld, then build the project again"
)


def packed(values: object) -> str:
    """Numbers as float64 in base64."""
    return base64.b64encode(np.ascontiguousarray(values, dtype="<f8").tobytes()).decode("ascii")


def unpacked(text: str) -> np.ndarray[Any, Any]:
    """What `packed`, or the script in Node, made."""
    return np.frombuffer(base64.b64decode(text), dtype="<f8")


def in_node(jobs: Sequence[Mapping[str, Any]], module: bool = True) -> list[dict[str, Any]]:
    """The answers of the workbench's scripts, each with `answer` or `error`."""
    given = {"assets": str(ASSETS), "wasm": str(module_path()) if module else None, "jobs": jobs}
    assert NODE is not None
    ran = subprocess.run([NODE, str(_SCRIPT)], input=json.dumps(given), capture_output=True, text=True, timeout=300, check=False)
    assert ran.returncode == 0, ran.stderr
    found: list[dict[str, Any]] = json.loads(ran.stdout)
    return found


def columns(record: Record) -> dict[str, str]:
    """A record for the scripts."""
    return {name: packed(record.recorded(name)) for name in record.present}


def model(actuator: Actuator) -> dict[str, Any]:
    """A model for the scripts."""
    values, options = actuator.arrays()
    return {"values": values.tolist(), "options": options.tolist()}


def search(settings: SearchSettings) -> dict[str, Any]:
    """Settings of a fit, as the scripts hand them to the module."""
    assert settings.identified and settings.lower and settings.upper and settings.min_shift_percent and settings.weight
    ids = load_definitions().ids
    return {
        "identified_count": len(settings.identified),
        "identified_id": [ids[name] for name in settings.identified],
        "identified_lower": list(settings.lower),
        "identified_upper": list(settings.upper),
        "identified_min_shift_percent": list(settings.min_shift_percent),
        "weight": list(settings.weight),
    }


def weights(noise: Mapping[str, float]) -> tuple[float, float, float, float]:
    """1 on the rod position, the others by how noisy they are beside it."""
    four = [(noise["position_mm"] / noise[name]) ** 2 if name in noise else 0.0 for name in CHANNELS]
    return four[0], four[1], four[2], four[3]
