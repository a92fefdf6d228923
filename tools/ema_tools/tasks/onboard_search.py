"""One search by the onboard module's own session: what is identified, inside which bounds, and what can be searched at all."""

from __future__ import annotations

from dataclasses import replace

from ema_tools.base.errors import InputError
from ema_tools.data.actuator import Actuator, nearest, row_of
from ema_tools.data.records import Record
from ema_tools.plant.native import CHANNELS, Identification, Progress, SearchSettings, Table, library

# Keys of the result for the values that are identified by default.
KEYS = {"screw.csj_Nm": "csj_Nm", "screw.blk_mm": "blk_mm"}
BOUNDS = {"screw.csj_Nm": ("search.csj_lower_Nm", "search.csj_upper_Nm"), "screw.blk_mm": ("search.blk_lower_mm", "search.blk_upper_mm")}
MIN_SHIFTS = {"screw.csj_Nm": "verdict.csj_min_shift_percent", "screw.blk_mm": "verdict.blk_min_shift_percent"}
SCATTERS = {"screw.csj_Nm": "verdict.csj_scatter_percent", "screw.blk_mm": "verdict.blk_scatter_percent"}
DAY_VALUES = "search.day_values"
# What a degree makes of CSJ, for a search that reads winding and grease beside it.
DAY_SCATTER = "verdict.csj_day_scatter_percent"
PER_DEGC, PER_DEGC_STD = "verdict.csj_per_degC_percent", "verdict.csj_per_degC_std_percent"
WINDING_SHARE, APART_DEGC = "verdict.day_winding_ratio", "verdict.day_apart_degC"
LAW = (DAY_SCATTER, PER_DEGC, PER_DEGC_STD, WINDING_SHARE, APART_DEGC)
POSITION_NOISE = "verdict.position_noise_mm"
SHARED_NOISE = "verdict.shared_noise_mm"
COMMAND_SPEED = "verdict.command_speed_mm_s"
UNSEEN = "verdict.unseen_percent"
STRUCTURE = "verdict.structure_ratio"
_LEFT = 0.4  # of a value that a data sheet states: real machines have more of it [judgement]
POSITION_ALONE = (1.0, 0.0, 0.0, 0.0)  # what the search weighs unless told: the rod position is what the fault shows in [physics]


def weight_of(text: str | None) -> tuple[float, float, float, float] | None:
    """Weights in the order of CHANNELS from `column=weight,...`; None for the usual ones. Raises InputError that names the column."""
    if not text:
        return None
    weight = dict.fromkeys(CHANNELS, 0.0)
    for part in filter(None, text.split(",")):
        name, _, value = part.partition("=")
        if name.strip() not in weight:
            raise InputError(f"--weight {part}: unknown column{nearest(name.strip(), CHANNELS)}: columns are {', '.join(CHANNELS)}")
        try:
            weight[name.strip()] = float(value)
        except ValueError:
            raise InputError(f"--weight {part}: not a number: write for example --weight position_mm=1,current_A=0.01") from None
    numbers = list(weight.values())
    if not all(0.0 <= number < float("inf") for number in numbers) or not any(numbers):
        raise InputError(f"--weight {text}: not weights: give numbers of zero or more, one of them above zero")
    return numbers[0], numbers[1], numbers[2], numbers[3]


def check_kept(given: Actuator, found: Actuator, file: str) -> None:
    """Raises InputError where a machine as its healthy records show it has hardly anything left of a value that is watched: what stands for it cannot be told from a fault."""
    for name in identified_of(given):
        if found[name] < _LEFT * given[name]:
            standing = ", ".join(one for one in found.active_effects if one not in given.active_effects) or "its base values"
            raise InputError(
                f"{file} and the other healthy records: {name} would be {found[name]:.3g}, where the actuator says {given[name]:.3g}: {standing} would stand for it, "
                "and a fault could not be told: give more healthy records, or other days' ones; ema diagnose says what they lack"
            )


def identified_of(actuator: Actuator) -> tuple[str, ...]:
    """The values that are searched: those whose healthy value is not zero, since a shift is counted in % of it."""
    return tuple(name for name in KEYS if actuator[name] > 0.0)


def check_bounds(actuator: Actuator) -> None:
    """Raises InputError where a healthy value lies outside the bounds of its search."""
    for name in identified_of(actuator):
        lower, upper = BOUNDS[name]
        if not actuator[lower] < actuator[upper]:
            raise InputError(f"{actuator.file}: {lower} = {actuator[lower]:g}: not below {upper} = {actuator[upper]:g}: correct the bounds")
        if not actuator[lower] <= actuator[name] <= actuator[upper]:
            raise InputError(
                f"{actuator.file}: {name} = {actuator[name]:g}: outside the search's bounds {actuator[lower]:g} .. {actuator[upper]:g} {row_of(name).unit}: widen them"
            )


def check_record(actuator: Actuator, record: Record, search: SearchSettings) -> None:
    """Raises InputError when the search cannot begin: a healthy value or a bound that does not fit, or a weight on a signal that is not recorded."""
    for name, weight in zip(CHANNELS, search.weight or (), strict=False):
        if weight > 0.0 and record.channel(name) is None:
            raise InputError(f"{record.file}: {name}: weighted but not recorded: recorded are {', '.join(record.present)}")
    if not identified_of(actuator):
        raise InputError(
            f"{actuator.file}: screw.csj_Nm = 0: the healthy value is zero, and a shift is counted in % of it: give one, or calibrate"
        )
    check_bounds(actuator)


def check_table(table: Table, record: Record) -> None:
    """Raises InputError when the record lacks a signal that the table of signatures compares."""
    for place in table.channels:
        if record.channel(CHANNELS[place]) is None:
            raise InputError(
                f"{record.file}: {CHANNELS[place]}: the table compares it, but it is not recorded: record it, or leave --table out"
            )


def _settings(actuator: Actuator, search: SearchSettings) -> tuple[SearchSettings, bool]:
    """What is searched and inside which bounds, and whether grease and winding are searched beside it."""
    names = identified_of(actuator)
    day = actuator[DAY_VALUES] != 0.0 and len(names) == len(KEYS) and search.identified is None
    if search.identified is None and not day:
        lower, upper = (tuple(actuator[BOUNDS[name][side]] for name in names) for side in (0, 1))
        search = replace(
            search,
            identified=names,
            lower=lower,
            upper=upper,
            min_shift_percent=search.min_shift_percent or tuple(actuator[MIN_SHIFTS[name]] for name in names),
        )
    return search, day


def search_warnings(actuator: Actuator, search: SearchSettings | None = None) -> tuple[str, ...]:
    """Why the search of `run` would not reach its lowest cost with its settings, and what to do; by the module's own rules. Raises InputError."""
    given, _ = _settings(actuator, search or SearchSettings())
    return library(32).search_warnings(*actuator.arrays(), given)


def run(
    actuator: Actuator, record: Record, search: SearchSettings, bits: int, progress: Progress | None = None, table: Table | None = None
) -> Identification:
    """One search on one record, behind a `table` of signatures where one is given. Raises InputError."""
    search, day = _settings(actuator, search)
    values, options = actuator.arrays()
    answer = library(bits).identify(values, options, record.command_mm, record.table(), search, progress, table)
    if not day:
        return answer
    parts = [tuple(one for one in answer.identified if (one.name in KEYS) is fault) for fault in (True, False)]
    return replace(answer, identified=parts[0], day=parts[1])
