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
from ema_tools.library.faults import FAULTS
from ema_tools.results.workbench import BenchEntry
from ema_tools.words.page import workbench
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


def page_data(entry: BenchEntry) -> dict[str, Any]:
    """A job for the scripts: the page's own data, with the record's columns and a diagnosis' weights as float64."""
    data = workbench.payload(entry)
    data["module"] = ""
    if entry.weighed is not None:
        for key, columns in (("target", entry.weighed.target), ("weights", entry.weighed.weights)):
            data["weighed"][key] = {name: packed(_single(text)) for name, text in columns.items()}
    faults = [row for row in data["rows"] if row["name"] in FAULTS.values()]
    record = {name: packed(_single(text)) for name, text in entry.columns.items()}
    return {"data": data, "record": record, "rows": faults, "effects": [one for one in data["effects"] if one["ranked"]]}


def _single(text: str) -> np.ndarray[Any, Any]:
    return np.frombuffer(base64.b64decode(text), dtype="<f4")
