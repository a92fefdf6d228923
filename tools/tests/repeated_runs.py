"""Runs of a machine that scatters from run to run, for the tests of the diagnosis."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache

import numpy as np

from ema_tools.data.actuator import reference_actuator
from ema_tools.data.records import Record
from support import chirp_record

NOISE = {"position_mm": 0.002, "motor_position_mm": 0.002, "current_A": 0.03}
REPEATS = 5
WIDE = "chirp:amplitude_mm=8,start_hz=0.1,end_hz=1.5"


def measured(changes: Mapping[str, float], seed: int, text: str = "chirp") -> Record:
    """One run of a machine whose friction and winding scatter, with `changes` in it."""
    random = np.random.default_rng(seed)
    model = reference_actuator()
    day = {"screw.csj_Nm": 0.138 * (1.0 + 0.004 * random.normal()), "motor.resistance_ohm": 0.99 * (1.0 + 0.003 * random.normal())}
    return replace(chirp_record(model.changed({**day, **changes}), text).with_noise(NOISE, seed), file=f"run {seed}")


@cache
def repeats(text: str = "chirp") -> tuple[Record, ...]:
    return tuple(measured({}, seed, text) for seed in range(1, REPEATS + 1))
