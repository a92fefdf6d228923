"""Any result file as its type."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ema_tools.base.errors import InputError
from ema_tools.base.files import read_json
from ema_tools.results.addition import Addition
from ema_tools.results.calibration import CalibrationResult
from ema_tools.results.codec import check_format, from_json
from ema_tools.results.comparison import ComparisonResult
from ema_tools.results.detection import DetectionResult
from ema_tools.results.diagnosis import DiagnosisByBalanceResult, DiagnosisResult
from ema_tools.results.effects import Effects
from ema_tools.results.experiment import Experiment
from ema_tools.results.files import (
    DemoResult,
    DraftResult,
    ExportResult,
    ImportResult,
    LoopResult,
    ReportResult,
    SimulationResult,
    TableImportResult,
)
from ema_tools.results.fleet import FleetResult
from ema_tools.results.friction_map import MapResult
from ema_tools.results.identification import IdentificationResult
from ema_tools.results.telemetry import TelemetryResult

Result = (
    Addition
    | CalibrationResult
    | ComparisonResult
    | DetectionResult
    | DiagnosisResult
    | DiagnosisByBalanceResult
    | DraftResult
    | Effects
    | Experiment
    | ExportResult
    | FleetResult
    | IdentificationResult
    | ImportResult
    | LoopResult
    | MapResult
    | ReportResult
    | DemoResult
    | SimulationResult
    | TableImportResult
    | TelemetryResult
)

_BY_COMMAND: Mapping[str, type[Result]] = {
    "add": Addition,
    "calibrate": CalibrationResult,
    "compare": ComparisonResult,
    "effects": Effects,
    "export": ExportResult,
    "fleet": FleetResult,
    "identify": IdentificationResult,
    "import draft": DraftResult,
    "import emps": ImportResult,
    "import table": TableImportResult,
    "loop": LoopResult,
    "map": MapResult,
    "next": Experiment,
    "report": ReportResult,
    "simulate": SimulationResult,
    "telemetry": TelemetryResult,
}


def kind_of(data: Mapping[str, Any], source: str) -> type[Result]:
    """The type of a result: by its command, and by its keys where one command writes two kinds. Raises InputError for what is no result."""
    command = data.get("command")
    if command == "diagnose":
        return DiagnosisByBalanceResult if "forces" in data else DiagnosisResult
    if command == "next" and "detect" in data:
        return DetectionResult
    if command == "demo":
        return DemoResult if "page" in data else IdentificationResult
    if command is None and ("csj_Nm" in data or "blk_mm" in data):
        return IdentificationResult
    if command is None and "balances" in data:
        return ComparisonResult
    kind = _BY_COMMAND.get(command) if isinstance(command, str) else None
    if kind is None:
        raise InputError(
            f"{source}: holds no `command` of ema, and none of `csj_Nm`, `blk_mm` and `balances`: give a file that --json wrote"
        )
    return kind


def result_of(data: Mapping[str, Any], source: str) -> Result:
    """The result that a JSON object holds. Raises InputError that names `source` and the field."""
    check_format(data, source)
    return from_json(data, kind_of(data, source), source)


def read_result(path: Path) -> Result:
    """The result of a file. Raises InputError when it cannot be read, is no JSON, or is not as its type says."""
    return result_of(read_json(path), str(path))
