"""The cases of the reference vectors: what is set, what is commanded, how far C may be away and why."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from ema_tools.library.definitions import Effect, load_definitions
from ema_tools.library.registry import record_of
from reference_model.effects import example_of

CHANNELS = ("position_mm", "motor_position_mm", "current_A", "voltage_V", "speed_mm_s")


@dataclass(frozen=True)
class Command:
    """The fields of `ema_command_config_t` that `kind` reads."""

    kind: str
    amplitude_mm: float = 0.0
    start_hz: float = 0.0
    end_hz: float = 0.0
    duration_s: float = 0.0
    share: float = 1.0
    count: int = 1
    time_s: float = 0.0


@dataclass(frozen=True)
class Tolerance:
    """Largest deviation allowed, per channel in the order of CHANNELS, in any row and in the mean square over the rows."""

    name: str
    largest: tuple[float, ...]
    rms: tuple[float, ...]
    why: str

    def scaled(self, factor: float, name: str, why: str) -> Tolerance:
        """Wider by `factor` in every channel, under another name, for the reason `why`."""
        largest = tuple(value * factor for value in self.largest)
        return Tolerance(name, largest, tuple(value * factor for value in self.rms), why)


EXACT64 = Tolerance(
    "exact64",
    (2e-8, 2e-8, 2e-6, 2e-6, 2e-6),
    (5e-9, 5e-9, 5e-7, 5e-7, 5e-7),
    "the plant is linear between events and its input is held, so a step is exact; left are the resolution of located"
    " events and the remainder of the reference, a hundred thousand times below the accuracy goal",
)
ROUNDED32 = Tolerance(
    "rounded32",
    (3e-5, 3e-5, 3e-4, 4e-4, 2e-3),
    (1e-5, 1e-5, 8e-5, 1e-4, 3e-4),
    "rounding of float32: the frequencies of the command shift its phase by up to 8e-6 rad, 1.6e-5 mm; positions to 2.4e-7 mm"
    " at 2 mm, seen through the loop's gain of 9.6 V/mm; a twentieth of the accuracy goal",
)
IN_MOTION = Tolerance(
    "in_motion",
    (1e-4, 1e-4, 4e-3, 2e-3, 5e-3),
    (4e-5, 4e-5, 5e-4, 4e-4, 1e-3),
    "the effect acts in motion, so a step is no longer exact; a fifth of the accuracy goal of 0.2 um, half of that of 1 mA",
)
SATURATED = IN_MOTION.scaled(2.0, "saturated", "the torque enters and leaves its limit inside a step, at a moment found to a part of it")
STRETCHED = IN_MOTION.scaled(
    2.0,
    "stretched",
    "the reversal of a contact that stretches is not located: the play sees the turning point to a part of an integration step",
)
TOUCHED = Tolerance(
    "touched",
    (2e-4, 2e-4, 2e-2, 2e-3, 5e-3),
    (4e-5, 4e-5, 5e-4, 4e-4, 1e-3),
    "a current that reaches its limit and leaves it again inside one step is not seen: a few steps of the record, by up to 0.4 %"
    " of the limit; half of the accuracy goal of 1 mA rms",
)
SOFT = Tolerance(
    "soft",
    (5e-4, 1e-4, 4e-3, 2e-3, 1e-1),
    (2e-4, 4e-5, 5e-4, 4e-4, 2e-2),
    "a rod of 40 Hz, excited by every contact of the play: the accuracy goal of 0.2 um at the rod, seen as speed 250 times"
    " as large, and a fifth of it at the motor",
)
FLIPPED32 = Tolerance(
    "flipped32",
    (5e-4, 5e-4, 8e-2, 0.1, 0.1),
    (1e-4, 1e-4, 1e-2, 1e-2, 1e-2),
    "a feedback within rounding of float32 of the edge of a 5 um step may read one step more: 0.048 V for one step, at most two at a time",
)


@dataclass(frozen=True)
class Case:
    """One record of the whole model, with values that bring out one block or effect."""

    name: str
    shows: str
    command: Command
    steps: int
    every_rows: int
    values: dict[str, float] = field(default_factory=dict)
    start_mm: float = 0.0
    tolerance64: Tolerance = EXACT64
    tolerance32: Tolerance = ROUNDED32


REFERENCE_CHIRP = Command("CHIRP", 2.0, 0.1, 4.0, 10.0)
SHORT_CHIRP = Command("CHIRP", 2.0, 0.2, 4.0, 2.5)

_OPEN_LOOP = {"screw.lead_mm": 0.5, "gearbox.ratio": 100.0, "control.ki_per_m_s": 0.0, "screw.blk_mm": 0.0}

_BLOCK_CASES: tuple[Case, ...] = (
    Case("whole_healthy", "reference chirp, healthy", REFERENCE_CHIRP, 10_000, 20),
    Case(
        "whole_case_a",
        "reference chirp, CSJ 0.3 Nm, BLK 0.04125 mm",
        REFERENCE_CHIRP,
        10_000,
        20,
        {"screw.csj_Nm": 0.3, "screw.blk_mm": 0.04125},
    ),
    Case(
        "whole_start_aside",
        "start at 5 mm, command to zero and on",
        Command("STEP", -1.0, time_s=0.3),
        800,
        4,
        start_mm=5.0,
    ),
    Case(
        "whole_periods",
        "control at every fourth step, record at every second",
        SHORT_CHIRP,
        2_000,
        5,
        {"control.every_steps": 4, "timing.record_every_steps": 2, "timing.step_s": 5e-4, "control.kp_per_m": 200.0},
    ),
    # 1. PID control logic
    Case(
        "pid_derivative_of_error",
        "PID with derivative of the error",
        Command("TRIANGLE", 2.0, 2.0),
        1_000,
        5,
        {"control.kd_s_per_m": 2.0},
    ),
    Case(
        "pid_derivative_of_speed",
        "PID with derivative of the averaged measured position",
        Command("STEP", 3.0, time_s=0.05),
        500,
        2,
        {"control.kd_s_per_m": 3.0, "control.derivative": 1, "control.average_speed": 1},
    ),
    Case(
        "pid_anti_windup",
        "output saturated for long, integrator held back",
        Command("STEP", 15.0, time_s=0.02),
        900,
        4,
        {"control.ki_per_m_s": 4_000.0, "control.output_limit": 0.6},
        tolerance32=ROUNDED32.scaled(6.0, "rounded32_15_mm", "rounding of float32 on a stroke of 15 mm, and a tenfold integral gain"),
    ),
    Case(
        "pid_cascade",
        "position loop over speed loop, limited speed",
        Command("TRAPEZOID", 5.0, 1.0, share=0.3),
        1_500,
        6,
        {
            "control.structure": 1,
            "control.position_gain_per_s": 30.0,
            "control.speed_gain_s_per_m": 10.0,
            "control.speed_integral_per_m": 200.0,
            "control.speed_limit_m_s": 0.03,
            "control.average_speed": 1,
        },
        tolerance32=ROUNDED32.scaled(
            3.0, "rounded32_5_mm", "rounding of float32 on a stroke of 5 mm, through a speed gain that makes 24 V of 0.1 m/s"
        ),
    ),
    # 2. controller and drive electronics
    Case("drive_voltage", "voltage mode at a low bus voltage", SHORT_CHIRP, 2_500, 10, {"drive.supply_V": 16.0}),
    Case(
        "drive_current_loop",
        "current mode with a loop of 0.7 ms, terminal voltage recorded",
        SHORT_CHIRP,
        2_500,
        10,
        {"drive.mode": 1, "drive.current_scale_A": 10.0, "drive.current_loop_s": 7e-4, "control.kd_s_per_m": 8.0},
    ),
    Case(
        "drive_current_saturated",
        "current mode that runs into the bus voltage",
        Command("STEP", 10.0, time_s=0.02),
        500,
        2,
        {"drive.mode": 1, "drive.current_scale_A": 20.0, "drive.current_loop_s": 5e-4, "control.kd_s_per_m": 8.0},
        tolerance32=ROUNDED32.scaled(
            12.0, "rounded32_10_mm", "rounding of float32 on a stroke of 10 mm, through a derivative gain of 160 A s/m over 1 ms"
        ),
    ),
    Case(
        "drive_current_at_once",
        "ideal current mode with a scaled command as recorded voltage",
        Command("MULTISINE", 1.5, 0.8, duration_s=2.5, count=5),
        2_000,
        8,
        {"drive.mode": 1, "drive.current_scale_A": 10.0, "drive.command_scale_V": 10.0, "control.kd_s_per_m": 8.0},
    ),
    Case(
        "drive_current_limit",
        "voltage mode with the current held at 6 A",
        Command("STEP", 4.0, time_s=0.02),
        400,
        2,
        {"drive.current_limit_A": 6.0},
    ),
    Case(
        "drive_output_delay",
        "current mode that passes the output on 0.6 of a step late and runs into the bus voltage",
        SHORT_CHIRP,
        2_500,
        20,
        {
            "drive.output_delay_s": 6e-4,
            "drive.mode": 1,
            "drive.supply_V": 14.0,
            "drive.current_scale_A": 10.0,
            "drive.current_loop_s": 7e-4,
            "control.kd_s_per_m": 8.0,
        },
    ),
    # 3. motor
    Case(
        "motor_locked",
        "shaft stuck: the current rises with L/R",
        Command("STEP", 1.0, time_s=0.002),
        100,
        1,
        {"screw.csj_Nm": 100.0, "control.ki_per_m_s": 0.0},
    ),
    Case(
        "motor_torque_saturation",
        "torque limited at 0.35 Nm",
        SHORT_CHIRP,
        2_500,
        10,
        {"motor.torque_limit_Nm": 0.35},
        tolerance64=SATURATED,
        tolerance32=SATURATED,
    ),
    Case("motor_no_inductance", "current in balance with the voltage", SHORT_CHIRP, 2_500, 10, {"motor.inductance_H": 0.0}),
    # 4. gearbox
    Case(
        "gearbox_efficiency",
        "load of 0.2 Nm opposing and aiding, efficiency 0.8",
        Command("TRIANGLE", 2.0, 1.0),
        2_000,
        8,
        {"gearbox.efficiency": 0.8, "screw.load_torque_Nm": 0.2},
    ),
    # 5. ball screw
    Case(
        "screw_coast_down",
        "driven by a pulse of current, then free until dry friction stops it",
        Command("CHIRP", 100.0, 10.0, 10.0, 0.05),
        200,
        1,
        {
            **_OPEN_LOOP,
            "drive.mode": 1,
            "drive.current_scale_A": 10.0,
            "control.kp_per_m": 5.0,
            "screw.csj_Nm": 0.05,
        },
    ),
    Case(
        "screw_stick_slip",
        "static level twice the dynamic one: sticks at every reversal, then slips",
        Command("TRIANGLE", 1.0, 2.0),
        2_000,
        8,
        {"screw.csj_Nm": 0.3, "screw.dynamic_ratio": 0.5},
    ),
    Case(
        "screw_asymmetry",
        "dry friction 20 % larger forward and smaller backward, static above dynamic",
        SHORT_CHIRP,
        2_500,
        20,
        {"screw.friction_asymmetry": 0.2, "screw.dynamic_ratio": 0.8},
    ),
    Case(
        "screw_stays",
        "a command too small to break away",
        Command("TRIANGLE", 0.1, 2.0),
        500,
        4,
        {"control.ki_per_m_s": 0.0, "screw.csj_Nm": 0.3},
    ),
    Case(
        "screw_backlash",
        "strokes below and above a play of 0.3 mm",
        Command("MULTISINE", 0.4, 0.5, duration_s=2.0, count=7),
        2_000,
        8,
        {"screw.blk_mm": 0.3},
    ),
    Case("screw_no_backlash", "no play at all", SHORT_CHIRP, 2_500, 10, {"screw.blk_mm": 0.0}),
    Case(
        "screw_ends",
        "travel shorter than the stroke",
        Command("CHIRP", 2.0, 1.0, 3.0, 2.0),
        2_000,
        8,
        {"screw.travel_mm": 1.25},
    ),
    # 6. encoder network
    Case(
        "encoder_delay",
        "feedback 2.3 steps old",
        SHORT_CHIRP,
        2_500,
        10,
        {"encoder.delay_s": 2.3e-3, "control.kp_per_m": 250.0},
    ),
    Case(
        "encoder_rod",
        "loop closed over the rod sensor with gain error and offset, play inside the loop",
        SHORT_CHIRP,
        2_500,
        10,
        {"encoder.side": 1, "encoder.rod_gain_error": 0.01, "encoder.rod_offset_mm": 0.05},
    ),
    Case(
        "encoder_resolution",
        "feedback in steps of 5 um",
        SHORT_CHIRP,
        2_500,
        10,
        {"encoder.resolution_mm": 0.005},
        tolerance32=FLIPPED32,
    ),
)


def _of_effect(effect: Effect) -> Case:
    """The record that shows one effect, at the values of its reference module."""
    values = example_of(effect.name)
    shows = ", ".join(f"{name} {value:g}" for name, value in values.items())
    case = Case(f"effect_{effect.name}", shows, SHORT_CHIRP, 2_500, 20, values)
    if record_of(effect.name).below_peak is not None:
        tolerance = TOUCHED
    elif effect.site in ("PARAMETER", "READING"):
        return case
    else:
        tolerance = {"TRANSMISSION": SOFT, "PRESLIDING": STRETCHED}.get(effect.site, IN_MOTION)
    return replace(case, tolerance64=tolerance, tolerance32=tolerance)


CASES: tuple[Case, ...] = (*_BLOCK_CASES, *map(_of_effect, load_definitions().effects))
