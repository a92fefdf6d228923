"""The answer of a whole session with a unit's own model: standing effects in the model, grease and winding of the day searched beside CSJ and BLK.

Not of the reference model but of the desk's float32 library, whose bits every build of the module must give, on its target as well.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping
from pathlib import Path

from ema_tools.base.errors import InputError
from ema_tools.data.actuator import read_actuator
from ema_tools.data.records import read_record
from ema_tools.plant.native import OUTCOMES, REASONS, STAGES, VERDICTS, Identification, SearchSettings
from ema_tools.tasks.onboard_search import run

FILES = {"annealer": "session_own_unit_annealer.json", "two_stages": "session_own_unit_two_stages.json"}  # by SearchSettings.search
UNIT = Path(__file__).resolve().parents[3] / "recordings" / "unit"
ACTUATOR, RECORD = "unit.toml", "worn.csv"
SEED = 1


def _bits(value: float) -> str:
    return struct.pack(">f", value).hex()


def _number(names: Mapping[int, str], name: str) -> str:
    return next(str(number) for number, known in names.items() if known == name)


def answer_of(found: Identification) -> dict[str, list[str]]:
    """What `ema_answer` prints behind each name: bits of float32, whole numbers."""
    values = (*found.identified, *found.day)
    reals = {name: getattr(found, name) for name in ("objective_before", "objective_after", "residual_rms_mm", "residual_correlation")}
    return {
        "estimate": [_bits(one.estimate) for one in values],
        "std": [_bits(one.std) for one in values],
        "half_95": [_bits(one.half_95) for one in values],
        "shift_percent": [_bits(one.shift_percent) for one in values],
        **{name: [_bits(value)] for name, value in reals.items()},
        "evaluations": [str(found.evaluations)],
        "model_steps": [str(found.model_steps)],
        "random": [f"{found.random_state:016x}"],
        "stage": [str(STAGES.index(found.stage))],
        "outcome": [_number(OUTCOMES, found.outcome)],
        "verdict": [_number(VERDICTS, found.verdict)],
        "adequate": [str(int(found.adequate))],
        "reasons": [f"{sum(bit for bit, text in REASONS.items() if text in found.reasons):08x}"],
    }


def answer(search: str) -> dict[str, list[str]]:
    """The answer of a `search` (of FILES) on the worn unit of the shipped recordings. Raises InputError where the session would not go the way that this is for."""
    unit = read_actuator(UNIT / ACTUATOR)
    found = run(unit, read_record(UNIT / RECORD, unit), SearchSettings(seed=SEED, search=search), 32)
    if len(found.day) != 2 or not unit.active_effects:
        raise InputError(f"{ACTUATOR}: no standing effects, or no values of the day: calibrate it on the unit's healthy runs")
    return answer_of(found)
