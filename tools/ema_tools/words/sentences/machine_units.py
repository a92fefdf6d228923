"""In which units the numbers of a machine are told: of one that turns Nm, kg m2 and motor turns, of one of which everything was recorded along a line N, kg and mm."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ema_tools.data.actuator import Actuator, row_of, shown
from ema_tools.data.linear_axis import VALUES, lead_m_per_rad
from ema_tools.data.motion_records import DRIVES, MOTIONS, AnyRecord

_SAME = 1e-3  # relative, of numbers of periods that are told as one [layout]
_AT_OUTPUT = 0.02  # relative, within which a swing is one of the output: a record of few turns of it shows no more [judgement]
_OUTPUT_MAX = 3  # times per turn of the output that are told as such: beyond, many ratios come near [judgement]
# Units of the shaft: what they are along the line, and by which power of the travel per angle in m/rad the number is multiplied.
_ALONG: Mapping[str, tuple[str, int, float]] = {
    "kg m2": ("kg", -2, 1.0),
    "Nm s/rad": ("N s/m", -2, 1.0),
    "Nm s2/rad2": ("N s2/m2", -3, 1.0),
    "Nm": ("N", -1, 1.0),
    "Nm/mm": ("N/mm", -1, 1.0),
    "rad/s": ("m/s", 1, 1.0),
    "rad": ("mm", 1, 1e3),
}
_LINEAR: Mapping[str, str] = dict(zip(VALUES, ("mass", "viscous friction", "dry friction", "load"), strict=True))


@dataclass(frozen=True)
class MachineUnits:
    """`ratio`: motor turns per turn of the output, one where there is no gear or none is stated; `m_per_rad`: rod travel per motor angle of a machine that is told along its line, else None."""

    ratio: float = 1.0
    m_per_rad: float | None = None

    def told(self, value: float, unit: str) -> tuple[float, str]:
        """A value in the unit of this machine, and that unit; one that is no thing of shaft or rod as it is."""
        if self.m_per_rad is None or unit not in _ALONG:
            return value, unit
        along, power, factor = _ALONG[unit]
        return value * factor * self.m_per_rad**power, along

    def title(self, name: str) -> str:
        """A base value by the name that it has in the actuator's file, or by what it is along a line."""
        return shown(row_of(name)) if self.m_per_rad is None else _LINEAR.get(row_of(name).name, shown(row_of(name)))

    def swing(self, periods: float) -> str:
        """How often something comes: per turn of the motor, of the output behind a gear, or along the way."""
        if self.m_per_rad is not None:
            return f"once every {2e3 * math.pi * self.m_per_rad / periods:.3g} mm"
        if math.isclose(periods, 1.0, rel_tol=_SAME):
            return "once per motor turn"
        if periods > 1.0:
            return f"{periods:.3g} times per motor turn"
        every = f"once every {1.0 / periods:.3g} motor turns"
        times = round(periods * self.ratio)
        if not 1 <= times <= _OUTPUT_MAX or abs(periods * self.ratio - times) > _AT_OUTPUT * times:
            return every
        if times > 1:
            return f"{times} times per turn of the output, {every}"
        return f"once per turn of the output, {every}: the weight of what turns there, or its unbalance, is one cause"


TURNING = MachineUnits()  # of a machine of which nothing is known but that it turns [layout]


def units_of(actuator: Actuator, records: Sequence[AnyRecord]) -> MachineUnits:
    """How the numbers of a machine are told, by what was recorded of it."""
    if not (actuator.has("screw.lead_mm") and actuator.has("gearbox.ratio")):
        return TURNING
    along = {name for record in records for name in record.present if name in (*MOTIONS, *DRIVES)}
    linear = "force_N" in along and along <= {"position_mm", "speed_mm_s", "force_N"}
    return MachineUnits(actuator["gearbox.ratio"], lead_m_per_rad(actuator) if linear else None)
