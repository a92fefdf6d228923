"""The balance of the controller: applied command - control law of command and feedback."""

from __future__ import annotations

from ema_tools.balances.balance import Balance
from ema_tools.balances.effects import adjusted
from ema_tools.balances.filtering import Smoother
from ema_tools.base.arrays import Reals
from ema_tools.base.errors import MissingSignal
from ema_tools.data.actuator import Actuator
from ema_tools.data.records import Record
from ema_tools.plant.native import library


def feedback_of(actuator: Actuator, record: Record) -> Reals:
    """The position that the loop is closed on, as recorded, mm [rows]. Raises MissingSignal."""
    if actuator["encoder.side"] == 1.0:
        return record.position_mm
    if record.motor_position_mm is not None:
        return record.motor_position_mm
    raise MissingSignal("motor_position_mm is not recorded, and the loop is closed on the motor encoder")


def controller_output(actuator: Actuator, command_mm: Reals, feedback_mm: Reals) -> Reals:
    """Normalised output of the control law for measured command and feedback, both [rows], one row per record period.

    Raises MissingSignal when the control law runs between the rows.
    """
    row_steps = int(actuator["timing.record_every_steps"])
    if int(actuator["control.every_steps"]) % row_steps:
        raise MissingSignal("the control law runs between the recorded rows")
    if row_steps > 1 and adjusted(actuator)["encoder.delay_s"] > 0.0:
        raise MissingSignal("the feedback's delay needs a row at every model step")
    return library().controller(*actuator.arrays(), command_mm, feedback_mm)


def controller(actuator: Actuator, record: Record) -> Balance:
    """Applied command minus the control law of measured command and feedback, in V. Raises MissingSignal."""
    if record.voltage_V is None:
        raise MissingSignal("voltage_V is not recorded")
    values = adjusted(actuator)
    if actuator["drive.mode"] == 1.0:
        scale = values["drive.command_scale_V"]
        if not scale > 0.0:
            raise MissingSignal("the drive's command is not recorded, only the motor's voltage")
    else:
        scale = values["drive.supply_V"]
    output = controller_output(actuator, record.command_mm, feedback_of(actuator, record))
    inner = Smoother.of(record.period_s).inner
    return Balance("controller", "V", inner(record.time_s), inner(record.voltage_V), inner(record.voltage_V - scale * output))
