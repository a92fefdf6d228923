"""The kinematic balance: rod position - play of the motor position."""

from __future__ import annotations

from ema_tools.balances.balance import Balance
from ema_tools.balances.effects import adjusted, transmission_of
from ema_tools.balances.filtering import Smoother
from ema_tools.balances.motion import learned_reading_mm
from ema_tools.base.errors import MissingSignal
from ema_tools.data.actuator import Actuator
from ema_tools.data.records import Record
from ema_tools.plant.native import library


def kinematic(actuator: Actuator, record: Record) -> Balance:
    """Rod position minus the motor position behind the play, mm. Raises MissingSignal."""
    if record.motor_position_mm is None:
        raise MissingSignal("motor_position_mm is not recorded")
    transmission = transmission_of(actuator)
    if transmission:
        raise MissingSignal(f"{transmission} moves the rod on its own; compare position_mm instead")
    values = adjusted(actuator)
    gain, offset = 1.0 + values["encoder.rod_gain_error"], values["encoder.rod_offset_mm"]
    rod = library().play(*actuator.arrays(), record.motor_position_mm, (float(record.position_mm[0]) - offset) / gain)
    inner = Smoother.of(record.period_s).inner
    return Balance(
        "kinematic",
        "mm",
        inner(record.time_s),
        inner(record.position_mm),
        inner(record.position_mm - (gain * rod + offset + learned_reading_mm(actuator, rod))),
    )
