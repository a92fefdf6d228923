"""What to measure on the machine itself to tell effects apart where no command does. The records of effects and faults say which of these separate them from others."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Measurement:
    """What to do, and why that separates."""

    do: str
    because: str


TURN_OVER = Measurement(
    "turn the actuator over, or measure it cold and warm, and look at the current with the drive off",
    "a weight changes its sign against the rod and an asymmetry of friction does not, an asymmetry follows the level of friction and a load does not, "
    "and an offset of the current sensor, the third that looks like them, stays when the drive is off",
)
CONTROLLERS_CLOCK = Measurement(
    "record what the controller itself sees, with its own clock", "a late feedback is late there, a late output is not"
)
BUS_AND_WINDING = Measurement(
    "measure the bus voltage under load, and the winding at standstill with an ohmmeter",
    "a winding keeps its resistance at rest, a supply sags only under current",
)
BACK_EMF = Measurement(
    "turn the motor from outside and measure its voltage, or lift a known weight",
    "the back-EMF without current shows the magnet alone, and a known weight the torque",
)
LONG_STROKE = Measurement(
    "let the stroke pass several leads of the screw", "a spring grows all the way, a ripple repeats every lead or turn"
)
OUTSIDE_FORCE = Measurement(
    "record both positions while a known outside force pushes the rod to and fro, motor held",
    "play moves freely, a spring in proportion, a contact in micrometres",
)
GAUGE = Measurement(
    "hold a gauge or a second sensor against the rod at a few positions", "a sensor's error is in the reading alone, not in the rod"
)
BREAK_AWAY = Measurement(
    "raise the drive slowly from rest at several places and note where the rod breaks away", "the static level shows before any motion"
)
CONSTANT_SPEEDS = Measurement(
    "hold several constant speeds in both directions", "torque against speed then shows its curve without any acceleration"
)
TAP_THE_ROD = Measurement(
    "tap the rod with the drive off, or fasten a known mass to it", "inertia and spring act without the loop, a delay only in it"
)
CONTROLLERS_OUTPUT = Measurement("record the controller's own output", "a drifting gain changes it for the same error, a supply does not")

# In the order in which they are advised.
MEASUREMENTS = (
    TURN_OVER,
    CONTROLLERS_CLOCK,
    BUS_AND_WINDING,
    BACK_EMF,
    LONG_STROKE,
    OUTSIDE_FORCE,
    GAUGE,
    BREAK_AWAY,
    CONSTANT_SPEEDS,
    TAP_THE_ROD,
    CONTROLLERS_OUTPUT,
)
