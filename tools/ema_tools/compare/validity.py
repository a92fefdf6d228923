"""Can this record answer the question at all: signals, units, signs and clock, saturation, and what the motion covers. Looked at before anything is concluded.

Every remark says how much it matters, in one sentence what is the case, and what to do next. `blocks`: no answer from this record means anything; `weakens`: some effects cannot be seen, or are
doubtful; `fine`: looked at, nothing wrong.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from ema_tools.balances.filtering import Smoother
from ema_tools.balances.mechanical import filter_of
from ema_tools.balances.motion import drive_current, motor_position
from ema_tools.base.arrays import Reals
from ema_tools.base.errors import MissingSignal
from ema_tools.base.filters import correlated
from ema_tools.base.noise import white_noise
from ema_tools.compare.axes import MachineState, machine_state_of
from ema_tools.compare.comparison import TITLES, UNITS
from ema_tools.data.actuator import Actuator
from ema_tools.data.records import Record, simulated
from ema_tools.plant.native import Simulation
from ema_tools.results.validity import Severity

# What a record without a signal does not show.
HIDES = {
    "position_mm": "nothing can be said without it",
    "motor_position_mm": "play, compliance and errors of the rod sensor are told apart only by their shape, and the kinematic balance cannot be drawn",
    "current_A": "torque effects and electrical effects look alike, and neither the mechanical nor the electrical balance can be drawn",
    "voltage_V": "effects of winding, inverter and supply show only through the motion, and neither the electrical nor the controller's balance can be drawn",
}
_SCALE_DOUBTFUL = 3.0  # scale of a signal against the model that few effects reach ... [judgement]
_SCALE_WRONG = 10.0  # ... and that none does: the unit is another one, and units differ by ten or more [physics]
_ALIKE = 0.5  # a record follows the model that it belongs to at least so closely, as a correlation [judgement]
_OPPOSITE = -0.5  # one that does the opposite so closely has its sign wrong [judgement]
_LAG_MAX_S = 0.05  # lags are sought up to here: later than any feedback [physics]
_LAG_DOUBTFUL_S = 0.015  # a rod later than this behind the model: no effect of a usual size delays it by more [judgement]
_AHEAD_S = 0.01  # no effect makes a rod move this long before the model [physics]
_LAG_BETWEEN_S = 0.003  # two positions of one record are this much in step: beyond play, they are one shaft [physics]
_LIMIT_SHARE = 0.995  # of the largest voltage: from here on the drive is at its limit; rounding and noise are below the rest [judgement]
_SATURATED_WEAKENS = 0.2  # share of the time at the limit from which on the answer is weaker ... [judgement]
_SATURATED_BLOCKS = 0.8  # ... and none: the loop is then hardly closed [judgement]
_CLIPPED_ROWS = 4  # rows at one extreme value: noise repeats a value twice, seldom thrice [chance]
_STUCK_S = 0.02  # a value held this long, while the model moves by ... [judgement]
_STUCK_MOVES = 0.1  # ... this share of its range, is of a sensor that is held [judgement]
_STUCK_BLOCKS = 0.05  # a sensor that is held for this share of the record leaves too little of it [judgement]
_PLAYS = 5.0  # a rod may rest while the motor crosses the play, which wear may have made so many times its healthy size [judgement]
_SPIKE_NOISE = 30.0  # a jump of one or two rows and back: so far beyond the noise ... [chance]
_SPIKE_SHARE = 0.2  # ... and beyond this share of the signal no machine makes it [physics]
_SPIKE_WINDOW = 7  # rows of the median that it is seen against: twice its length and more [precision]
_REVERSALS_MIN = 6  # with fewer, friction and play have hardly been seen from both sides [judgement]
_TURN_SHARE = 0.01  # a reversal is a way back of this share of the stroke ... [judgement]
_TURN_NOISE = 5.0  # ... and of so many times the noise [chance]
_SLOW_SHARE = 0.05  # of the largest speed: slower is near standstill [judgement]
_BINS = 10  # parts of the ranges of speed and position, of which those that were visited are counted [judgement]
_MOVING_MIN = 20.0  # a stroke below so many times the noise is no motion [judgement]
_IDENTICAL = 1e-9  # mm: two records that differ by less are copies; noise differs by more [precision]
_IS_COMMAND = 0.05  # a rod that errs from the command by less than this share of the motor's error is the command itself [judgement]
# A rod ahead of its motor by so many standard errors, and by this share of its sensor's noise: two sensors differ in their gain and age, which are fitted
# beside it [chance]
_EXCHANGED_STD, _EXCHANGED_NOISE = 8.0, 0.5
# The law of the winding says nothing of exchanged columns where the speed makes less of the voltage than this share .. [judgement]
_BACK_EMF_SHARE = 0.2
_WINDING_LEFT = 0.5  # .. or where it leaves more than this share: another drive, other signals [judgement]
_ROWS_PER_PERIOD = 20.0  # of the fastest part of the command: fewer show the motion as corners [judgement]


@dataclass(frozen=True)
class RecordRemark:
    """One thing looked at: what about, how much it matters, a sentence, and what to do next (empty where nothing is to be done); `sensor`: it is a sensor's or a recorder's, no machine does so."""

    topic: str
    severity: Severity
    text: str
    next: str = ""
    sensor: bool = False

    def of(self, *files: str) -> str:
        """What is said of the first of these files, which is named where the remark itself names none of them."""
        text = self.text if any(self.text.startswith(f"{one} ") for one in files) else f"{files[0]}: {self.text}"
        return f"{text}: {self.next}"


@dataclass(frozen=True)
class RecordValidity:
    """The judgement of a record. `signals`: by name whether it is there; `coverage`: numbers about the motion."""

    signals: dict[str, bool]
    remarks: tuple[RecordRemark, ...]
    coverage: dict[str, float]

    @property
    def answerable(self) -> bool:
        """Whether anything that follows means something."""
        return all(remark.severity != "blocks" for remark in self.remarks)


def judge(actuator: Actuator, record: Record, healthy: Sequence[Record] = ()) -> RecordValidity:
    """Judges a record and the healthy repeats that it is to be compared with. Raises InputError when the model refuses the actuator."""
    present = {name: record.channel(name) is not None for name in HIDES}
    smoother = Smoother.of(record.period_s)
    if record.rows < smoother.least_rows:
        wanted = smoother.least_rows * record.period_s
        short = RecordRemark(
            "coverage",
            "blocks",
            f"{record.file} has {record.rows} rows, {record.rows * record.period_s:g} s, too few for any filter",
            f"record {wanted:g} s or more, best a chirp of ten",
        )
        return RecordValidity(present, (short,), {})
    smoother = filter_of(actuator, record)
    motion = machine_state_of(actuator, record, smoother)
    run = simulated(actuator, record)
    coverage = _coverage(actuator, record, motion, smoother)
    remarks = [*_signals(actuator, record), *_repeats(actuator, record, healthy, smoother, run), *_coverage_remarks(actuator, coverage)]
    if coverage["stroke_mm"] > 0.0 and not any(remark.severity == "blocks" for remark in remarks):
        remarks += [*_units(actuator, record, run), *_clock(actuator, record, run, smoother), *_sampling(actuator, record, coverage)]
        remarks += _exchanged(record, smoother)
        remarks += [
            *_saturation(actuator, record),
            *_clipping(record),
            *_spikes(record),
            *_stuck(actuator, record, run),
            *_start(actuator, record, motion),
        ]
    rank = {"blocks": 0, "weakens": 1, "fine": 2}
    return RecordValidity(present, tuple(sorted(remarks, key=lambda remark: rank[remark.severity])), coverage)


def _signals(actuator: Actuator, record: Record) -> list[RecordRemark]:
    missing = [name for name in HIDES if record.channel(name) is None]
    found = []
    for name in missing:
        other = _instead(actuator, record, name)
        if other:
            found.append(RecordRemark("signals", "fine", f"{name} is not recorded; {other} stands for it"))
        else:
            found.append(RecordRemark("signals", "weakens", f"{name} is not recorded: {HIDES[name]}", f"record {name} too"))
    return found or [RecordRemark("signals", "fine", "rod position, motor position, current and voltage are recorded")]


def _instead(actuator: Actuator, record: Record, name: str) -> str:
    """What stands for a signal that is not recorded; empty for nothing."""
    try:
        if name == "current_A":
            drive_current(actuator, record)
            return "the command of the ideal current drive"
        if name == "motor_position_mm":
            motor_position(actuator, record)
            return "the rod position, since nothing lies between,"
    except MissingSignal:
        return ""
    return ""


def _repeats(actuator: Actuator, record: Record, healthy: Sequence[Record], smoother: Smoother, run: Simulation) -> list[RecordRemark]:
    if not healthy:
        text = "there are no healthy repeats, so what is smaller than the model's own standing error cannot be seen"
        return [
            RecordRemark(
                "repeats", "weakens", text, "record the same command five times on the healthy machine and give them with --healthy"
            )
        ]
    found = []
    for other in healthy:
        if other.rows != record.rows or not np.allclose(other.command_mm, record.command_mm, atol=1e-6):
            found.append(
                RecordRemark(
                    "repeats",
                    "blocks",
                    f"{other.file} holds another command than {record.file}",
                    "give healthy records of the same command",
                )
            )
        elif other.period_s != record.period_s:
            found.append(
                RecordRemark("repeats", "blocks", f"{other.file} is sampled at another rate than {record.file}", "record both at one rate")
            )
        elif float(np.max(np.abs(other.position_mm - record.position_mm))) <= _IDENTICAL:
            found.append(
                RecordRemark("repeats", "blocks", f"{other.file} is the record itself", "leave the record out of its healthy repeats")
            )
        else:
            wrong = (*_exchanged(other, smoother), *_stuck(actuator, other, run))
            found += [replace(one, text=f"{other.file} is no repeat: {one.text}") for one in wrong if one.severity == "blocks"]
        lost = [name for name in record.present if name not in other.present]
        if lost:
            found.append(
                RecordRemark(
                    "repeats",
                    "weakens",
                    f"{other.file} lacks {', '.join(lost)}, which is then of no use in {record.file} either",
                    "give repeats with the same signals",
                )
            )
    if len(healthy) < 3:
        found.append(
            RecordRemark("repeats", "weakens", f"{len(healthy)} healthy repeats show little of how the machine scatters", "record five")
        )
    return found or [RecordRemark("repeats", "fine", f"{len(healthy)} healthy repeats of the same command")]


def _coverage(actuator: Actuator, record: Record, motion: MachineState, smoother: Smoother) -> dict[str, float]:
    """Numbers about the motion: what moves how far, how fast, how often to and fro."""
    inner = smoother.inner
    speed, position, direction = inner(motion.speed_rad_s), inner(motion.position_mm), inner(motion.direction)
    fastest = float(np.max(np.abs(speed)))
    moving = direction[direction != 0.0]
    stroke, noise = float(np.ptp(position)), white_noise(record.position_mm)
    reversals = _turns(position, max(_TURN_SHARE * stroke, _TURN_NOISE * noise)) if stroke > 0.0 else 0
    power = np.abs(np.fft.rfft(speed)) ** 2
    reached = np.cumsum(power) / max(float(power.sum()), 1e-300)
    top = float(np.fft.rfftfreq(speed.size, record.period_s)[min(int(np.searchsorted(reached, 0.95)), power.size - 1)])
    friction = actuator["screw.csj_Nm"]
    inertia = actuator["screw.inertia_kgm2"] * float(np.quantile(np.abs(inner(motion.acceleration_rad_s2)), 0.9))
    viscous = actuator["screw.viscous_Nm_s_per_rad"] * fastest
    drive = max(friction + inertia + viscous, 1e-12)
    bins = np.histogram(np.abs(speed), _BINS, (0.0, max(fastest, 1e-12)))[0]
    places = np.histogram(position, _BINS)[0] if stroke > 0.0 else np.zeros(_BINS)
    return {
        "duration_s": record.rows * record.period_s,
        "stroke_mm": stroke,
        "stroke_over_noise": stroke / max(noise, 1e-9),
        "stroke_leads": stroke / actuator["screw.lead_mm"],
        "stroke_motor_turns": stroke / (2.0 * math.pi * actuator.lead_mm_per_rad),
        "reversals": float(reversals),
        "fastest_rad_s": fastest,
        "slow_percent": 100.0 * float(np.mean(np.abs(speed) < _SLOW_SHARE * fastest)) if fastest > 0.0 else 100.0,
        "speed_bins_percent": 100.0 * float(np.mean(bins > 0.005 * speed.size)),
        "position_bins_percent": 100.0 * float(np.mean(places > 0.005 * speed.size)),
        "forward_percent": 100.0 * float(np.mean(moving > 0.0)) if moving.size else 0.0,
        "top_hz": top,
        "inertia_share_percent": 100.0 * inertia / drive,
        "viscous_share_percent": 100.0 * viscous / drive,
    }


def _turns(position: Reals, least_mm: float) -> int:
    """How often the rod turns back by more than `least_mm`."""
    turns, rising = 0, 0
    # the extreme of the present way
    low = high = float(position[0])
    for value in position.tolist():
        if rising >= 0 and value > high:
            high = value
        if rising <= 0 and value < low:
            low = value
        if rising >= 0 and high - value > least_mm:
            turns, rising, low = turns + rising, -1, value
        elif rising <= 0 and value - low > least_mm:
            turns, rising, high = turns - rising, 1, value
    return turns


def _coverage_remarks(actuator: Actuator, coverage: dict[str, float]) -> list[RecordRemark]:
    found = []
    if coverage["stroke_over_noise"] < _MOVING_MIN:
        text = f"the rod moves {coverage['stroke_mm']:.3g} mm, no more than its sensor's noise"
        return [RecordRemark("coverage", "blocks", text, "check that the drive was on; record a chirp of 2 mm or more")]
    reversals, leads, turns = coverage["reversals"], coverage["stroke_leads"], coverage["stroke_motor_turns"]
    if reversals < _REVERSALS_MIN:
        text = f"{reversals:.0f} reversal{'' if reversals == 1.0 else 's'} show little of play, presliding and friction near standstill"
        found.append(RecordRemark("coverage", "weakens", text, "record a command that turns back ten times or more"))
    if not 10.0 < coverage["forward_percent"] < 90.0:
        found.append(
            RecordRemark(
                "coverage",
                "weakens",
                "the rod moves in one direction only, so that friction, load and asymmetry look alike",
                "record both directions",
            )
        )
    if turns < 1.0:
        found.append(
            RecordRemark(
                "coverage",
                "weakens",
                f"the motor turns {turns:.2g} of a turn, so that cogging and ripple look like a load",
                "record a stroke of several motor turns",
            )
        )
    elif leads < 1.0:
        text = f"the stroke is {leads:.2g} of a screw lead, so that what repeats with the lead looks like what depends on position"
        found.append(RecordRemark("coverage", "weakens", text, f"record a stroke above {actuator['screw.lead_mm']:g} mm"))
    if coverage["inertia_share_percent"] < 10.0:
        text = f"acceleration takes {coverage['inertia_share_percent']:.2g} % of the torque, so that inertia, delays and compliance hardly show"
        found.append(RecordRemark("coverage", "weakens", text, "record higher frequencies"))
    if coverage["viscous_share_percent"] < 2.0 and actuator["screw.viscous_Nm_s_per_rad"] > 0.0:
        text = f"viscous friction takes {coverage['viscous_share_percent']:.2g} % of the torque, so that effects that grow with speed hardly show"
        found.append(RecordRemark("coverage", "weakens", text, "record higher speeds"))
    if coverage["speed_bins_percent"] < 60.0:
        text = f"only {coverage['speed_bins_percent']:.0f} % of the range of speeds is visited, so that shapes over speed are guesses"
        found.append(RecordRemark("coverage", "weakens", text, "record a chirp or a multisine"))
    if found:
        return found
    reached = f"speeds to {coverage['fastest_rad_s']:.3g} rad/s, frequencies to {coverage['top_hz']:.2g} Hz"
    text = f"{reversals:.0f} reversals, {leads:.2g} leads, {reached}, {coverage['slow_percent']:.0f} % of the time near standstill"
    return [RecordRemark("coverage", "fine", text)]


def unlike(actuator: Actuator, record: Record, run: Simulation) -> tuple[str, ...]:
    """Signals that are not the model's in sign or size, as of another unit or a sensor that is not connected, and what to do, in words; `run` [rows] is the model's of the record."""
    if not np.ptp(record.command_mm) > 0.0:
        return ()
    return tuple(f"{remark.text}: {remark.next}" for remark in _units(actuator, record, run) if remark.severity == "blocks")


def _alike(measured: Reals, model: Reals) -> tuple[float, float]:
    """Correlation and scale of a signal against the model's, both about their means; zeros where either is constant."""
    mine, its = measured - measured.mean(), model - model.mean()
    sizes = float(np.linalg.norm(mine)), float(np.linalg.norm(its))
    if not min(sizes) > 0.0:
        return 0.0, 0.0
    return float(mine @ its) / (sizes[0] * sizes[1]), sizes[0] / sizes[1]


def _units(actuator: Actuator, record: Record, run: Simulation) -> list[RecordRemark]:
    """Sign and scale of every signal beside the model's."""
    found = []
    for name in HIDES:
        measured = record.channel(name)
        if measured is None:
            continue
        title, unit = TITLES[name], UNITS[name]
        model = record.command_mm if name.endswith("position_mm") else getattr(run, name)
        correlation, scale = _alike(measured, model)
        if correlation == 0.0:
            found.append(
                RecordRemark("units", "blocks", f"{name} does not change while the command does", f"check that the {title} is connected")
            )
        elif correlation < _OPPOSITE:
            found.append(RecordRemark("units", "blocks", f"the {title} runs opposite to the model", f"change the sign of {name}"))
        elif not 1.0 / _SCALE_WRONG < scale < _SCALE_WRONG:
            guess = _unit_guess(name, scale, actuator)
            found.append(RecordRemark("units", "blocks", f"the {title} is {scale:.3g} times the model's{guess}", f"give {name} in {unit}"))
        elif correlation < _ALIKE:
            found.append(
                RecordRemark(
                    "units",
                    "weakens",
                    f"the {title} hardly follows the model (correlation {correlation:.2f})",
                    f"check that {name} belongs to this command and actuator",
                )
            )
        elif not 1.0 / _SCALE_DOUBTFUL < scale < _SCALE_DOUBTFUL:
            found.append(
                RecordRemark(
                    "units",
                    "weakens",
                    f"the {title} is {scale:.3g} times the model's",
                    f"check unit and scale of {name} and the actuator's data",
                )
            )
    return found or [RecordRemark("units", "fine", "signs and scales agree with the model")]


def _unit_guess(name: str, scale: float, actuator: Actuator) -> str:
    for factor, text in (
        (1e3, "a thousandth of the unit"),
        (1e-3, "a thousand times the unit"),
        (1e6, "a millionth of the unit"),
        (1.0 / actuator["drive.supply_V"], "a share of the supply"),
    ):
        if name != "voltage_V" and text == "a share of the supply":
            continue
        if 0.5 < scale / factor < 2.0:
            return f", as if it were in {text}"
    return ""


def lag_s(signal_one: Reals, signal_two: Reals, period_s: float, most_s: float = _LAG_MAX_S) -> float:
    """By how much the first signal comes later than the second, s, from the peak of their cross-correlation; both [rows]."""
    one, two = signal_one - signal_one.mean(), signal_two - signal_two.mean()
    most = min(max(2, round(most_s / period_s)), signal_one.size // 4)
    product = correlated(one, two)
    middle = two.size - 1
    near = product[middle - most : middle + most + 1]
    top = int(np.argmax(near))
    if 0 < top < near.size - 1:
        left, peak, right = near[top - 1 : top + 2]
        bend = left - 2.0 * peak + right
        return float(top - most + (0.5 * (left - right) / bend if bend < 0.0 else 0.0)) * period_s
    return (top - most) * period_s


def _clock(actuator: Actuator, record: Record, run: Simulation, smoother: Smoother) -> list[RecordRemark]:
    """Lag of the record against the model, and between its own two positions."""
    found = []
    speed, model = np.gradient(smoother.smooth(record.position_mm)), np.gradient(smoother.smooth(run.position_mm))
    ahead = -lag_s(speed, np.gradient(record.command_mm), record.period_s)
    if ahead > _AHEAD_S:
        text = f"the rod moves {1e3 * ahead:.3g} ms before its command, which no machine does"
        return [
            RecordRemark(
                "clock", "blocks", text, "check that command_mm and position_mm are not exchanged, and that one clock records both"
            )
        ]
    late = lag_s(speed, model, record.period_s)
    # at low speed a play is a delay too
    played = 0.5 * actuator["screw.blk_mm"] / max(float(np.mean(np.abs(speed))) / record.period_s, 1e-9)
    if abs(late) > max(_LAG_DOUBTFUL_S, 2.5 * record.period_s) + played:
        side = "later" if late > 0.0 else "earlier"
        text = f"the rod comes {1e3 * abs(late):.3g} ms {side} than in the model, more than effects of the library usually make"
        found.append(
            RecordRemark("clock", "weakens", text, "check that command and signals are recorded by one clock, and the actuator's gains")
        )
    if record.motor_position_mm is not None:
        between = lag_s(speed, np.gradient(smoother.smooth(record.motor_position_mm)), record.period_s)
        if abs(between) > max(_LAG_BETWEEN_S, 1.5 * record.period_s) + played:
            text = f"rod and motor position are {1e3 * abs(between):.3g} ms apart"
            found.append(RecordRemark("clock", "weakens", text, "record both by one clock, or correct the delay of one of them"))
    return found or [
        RecordRemark("clock", "fine", f"the rod is {1e3 * abs(late):.2g} ms {'behind' if late >= 0.0 else 'ahead of'} the model")
    ]


def _exchanged(record: Record, smoother: Smoother) -> list[RecordRemark]:
    """Columns that hold each other's signal: a rod that runs ahead of its motor, a winding whose back-EMF drives it, a rod that is the command itself."""
    found = []
    rod, motor, command = record.position_mm, record.motor_position_mm, record.command_mm
    if motor is not None and float(np.std(rod - command)) < _IS_COMMAND * float(np.std(motor - command)):
        found.append(
            RecordRemark(
                "columns",
                "blocks",
                "position_mm is the command, while the motor is not where the command is",
                "give the rod sensor's reading as position_mm",
            )
        )
    elif motor is not None:
        speed = np.gradient(smoother.smooth(0.5 * (rod + motor)), record.period_s)
        moving = np.abs(speed) > _SLOW_SHARE * float(np.max(np.abs(speed)))
        columns = np.column_stack([np.sign(speed), speed, np.ones(speed.size), rod])[moving]
        behind, std = _first_of(columns, (motor - rod)[moving])
        if (
            behind < -_EXCHANGED_STD * std
            and -behind > _EXCHANGED_NOISE * white_noise(rod)
            and _first_of(columns[:, :1], (motor - rod)[moving])[0] < 0.0
        ):
            found.append(
                RecordRemark(
                    "columns",
                    "blocks",
                    f"the rod runs {-1e3 * behind:.2g} um ahead of the motor in both directions, which no play does",
                    "check that position_mm and motor_position_mm are not exchanged",
                )
            )
    current, voltage = record.current_A, record.voltage_V
    if current is not None and voltage is not None and np.ptp(current) > 0.0 and np.ptp(voltage) > 0.0:
        speed = np.gradient(smoother.smooth(rod if motor is None else motor), record.period_s)
        inner = [smoother.inner(smoother.smooth(one)) for one in (current, voltage)]
        moved = smoother.inner(speed)
        share = _back_emf_share(inner[1], inner[0], moved)
        # exchanged, the law of the winding reads with the opposite sign of the speed
        if share < -_BACK_EMF_SHARE and _back_emf_share(inner[0], inner[1], moved) > _BACK_EMF_SHARE:
            found.append(
                RecordRemark(
                    "columns",
                    "blocks",
                    "the voltage falls where the motor runs faster at one current, which no winding does",
                    "check that current_A and voltage_V are not exchanged",
                )
            )
    return found


def _first_of(columns: Reals, values: Reals) -> tuple[float, float]:
    """The first unknown of a linear fit and its standard error; zeros where the fit has no rows to spare."""
    if values.size <= columns.shape[1]:
        return 0.0, 0.0
    fitted = np.linalg.lstsq(columns, values, rcond=None)[0]
    left = values - columns @ fitted
    inverse = np.linalg.pinv(columns.T @ columns)
    return float(fitted[0]), float(np.sqrt(inverse[0, 0] * (left @ left) / (values.size - columns.shape[1])))


def _back_emf_share(voltage: Reals, current: Reals, speed: Reals) -> float:
    """What the speed makes of a voltage beside the current, as a share of its size; zero where both together do not explain it."""
    columns = np.column_stack([speed, current, np.ones(current.size)])
    fitted = np.linalg.lstsq(columns, voltage, rcond=None)[0]
    size = float(np.std(voltage))
    if not size > 0.0 or float(np.std(voltage - columns @ fitted)) > _WINDING_LEFT * size:
        return 0.0
    return float(fitted[0]) * float(np.std(speed)) / size


def _sampling(actuator: Actuator, record: Record, coverage: dict[str, float]) -> list[RecordRemark]:
    found = []
    if 1.0 / record.period_s < _ROWS_PER_PERIOD * coverage["top_hz"]:
        text = f"{1.0 / record.period_s:.3g} rows per second are few for a motion at {coverage['top_hz']:.3g} Hz"
        found.append(RecordRemark("sampling", "weakens", text, f"record {_ROWS_PER_PERIOD * coverage['top_hz']:.3g} Hz or more"))
    if record.period_s > 1.5 * actuator["timing.step_s"] * actuator["control.every_steps"]:
        text = "the control law runs between the recorded rows, so that the controller cannot be judged exactly"
        found.append(RecordRemark("sampling", "weakens", text, "record at the rate of the control law"))
    return found or [RecordRemark("sampling", "fine", f"{1.0 / record.period_s:.4g} rows per second")]


def _saturation(actuator: Actuator, record: Record) -> list[RecordRemark]:
    """The share of time in which the drive gives all it has and the loop is open."""
    voltage = record.voltage_V
    scale = actuator["drive.supply_V"] if actuator["drive.mode"] == 0.0 else actuator["drive.command_scale_V"]
    most = scale * actuator["control.output_limit"]
    if voltage is None or not most > 0.0:
        return []
    share = float(np.mean(np.abs(voltage) >= _LIMIT_SHARE * most))
    if share > _SATURATED_BLOCKS:
        return [
            RecordRemark(
                "saturation", "blocks", f"the drive is at its limit {100.0 * share:.0f} % of the time", "record a smaller or slower command"
            )
        ]
    if share > _SATURATED_WEAKENS:
        text = f"the drive is at its limit {100.0 * share:.0f} % of the time, where the loop is open and the controller does not show"
        return [RecordRemark("saturation", "weakens", text, "record a smaller or slower command")]
    return [
        RecordRemark(
            "saturation",
            "fine",
            f"the drive is at its limit {100.0 * share:.1f} % of the time, its largest output {100.0 * float(np.max(np.abs(voltage))) / most:.0f} %",
        )
    ]


def _clipping(record: Record) -> list[RecordRemark]:
    """Flat tops of current and speed: many samples at exactly the same extreme."""
    found = []
    for name in ("current_A", "speed_mm_s"):
        values = record.channel(name)
        if values is None or not np.ptp(values) > 0.0:
            continue
        for extreme, side in ((float(np.max(values)), "highest"), (float(np.min(values)), "lowest")):
            flat = values == extreme
            longest, start = longest_run(flat)
            if longest >= _CLIPPED_ROWS and abs(extreme) > 0.2 * float(np.max(np.abs(values))):
                text = f"{name} stands at its {side} value {extreme:.4g} {UNITS[name]} for {longest} rows from row {start + 1}: its sensor clips, or the drive limits it"
                found.append(
                    RecordRemark("clipping", "weakens", text, f"check the range of the {TITLES[name]}'s sensor against the drive's limit")
                )
    return found


def longest_run(flags: NDArray[np.bool_]) -> tuple[int, int]:
    """Length and first row of the longest run of true values."""
    lengths = [(last - first, first) for first, last in _stretches(flags)]
    return max(lengths, key=lambda one: one[0], default=(0, 0))


def _stretches(flags: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First row, and the row after the last, of every run of true values."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], flags.astype(np.int8), [0])))).tolist()
    return list(zip(edges[::2], edges[1::2], strict=True))


def _spikes(record: Record) -> list[RecordRemark]:
    """Samples that jump away from their neighbours on both sides and back."""
    found = []
    for name in HIDES:
        values = record.channel(name)
        if values is None or not np.ptp(values) > 0.0:
            continue
        calm = ndimage.median_filter(values, _SPIKE_WINDOW, mode="nearest")
        away = np.abs(values - calm)
        # the widest step of the calm signal nearby: an edge of a command is no spike
        step = ndimage.maximum_filter1d(np.abs(np.diff(calm, prepend=calm[0])), _SPIKE_WINDOW)
        rows = np.flatnonzero(
            away > np.maximum(np.maximum(_SPIKE_NOISE * white_noise(values), 2.0 * step), _SPIKE_SHARE * float(np.ptp(calm)))
        )
        if rows.size:
            first = int(rows[0])
            more = f", and so do {rows.size - 1} other rows" if rows.size > 1 else ""
            text = f"{name} jumps by {values[first] - calm[first]:+.3g} {UNITS[name]} in row {first + 1} and back{more}: no machine does"
            found.append(
                RecordRemark(
                    "spikes", "weakens", text, f"look for a loose contact or lost samples of the {TITLES[name]}, and record again", True
                )
            )
    return found


# What to do about a sensor that is held.
_HELD = {
    "position_mm": "check the rod's sensor, and what joins it to the motor",
    "motor_position_mm": "check the motor's sensor, and record again",
    "current_A": "check the current's sensor, and record again",
    "voltage_V": "check where the voltage is recorded, and record again",
}


def _stuck(actuator: Actuator, record: Record, run: Simulation) -> list[RecordRemark]:
    """Samples that repeat while the model's signal moves on, the longest stretch of each signal: lost data, or a held sensor; a rod that stays may be seized, unless the motor turns on."""
    found = []
    for name in HIDES:
        values = record.channel(name)
        if values is None or not np.ptp(values) > 0.0:
            continue
        same = np.concatenate((np.diff(values) == 0.0, [False]))
        model = getattr(run, name)
        longest = 0
        for first, last in _stretches(same):
            long_enough = (last - first) * record.period_s >= _STUCK_S
            clipped = name not in ("position_mm", "motor_position_mm") and abs(values[first]) == np.max(np.abs(values))
            if last - first > longest and long_enough and not clipped and np.ptp(model[first : last + 1]) > _STUCK_MOVES * np.ptp(model):
                longest, start = last - first, first
        if longest:
            text = f"{name} repeats one value for {longest + 1} rows from row {start + 1}, where the "
            held = slice(start, start + longest + 1)
            mover = _moves_on(actuator, record, name, held)
            if mover:
                severity: Severity = "blocks" if longest > _STUCK_BLOCKS * record.rows else "weakens"
                found.append(RecordRemark("stuck", severity, f"{text}{mover} on", _HELD[name], True))
            else:
                what = "check the recording for lost samples, and the machine for a seized rod"
                found.append(RecordRemark("stuck", "weakens", f"{text}model moves on", what))
    return found


def _moves_on(actuator: Actuator, record: Record, name: str, held: slice) -> str:
    """What else in the record moves while a signal is held, with its verb: then it is the sensor, not the machine. Empty where nothing does."""
    rod, motor = record.position_mm, record.motor_position_mm
    # a rod may rest while the motor crosses the play
    play = _PLAYS * actuator["screw.blk_mm"] if name == "position_mm" else 0.0
    turns = name != "motor_position_mm" and motor is not None and bool(np.ptp(motor[held]) > play + _STUCK_MOVES * np.ptp(motor))
    if turns:
        return "motor turns"
    moves = name != "position_mm" and bool(np.ptp(rod[held]) > _STUCK_MOVES * np.ptp(rod))
    return "rod moves" if moves else ""


def _start(actuator: Actuator, record: Record, motion: MachineState) -> list[RecordRemark]:
    """The model starts at rest."""
    begun = slice(1, max(2, round(0.01 / record.period_s)))
    fastest = float(np.max(np.abs(motion.speed_rad_s)))
    if fastest > 0.0 and float(np.mean(np.abs(motion.speed_rad_s[begun]))) > 0.1 * fastest:
        text = "the rod already moves in the first rows, while the model starts at rest"
        return [RecordRemark("start", "weakens", text, "begin the recording before the command begins")]
    return []
