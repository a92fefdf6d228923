"""What an actuator's file may leave out: the controller and the drive electronics where nobody knows them, lead and ratio of a bare motor. Nothing is put in their place.

A value that says "there is none" of something (no play, no limit, no delay) stands for an absent one; everything else that is absent stays so, and who asks for it is told.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from ema_tools.library.definitions import Parameter

# What makes a file one of a machine that is not known in full: without any of these being absent, all values must stand in it.
_SECTIONS = ("control", "drive")
_VALUES = ("screw.lead_mm", "gearbox.ratio")
# Values that state that there is none of what they are about.
NONE_OF_IT: Mapping[str, float] = {
    "drive.current_limit_A": 0.0,
    "drive.current_loop_s": 0.0,
    "drive.output_delay_s": 0.0,
    "drive.command_scale_V": 0.0,
    "motor.inductance_H": 0.0,
    "motor.torque_limit_Nm": 0.0,
    "gearbox.efficiency": 1.0,
    "screw.dynamic_ratio": 1.0,
    "screw.friction_asymmetry": 0.0,
    "screw.load_torque_Nm": 0.0,
    "screw.blk_mm": 0.0,
    "encoder.resolution_mm": 0.0,
    "encoder.delay_s": 0.0,
    "encoder.rod_gain_error": 0.0,
    "encoder.rod_offset_mm": 0.0,
}
# What every machine has, and no balance of forces can do without.
NEEDED = ("screw.inertia_kgm2", "screw.viscous_Nm_s_per_rad", "screw.csj_Nm")
WITHOUT = "ema compare and ema diagnose do without, by the balance of forces"


def is_incomplete(content: Mapping[str, Any]) -> bool:
    """Whether a file's content leaves out what may be left out."""
    return any(section not in content for section in _SECTIONS) or any(not _stated(content, name) for name in _VALUES)


def absent_sections(content: Mapping[str, Any]) -> tuple[str, ...]:
    """Of [control] and [drive] those that are not there."""
    return tuple(section for section in _SECTIONS if section not in content)


def left_out(content: Mapping[str, Any], rows: Iterable[Parameter]) -> tuple[frozenset[str], dict[str, float]]:
    """Of a file that is not complete: names of the values that are absent, and the values of what there is none of."""
    absent = [row.name for row in rows if not _stated(content, row.name)]
    return frozenset(name for name in absent if name not in NONE_OF_IT), {name: NONE_OF_IT[name] for name in absent if name in NONE_OF_IT}


def forgotten(content: Mapping[str, Any], rows: Sequence[Parameter]) -> tuple[Parameter, ...]:
    """Values that may not be left out where the file is not complete: those that every machine has, and those beside others of the controller or the drive."""
    return tuple(
        row
        for row in rows
        if not _stated(content, row.name) and (row.name in NEEDED or (row.section in _SECTIONS and row.section in content))
    )


def _stated(content: Mapping[str, Any], name: str) -> bool:
    section, _, key = name.partition(".")
    return key in content.get(section, {})
