"""Rows of a machine's record that no machine makes: a value far off everything around it, a sensor that clips, a drive that has nothing to do with the motion, and what swings above the filter.

Of a machine whose controller is not known nothing is simulated: what is odd must show in the signal itself.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from ema_tools.balances.filtering import Smoother
from ema_tools.balances.mechanical import Mechanical
from ema_tools.balances.motion import Motion
from ema_tools.base.arrays import Reals
from ema_tools.base.noise import white_noise
from ema_tools.compare.validity import RecordRemark, longest_run
from ema_tools.data.motion_records import DRIVES, MOTIONS, MotionRecord

UNSEEN = "bandwidth"  # topic of what the drive does above the filter

_WINDOW = 7  # rows of the median against which a value is held: twice as long as a pulse of three rows, and more [precision]
_FEW, _FEW_SHARE = 2, 1e-3  # rows to either side, and of all rows, that may be far off: more are the signal [judgement]
_FAR = 5.0  # times the whole range of all other rows, that a value must be off: a start is no more than the range [judgement]
_FLAT_ROWS = 10  # rows at one extreme value ... [chance]
_REPEATS = 0.05  # ... of a signal whose other neighbours are the same at most so often: counts of a slow motion repeat [judgement]
_HIGH = 0.5  # of its largest value, that a signal that clips has reached [judgement]
_OF_DRIVE = 0.01  # of the drive's rms, that a swing above the filter must have: less is no finding [judgement]
_ABOVE_NOISE = 30.0  # times the mean of the lines around it, that its line must be above: of thousands of lines of noise none is [chance]
_HIGHEST = 64.0  # swings per turn that are looked for [judgement]
_WHOLE = 2.0  # lines of its spectrum, by which a number of swings may be off a whole one that it is [precision]
_LEAST_TURNS = 3.0  # of the motor, before a swing per turn is one [judgement]


def odd_rows(record: MotionRecord) -> list[RecordRemark]:
    """Values far off, and sensors that clip, in motion and drive."""
    found: list[RecordRemark] = []
    for name in (*MOTIONS, *DRIVES):
        values = record.channel(name)
        if values is not None and np.ptp(values) > 0.0:
            found += [*_far_off(name, values), *_clips(name, values)]
    return found


def _far_off(name: str, values: Reals) -> Iterator[RecordRemark]:
    calm = ndimage.median_filter(values, _WINDOW, mode="nearest")
    few = max(_FEW, round(_FEW_SHARE * values.size))
    others = np.sort(values)[few:-few]
    rows = np.flatnonzero(np.abs(values - calm) > _FAR * float(np.ptp(others))) if others.size else others
    if rows.size:
        first = int(rows[0])
        more = f", and so are {rows.size - 1} other rows" if rows.size > 1 else ""
        text = (
            f"{name} is {values[first]:.4g} in row {first + 1}, where its neighbours are near {calm[first]:.3g}{more}: no machine does that"
        )
        yield RecordRemark("spikes", "weakens", text, "correct or leave out this row in the file, and import it again", True)


def _clips(name: str, values: Reals) -> Iterator[RecordRemark]:
    if name.endswith(("position_mm", "angle_rad")):
        return  # at rest they stand
    highest, lowest = float(np.max(values)), float(np.min(values))
    either = (values == highest) | (values == lowest)
    beside = ~(either[1:] | either[:-1])
    for extreme, side in ((highest, "highest"), (lowest, "lowest")):
        rows, start = longest_run(values == extreme)
        if rows < _FLAT_ROWS or abs(extreme) < _HIGH * float(np.max(np.abs(values))):
            continue
        # what is read in steps stands at every value
        if beside.any() and float(np.mean(np.diff(values)[beside] == 0.0)) <= _REPEATS:
            text = f"{name} stands at its {side} value {extreme:.4g} for {rows} rows from row {start + 1}, and nowhere else: it is cut off there"
            yield RecordRemark("clipping", "weakens", text, "record a smaller or slower motion, or with a wider range", True)
            return


def swings_unseen(record: MotionRecord, model: Mechanical, motion: Motion) -> list[RecordRemark]:
    """A swing of the drive per turn of the motor that is faster than the filter passes, which nothing that follows sees.

    The filter is lowered where noise of the motion would hide the torque of the inertia, and with it goes what the machine itself does so fast.
    """
    usual = Smoother.of(record.period_s)
    drive = record.torque_Nm if record.torque_Nm is not None else record.force_N if record.force_N is not None else record.current_A
    if drive is None or model.smoother.cutoff_hz >= usual.cutoff_hz:
        return []
    inner = slice(model.smoother.edge_rows, -model.smoother.edge_rows)
    speed, angle = motion.speed_rad_s[inner], motion.angle_rad[inner]
    turns = float(np.ptp(angle)) / (2.0 * np.pi)
    # of one speed, so that a swing per turn is one frequency
    if turns < _LEAST_TURNS or float(np.std(speed)) > 0.1 * abs(float(np.mean(speed))):
        return []
    gone = (drive - model.smoother.smooth(drive))[inner]
    order = _strongest(gone, turns, drive)
    if order is None:
        return []
    often, amplitude = order
    whole = round(often)
    often = float(whole) if whole and abs(often - whole) < _WHOLE / turns else often
    hz = often * abs(float(np.mean(speed))) / (2.0 * np.pi)
    share = 100.0 * amplitude / float(np.sqrt(np.mean(drive**2)))
    text = (
        f"the drive swings {often:.3g} times per motor turn ({hz:.3g} Hz) by {share:.2g} % of its size, above the {model.smoother.cutoff_hz:.3g} Hz "
        f"to which noise of the motion leaves anything to be seen in {record.file}, where nothing is looked for"
    )
    return [RecordRemark(UNSEEN, "weakens", text, "record the motor's angle, or its speed with less noise, or run slower", True)]


def _strongest(gone: Reals, turns: float, drive: Reals) -> tuple[float, float] | None:
    """Swings per turn and amplitude of a line that stands above all around it; None without one. At one speed time is angle."""
    spectrum = np.abs(np.fft.rfft(gone * np.hanning(gone.size)))
    orders = np.arange(spectrum.size) / turns
    within = (orders > 1.0 / _LEAST_TURNS) & (orders < _HIGHEST)
    if not within.any():
        return None
    place = int(np.argmax(np.where(within, spectrum, 0.0)))
    amplitude = 4.0 * float(spectrum[place]) / gone.size
    least = max(_OF_DRIVE * float(np.sqrt(np.mean(drive**2))), 4.0 * white_noise(gone) / np.sqrt(gone.size))
    around = _around(spectrum**2, place)
    if amplitude < least or around.size == 0 or float(spectrum[place] ** 2) < _ABOVE_NOISE * float(np.mean(around)):
        return None
    return float(orders[place]), amplitude


def _around(power: Reals, place: int, reach: int = 40, own: int = 4) -> Reals:
    """The lines to both sides of one, without those that its window fills."""
    keep: NDArray[np.bool_] = np.zeros(power.size, dtype=bool)
    keep[max(1, place - reach) : place + reach + 1] = True
    keep[max(0, place - own) : place + own + 1] = False
    return power[keep]
