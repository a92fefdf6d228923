"""The onboard C module behind typed arrays: the shared libraries `ema_desk32` and `ema_desk64` of `port/desk`, through ctypes.

A call releases the interpreter, so threads run simulations on all cores. Values and options stand in the order of the two lists of
`ema_tools.library.definitions`; loading checks that the library was built from the same lists.
"""

from __future__ import annotations

import ctypes
import functools
import math
import os
from collections.abc import Callable, Sequence
from ctypes import POINTER, c_char_p, c_double, c_int16, c_int32, c_int64, c_uint32, c_uint64, c_void_p
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ema_tools.base.arrays import Integers, Reals
from ema_tools.base.errors import InputError, LibraryError
from ema_tools.library.definitions import library_function, library_path, load_definitions, open_library, read_definitions
from ema_tools.library.schema import schema_of

IDENTIFIED_MAX = 4
DIMENSION_MAX = 8
CHANNELS = ("position_mm", "motor_position_mm", "current_A", "voltage_V")
OUTPUTS = (*CHANNELS, "speed_mm_s")
RECORD_COLUMNS = ("time_s", "command_mm", "position_mm", "motor_position_mm", "current_A", "voltage_V", "speed_mm_s")
_MESSAGE_BYTES = 1024
SITES = ("PARAMETER", "FRICTION", "TORQUE", "LOAD", "VOLTAGE", "MOTOR", "PRESLIDING", "TRANSMISSION", "READING", "WINDING", "GREASE")
POINT = ("current_A", "speed_rad_s", "angle_rad", "motor_mm", "voltage_V", "level_Nm", "direction")
COMMAND_KINDS = ("chirp", "multisine", "triangle", "trapezoid", "step")
COMMAND_NUMBERS = ("amplitude_mm", "start_hz", "end_hz", "duration_s", "share", "count", "time_s")
OUTCOMES = {0: "tolerance", 1: "active", 2: "budget", 3: "count"}
# How the session searches, `ema_search_t`, and which stage gave its best point, `ema_stage_t`.
SEARCHES = ("annealer", "two_stages")
STAGES = ("annealer", "least_squares")
VERDICTS = {0: "healthy", 1: "fault", 2: "undecided"}
NOT_DETERMINED = 32
FINDINGS = ("adequate", "missing", "unknown", "none")
_TABLE_NUMBERS = 8
_FAULT_NUMBERS = 5


def _texts(function: str) -> dict[int, str]:
    """Bit to text, as the library's `function` has them."""
    read = library_function(open_library(library_path(64)), function)
    read.argtypes, read.restype = [c_int32, POINTER(c_int32)], c_char_p
    found: dict[int, str] = {}
    bit = c_int32()
    while text := read(len(found), ctypes.byref(bit)):
        found[bit.value] = text.decode()
    return found


REASONS = _texts("ema_desk_reason_text")
WARNINGS = _texts("ema_desk_warning_text")


def _number(function: str) -> int:
    """What the library's `function` answers."""
    read = library_function(open_library(library_path(64)), function)
    read.argtypes, read.restype = [], c_uint32
    return int(read())


def checked_schema() -> int:
    """`EMA_CONFIG_SCHEMA` of the libraries in use. Raises LibraryError where it is not that of their lists."""
    schema = _number("ema_desk_schema")
    if schema != schema_of(load_definitions()):
        raise LibraryError(f"{library_path(64).name}: its number of the lists is not theirs: build the project again")
    return schema


def module_version() -> int:
    """`EMA_VERSION` of the libraries in use: major, minor and patch, a byte each."""
    return _number("ema_desk_version")


class _SearchStructure(ctypes.Structure):
    _fields_ = [
        ("identified_count", c_int32),
        ("identified_id", c_int32 * IDENTIFIED_MAX),
        ("identified_lower", c_double * IDENTIFIED_MAX),
        ("identified_upper", c_double * IDENTIFIED_MAX),
        ("identified_min_shift_percent", c_double * IDENTIFIED_MAX),
        ("weight", c_double * len(CHANNELS)),
        ("start", c_double * IDENTIFIED_MAX),
        ("start_at_healthy", c_int32),
        ("abandon", c_int32),
        ("int16_record", c_int32),
        ("slice_steps", c_int32),
        ("evaluation_budget", c_int32),
        ("reanneal_interval", c_int32),
        ("initial_temperature", c_double),
        ("cooling", c_double),
        ("function_tolerance", c_double),
        ("seed", c_int64),
        ("search", c_int32),
    ]


class _Result(ctypes.Structure):
    _fields_ = [
        ("estimate", c_double * IDENTIFIED_MAX),
        ("std", c_double * IDENTIFIED_MAX),
        ("shift_percent", c_double * IDENTIFIED_MAX),
        ("at_bound", c_int32 * IDENTIFIED_MAX),
        ("objective_before", c_double),
        ("objective_after", c_double),
        ("residual_rms_mm", c_double),
        ("residual_correlation", c_double),
        ("model_steps", c_int64),
        ("evaluations", c_int32),
        ("accepted", c_int32),
        ("accepted_uphill", c_int32),
        ("outcome", c_int32),
        ("verdict", c_int32),
        ("adequate", c_int32),
        ("reasons", c_int32),
        ("random_state", c_uint64),
        ("bias", c_double * IDENTIFIED_MAX),
        ("half_95", c_double * IDENTIFIED_MAX),
        ("scatter_percent", c_double * IDENTIFIED_MAX),
        ("today", c_double * IDENTIFIED_MAX),
        ("stage", c_int32),
    ]


class _Annealer(ctypes.Structure):
    _fields_ = [
        ("dimension", c_int32),
        ("start", c_double * DIMENSION_MAX),
        ("first_step", c_double),
        ("initial_temperature", c_double),
        ("cooling", c_double),
        ("function_tolerance", c_double),
        ("stall_evaluations", c_int32),
        ("reanneal_interval", c_int32),
        ("evaluation_budget", c_int32),
        ("seed", c_int64),
    ]


class _Annealed(ctypes.Structure):
    _fields_ = [("x", c_double * DIMENSION_MAX), ("cost", c_double), ("evaluations", c_int32), ("outcome", c_int32)]


class _Table(ctypes.Structure):
    _fields_ = [
        ("version", c_int32),
        ("fingerprint", c_uint32),
        ("record_rows", c_int32),
        ("bin_rows", c_int32),
        ("bins", c_int32),
        ("channels", c_int32),
        ("channel", c_int32 * len(CHANNELS)),
        ("patterns", c_int32),
        ("faults", c_int32),
        ("nuisances", c_int32),
        ("rows", c_int32),
        ("values", c_int32),
        ("command_unit_mm", c_double),
        ("command_apart_mm", c_double),
        ("reference", c_double * len(CHANNELS)),
        ("weight", c_double * len(CHANNELS)),
        ("limit", c_double),
        ("energy", c_double),
        ("pattern", POINTER(c_double)),
        ("fault", POINTER(c_double)),
        ("unit", POINTER(c_double)),
        ("value", POINTER(c_int16)),
    ]


class _Finding(ctypes.Structure):
    _fields_ = [
        ("kind", c_int32),
        ("effect", c_int32),
        ("runner_up", c_int32),
        ("alike", c_uint64),
        ("score", c_double),
        ("runner_up_score", c_double),
        ("limit", c_double),
        ("size", c_double),
        ("energy", c_double),
        ("moved", c_double * 2),
    ]


_PROGRESS = ctypes.CFUNCTYPE(c_int32, c_int32, c_double, c_double, POINTER(c_double), c_void_p)
_COST = ctypes.CFUNCTYPE(c_int32, POINTER(c_double), c_double, POINTER(c_double), c_void_p)
# Number of the model run, its cost, the best cost so far, and the values that were tried, in the order of the identified ones; none where one
# slice of the work ended several runs.
Progress = Callable[[int, float, float, tuple[float, ...]], None]


@dataclass(frozen=True)
class Simulation:
    """What a simulated run shows, arrays of shape [rows] in the units of the names; `unlocated_event_steps` counts model steps with more
    events than the model locates (0 in ordinary runs)."""

    position_mm: Reals
    motor_position_mm: Reals
    current_A: Reals
    voltage_V: Reals
    speed_mm_s: Reals
    unlocated_event_steps: int


@dataclass(frozen=True)
class SearchSettings:
    """Settings of one identification; None keeps what the actuator's [search] and [verdict] tables say.

    `identified` are names of real values (`section.field`), `start` their first values (None: the healthy ones) and `lower`, `upper` their
    bounds, all in the values' own units; `weight` belongs to `CHANNELS`.
    """

    identified: tuple[str, ...] | None = None
    lower: tuple[float, ...] | None = None
    upper: tuple[float, ...] | None = None
    min_shift_percent: tuple[float, ...] | None = None
    start: tuple[float, ...] | None = None
    weight: tuple[float, float, float, float] | None = None
    seed: int | None = None
    evaluation_budget: int | None = None
    function_tolerance: float | None = None
    initial_temperature: float | None = None
    abandon: bool | None = None
    int16_record: bool | None = None
    slice_steps: int | None = None
    search: str | None = None  # of SEARCHES


@dataclass(frozen=True)
class AnnealerSettings:
    """Settings of the module's annealer alone, `ema_annealer_config_t`; temperature and tolerance in the unit of the cost. `start` [1 to 8] in [0, 1]."""

    start: tuple[float, ...]
    initial_temperature: float
    cooling: float
    function_tolerance: float
    evaluation_budget: int
    first_step: float = 0.2
    stall_evaluations: int = 40
    reanneal_interval: int = 60
    seed: int = 1


@dataclass(frozen=True)
class Annealed:
    """The best point [dimension] of an annealing in the unit box, its cost, the evaluations, and what ended it (of OUTCOMES)."""

    x: Reals
    cost: float
    evaluations: int
    outcome: str


@dataclass(frozen=True)
class Table:
    """A table of signatures as the firmware has it: `ema_signatures_t`, channels by their place in CHANNELS.

    `patterns` [k, 8]: effect, first, rows, one_sided, turn[3], penalty; `faults` [k, 5]: id, row, healthy, turn, length; `unit` [rows];
    `value` [bins * (1 + channels * (1 + rows))].
    """

    version: int
    fingerprint: int
    record_rows: int
    bin_rows: int
    bins: int
    channels: tuple[int, ...]
    nuisances: int
    command_unit_mm: float
    command_apart_mm: float
    reference: tuple[float, ...]
    weight: tuple[float, ...]
    limit: float
    energy: float
    patterns: Reals
    faults: Reals
    unit: Reals
    value: NDArray[np.int16]


@dataclass(frozen=True)
class Finding:
    """What the table says of the record at the best point: one of FINDINGS, effects by name (None for none), scores in variances of the noise.

    `alike`: effects that cannot be told from the best, itself among them; `moved`: changes of the table's CSJ and BLK that the residual still asks for.
    """

    kind: str
    effect: str | None
    runner_up: str | None
    alike: tuple[str, ...]
    score: float
    runner_up_score: float
    limit: float
    size: float
    energy: float
    moved: tuple[float, float]


@dataclass(frozen=True)
class IdentifiedValue:
    """One identified value in its own unit, its standard error (NaN when the record does not determine it), and its shift in % of the healthy value.

    `bias`: how far it may be off besides, in its own unit, for what lasts in the residual; NaN as the standard error. `half_95`: half of the 95 % interval that firmware states;
    `scatter_percent`: by how much a sound machine is read apart on such a day, standard deviation in % of the healthy value, as the actuator states it. `today`: the value that explains the
    record; of dry friction the estimate is that at the temperature of the healthy runs, where the actuator says what a degree does to it.
    """

    name: str
    estimate: float
    std: float
    shift_percent: float
    at_bound: bool
    today: float
    bias: float = math.nan
    half_95: float = math.nan
    scatter_percent: float = 0.0


@dataclass(frozen=True)
class Identification:
    """What the onboard session answers; objectives in mm^2 s when only the rod position is weighted. `day`: of what was searched beside for it differs from day to day."""

    identified: tuple[IdentifiedValue, ...]
    objective_before: float
    objective_after: float
    residual_rms_mm: float
    residual_correlation: float
    model_steps: int
    evaluations: int
    accepted: int
    accepted_uphill: int
    outcome: str
    verdict: str
    adequate: bool
    reasons: tuple[str, ...]
    random_state: int
    finding: Finding | None = None  # with a table of signatures alone
    stage: str = STAGES[0]  # that gave the best point
    day: tuple[IdentifiedValue, ...] = ()


def _doubles(array: Reals) -> Any:
    return array.ctypes.data_as(POINTER(c_double))


def _flat(array: object, shape: tuple[int, ...], name: str) -> Reals:
    """`array` as contiguous float64 of `shape`. Raises ValueError that names it."""
    numbers = np.ascontiguousarray(array, dtype=np.float64)
    if numbers.shape != shape:
        raise ValueError(f"{name}: shape {numbers.shape} where {shape} is needed: give one number per row")
    return numbers


def _raw_table(table: Table) -> tuple[_Table, tuple[object, ...]]:
    """The structure of the library, and the arrays that must live as long as it."""
    patterns = _flat(table.patterns, (len(table.patterns), _TABLE_NUMBERS), "patterns")
    faults = _flat(table.faults, (len(table.faults), _FAULT_NUMBERS), "faults")
    unit = _flat(table.unit, (len(table.unit),), "unit")
    value = np.ascontiguousarray(table.value, dtype=np.int16)
    raw = _Table(
        version=table.version,
        fingerprint=table.fingerprint,
        record_rows=table.record_rows,
        bin_rows=table.bin_rows,
        bins=table.bins,
        channels=len(table.channels),
        patterns=len(patterns),
        faults=len(faults),
        nuisances=table.nuisances,
        rows=len(unit),
        values=value.size,
        command_unit_mm=table.command_unit_mm,
        command_apart_mm=table.command_apart_mm,
        limit=table.limit,
        energy=table.energy,
        pattern=_doubles(patterns),
        fault=_doubles(faults),
        unit=_doubles(unit),
        value=value.ctypes.data_as(POINTER(c_int16)),
    )
    for name, numbers in (("channel", table.channels), ("reference", table.reference), ("weight", table.weight)):
        for place, number in enumerate(numbers):
            getattr(raw, name)[place] = number
    return raw, (patterns, faults, unit, value)


def _finding(raw: _Finding) -> Finding:
    names = [effect.name for effect in load_definitions().effects]

    def name(place: int) -> str | None:
        return names[place] if place < len(names) else None

    return Finding(
        kind=FINDINGS[raw.kind],
        effect=name(raw.effect),
        runner_up=name(raw.runner_up),
        alike=tuple(one for place, one in enumerate(names) if raw.alike >> place & 1),
        score=raw.score,
        runner_up_score=raw.runner_up_score,
        limit=raw.limit,
        size=raw.size,
        energy=raw.energy,
        moved=(raw.moved[0], raw.moved[1]),
    )


def _std(std: float, reasons: int) -> float:
    """A standard error; NaN where the module leaves zero because there is none."""
    return math.nan if std == 0.0 and reasons & NOT_DETERMINED else std


_STIFF = 4  # EMA_ERR_STIFF [layout]


def _fastest(values: Reals) -> tuple[str, float]:
    """The value behind the shortest time constant of a machine [values], and that, s."""
    ids = load_definitions().ids
    inertia, viscous, gain, emf, resistance, inductance = (
        float(values[ids[name]])
        for name in (
            "screw.inertia_kgm2", "screw.viscous_Nm_s_per_rad", "motor.torque_constant_Nm_per_A", "motor.back_emf_V_s_per_rad",
            "motor.resistance_ohm", "motor.inductance_H",
        )
    )  # fmt: skip
    damped = viscous + gain * emf / resistance
    times = {"screw.inertia_kgm2": inertia / damped if damped > 0.0 else np.inf}
    if inductance > 0.0:
        times["motor.inductance_H"] = inductance / resistance
    name = min(times, key=times.__getitem__)
    return name, times[name]


class Library:
    """One precision of the module. Safe to use from several threads: no call keeps state."""

    def __init__(self, path: Path, bits: int) -> None:
        """Load `path`. Raises LibraryError when it cannot be loaded or the precisions were built from different lists."""
        self._lib = open_library(path)
        self.path = path
        self.bits = bits
        real, whole = POINTER(c_double), POINTER(c_int32)
        self._declare("ema_desk_real_bits", [])
        self._declare("ema_desk_check", [real, whole, whole])
        self._declare("ema_desk_simulate", [real, whole, real, c_int32, c_double, real, whole])
        self._declare("ema_desk_command", [c_int32, real, c_double, c_int32, real])
        self._declare("ema_desk_objective", [real, whole, real, real, real, c_int32, c_double, real])
        self._declare("ema_desk_search_default", [real, whole, POINTER(_SearchStructure)])
        self._declare(
            "ema_desk_identify",
            [real, whole, real, real, c_int32, POINTER(_SearchStructure), _PROGRESS, c_void_p, POINTER(_Result), whole],
        )
        self._declare(
            "ema_desk_identify_guarded",
            [
                real, whole, real, real, c_int32, POINTER(_SearchStructure), POINTER(_Table), _PROGRESS, c_void_p, POINTER(_Result),
                POINTER(_Finding), whole,
            ],
        )  # fmt: skip
        self._declare("ema_desk_search_check", [real, whole, POINTER(_SearchStructure), whole])
        self._declare("ema_desk_anneal", [POINTER(_Annealer), _COST, c_void_p, POINTER(_Annealed)])
        text = [c_char_p, c_int32]
        self._declare("ema_csv_count", [c_char_p, POINTER(c_int64), *text])
        self._declare("ema_csv_load", [c_char_p, real, c_int64, POINTER(c_int64), whole, real, *text])
        self._declare("ema_csv_table_check", [c_char_p, real, c_int64, c_int32, real, *text])
        self._declare("ema_csv_table_fit", [c_char_p, real, c_int64, c_double, c_double, *text])
        self._declare("ema_desk_random", [c_int64, c_int64, c_int32, POINTER(c_uint32)])
        self._declare("ema_desk_status_text", [c_int32], c_char_p)
        self._declare("ema_desk_adjusted", [real, whole, real])
        self._declare("ema_desk_site", [real, whole, c_int32, real, c_int32, real])
        self._declare("ema_desk_warmth", [real, whole, c_int32, real, c_int32, c_double, real])
        self._declare("ema_desk_contact", [real, whole, real, c_int32, real])
        self._declare("ema_desk_contact_after", [real, whole, real, real, c_int32, real])
        self._declare("ema_desk_play", [real, whole, real, c_int32, c_double, real])
        self._declare("ema_desk_controller", [real, whole, real, real, c_int32, real])
        self._check_lists()

    def _declare(self, name: str, arguments: list[object], result: object = c_int32) -> None:
        function = library_function(self._lib, name)
        function.argtypes = arguments
        function.restype = result

    def _check_lists(self) -> None:
        if self._lib.ema_desk_real_bits() != self.bits:
            raise LibraryError(
                f"{self.path.name}: calculates with {self._lib.ema_desk_real_bits()} bits, {self.bits} expected: build the project again"
            )
        own, known = read_definitions(self.path), load_definitions()
        if (own.parameters, own.effects) != (known.parameters, known.effects):
            raise LibraryError(f"{self.path.name}: built from other lists than {library_path(64).name}: build the project again")

    def status_text(self, status: int) -> str:
        """The text of a status of the C module."""
        return str(self._lib.ema_desk_status_text(status).decode())

    def _raise_on(self, status: int, doing: str, values: Reals, options: Integers) -> None:
        if status != 0:
            raise self._refusal(status, doing, values, options)

    def _refusal(self, status: int, doing: str, values: Reals, options: Integers) -> InputError:
        offender = c_int32(-1)
        if self._lib.ema_desk_check(_doubles(values), options.ctypes.data_as(POINTER(c_int32)), ctypes.byref(offender)) != 0:
            name = next((name for name, place in load_definitions().ids.items() if place == offender.value), "the actuator")
            return InputError(f"{doing}: {name}: {self.status_text(status)}: correct it in the actuator")
        if status == _STIFF:
            name, answers_s = _fastest(values)
            return InputError(
                f"{doing}: {name}: so small that the machine answers in {answers_s:.2g} s: {self.status_text(status)}, or correct {name} in the actuator"
            )
        return InputError(f"{doing}: {self.status_text(status)}: correct the actuator or the record")

    def check(self, values: Reals, options: Integers) -> None:
        """Raises InputError that names the value which this build of the module refuses."""
        self._raise_on(
            self._lib.ema_desk_check(_doubles(values), options.ctypes.data_as(POINTER(c_int32)), None), "actuator", values, options
        )

    def simulate(self, values: Reals, options: Integers, command_mm: Reals, start_mm: float = 0.0) -> Simulation:
        """Simulate one recorded row per entry of `command_mm` [rows], held over its model steps, from rest at `start_mm`.

        Raises InputError when the model refuses the actuator or leaves the finite numbers.
        """
        command = np.ascontiguousarray(command_mm, dtype=np.float64)
        out = np.empty((len(OUTPUTS), command.size))
        unlocated_event_steps = c_int32(0)
        status = self._lib.ema_desk_simulate(
            _doubles(values),
            options.ctypes.data_as(POINTER(c_int32)),
            _doubles(command),
            command.size,
            float(start_mm),
            _doubles(out),
            ctypes.byref(unlocated_event_steps),
        )
        self._raise_on(status, "simulate", values, options)
        return Simulation(out[0], out[1], out[2], out[3], out[4], unlocated_event_steps.value)

    def simulate_many(
        self, values: Reals, options: Integers, command_mm: Reals, signals: Sequence[str] = OUTPUTS, start_mm: float = 0.0
    ) -> list[Reals | InputError]:
        """Simulate each row of `values` [runs, values] with the same options; return its `signals` [signals, rows], of OUTPUTS.

        A run that the model refuses is replaced by the InputError that `simulate` raises.
        """
        rows = np.ascontiguousarray(values, dtype=np.float64)
        return [self._tried(row, options, command_mm, signals, start_mm) for row in rows]

    def _tried(self, values: Reals, options: Integers, command_mm: Reals, signals: Sequence[str], start_mm: float) -> Reals | InputError:
        try:
            run = self.simulate(values, options, command_mm, start_mm)
        except InputError as error:
            return error
        return np.array([getattr(run, name) for name in signals])

    def command(self, kind: str, numbers: dict[str, float], step_s: float, rows: int) -> Reals:
        """Samples [rows] of the command `kind` (of COMMAND_KINDS) at multiples of `step_s`; `numbers` by COMMAND_NUMBERS.

        Raises InputError when the module refuses a number.
        """
        given = np.array([numbers.get(name, 0.0) for name in COMMAND_NUMBERS], dtype=np.float64)
        out = np.empty(rows)
        status = self._lib.ema_desk_command(COMMAND_KINDS.index(kind), _doubles(given), float(step_s), rows, _doubles(out))
        if status != 0:
            shown = ", ".join(f"{name}={numbers[name]:g}" for name in COMMAND_NUMBERS if name in numbers)
            raise InputError(f"command {kind}:{shown}: {self.status_text(status)}: frequencies lie between 0 and half the record rate")
        return out

    def objective(
        self,
        values: Reals,
        options: Integers,
        command_mm: Reals,
        channels: Reals,
        weight: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0),
        start_mm: float = 0.0,
    ) -> float:
        """Integral of the weighted squared error against `channels` [rows, 4] (CHANNELS); mm^2 s with the rod position alone.

        Raises InputError when the model refuses the actuator.
        """
        command = np.ascontiguousarray(command_mm, dtype=np.float64)
        measured = _flat(channels, (command.size, len(CHANNELS)), "channels")
        out = c_double()
        status = self._lib.ema_desk_objective(
            _doubles(values),
            options.ctypes.data_as(POINTER(c_int32)),
            _doubles(command),
            _doubles(measured),
            _doubles(np.asarray(weight, dtype=np.float64)),
            command.size,
            float(start_mm),
            ctypes.byref(out),
        )
        self._raise_on(status, "objective", values, options)
        return out.value

    def _search(self, values: Reals, options: Integers, search: SearchSettings) -> _SearchStructure:
        raw = _SearchStructure()
        self._raise_on(
            self._lib.ema_desk_search_default(_doubles(values), options.ctypes.data_as(POINTER(c_int32)), ctypes.byref(raw)),
            "identify",
            values,
            options,
        )
        if search.identified is not None:
            ids = load_definitions().ids
            raw.identified_count = len(search.identified)
            for place, name in enumerate(search.identified):
                raw.identified_id[place] = ids[name]
        for name, numbers in (
            ("identified_lower", search.lower),
            ("identified_upper", search.upper),
            ("identified_min_shift_percent", search.min_shift_percent),
            ("weight", search.weight),
            ("start", search.start),
        ):
            for place, number in enumerate(numbers or ()):
                getattr(raw, name)[place] = number
        if search.start is not None:
            raw.start_at_healthy = 0
        for name in ("seed", "evaluation_budget", "function_tolerance", "initial_temperature", "abandon", "int16_record", "slice_steps"):
            number = getattr(search, name)
            if number is not None:
                setattr(raw, name, number)
        if search.search is not None:
            raw.search = SEARCHES.index(search.search)
        return raw

    def identify(
        self,
        values: Reals,
        options: Integers,
        command_mm: Reals,
        channels: Reals,
        search: SearchSettings | None = None,
        progress: Progress | None = None,
        table: Table | None = None,
    ) -> Identification:
        """Run the onboard session on a record: `command_mm` [rows], `channels` [rows, 4] (CHANNELS, NaN where not recorded).

        With a `table` it is guarded as in firmware; float32 and what the firmware's record holds give the firmware's bits.

        `progress` is called after each model run with its number, its cost, the best cost so far and the values that were tried; what it raises ends
        the search and is raised here. Raises InputError when the session refuses actuator or record.
        """
        command = np.ascontiguousarray(command_mm, dtype=np.float64)
        measured = _flat(channels, (command.size, len(CHANNELS)), "channels")
        raw = self._search(values, options, search or SearchSettings())
        names = list(load_definitions().ids)
        raised: list[BaseException] = []

        def called(evaluation: int, cost: float, best: float, tried: Any, _context: object) -> int:
            if progress is not None:
                try:
                    progress(evaluation, cost, best, tuple(tried[: raw.identified_count]) if tried else ())
                except BaseException as error:  # an exception cannot pass through C
                    raised.append(error)
                    return 1
            return 0

        result, found, bad_row = _Result(), _Finding(), c_int32(-1)
        given = (_doubles(values), options.ctypes.data_as(POINTER(c_int32)), _doubles(command), _doubles(measured), command.size)
        callback = _PROGRESS(called) if progress is not None else _PROGRESS()
        into, row = ctypes.byref(result), ctypes.byref(bad_row)
        if table is None:
            status = self._lib.ema_desk_identify(*given, ctypes.byref(raw), callback, None, into, row)
        else:
            behind, _kept = _raw_table(table)
            status = self._lib.ema_desk_identify_guarded(
                *given, ctypes.byref(raw), ctypes.byref(behind), callback, None, into, ctypes.byref(found), row
            )
        if raised:
            raise raised[0]
        if status != 0 and bad_row.value >= 0:
            raise InputError(f"identify: sample {bad_row.value + 1} of the record: {self.status_text(status)}: correct the record")
        self._raise_on(status, "identify", values, options)
        stds = [_std(result.std[place], result.reasons) for place in range(raw.identified_count)]
        identified = tuple(
            IdentifiedValue(
                names[raw.identified_id[place]],
                result.estimate[place],
                std,
                result.shift_percent[place],
                bool(result.at_bound[place]),
                result.today[place],
                math.nan if math.isnan(std) else result.bias[place],
                math.nan if math.isnan(std) else result.half_95[place],
                result.scatter_percent[place],
            )
            for place, std in enumerate(stds)
        )
        return Identification(
            identified=identified,
            objective_before=result.objective_before,
            objective_after=result.objective_after,
            residual_rms_mm=result.residual_rms_mm,
            residual_correlation=result.residual_correlation,
            model_steps=result.model_steps,
            evaluations=result.evaluations,
            accepted=result.accepted,
            accepted_uphill=result.accepted_uphill,
            outcome=OUTCOMES[result.outcome],
            stage=STAGES[result.stage],
            verdict=VERDICTS[result.verdict],
            adequate=bool(result.adequate),
            reasons=tuple(text for bit, text in REASONS.items() if result.reasons & bit),
            random_state=result.random_state,
            finding=None if table is None else _finding(found),
        )

    def search_warnings(self, values: Reals, options: Integers, search: SearchSettings | None = None) -> tuple[str, ...]:
        """Why a search with these settings will not reach its lowest cost, and what to do: texts of WARNINGS. Raises InputError as `identify`."""
        raw = self._search(values, options, search or SearchSettings())
        warnings = c_int32(0)
        status = self._lib.ema_desk_search_check(
            _doubles(values), options.ctypes.data_as(POINTER(c_int32)), ctypes.byref(raw), ctypes.byref(warnings)
        )
        self._raise_on(status, "identify", values, options)
        return tuple(text for bit, text in WARNINGS.items() if warnings.value & bit)

    def anneal(self, settings: AnnealerSettings, cost: Callable[[Reals, float], float]) -> Annealed:
        """Run the module's annealer on `cost` of a point [dimension] of the unit box and the limit above which it may be given up early.

        What `cost` raises ends the search and is raised here. Raises InputError for settings that the annealer refuses.
        """
        dimension = len(settings.start)
        raw = _Annealer(
            dimension=dimension,
            **{name: value for name, value in vars(settings).items() if name != "start"},
        )
        for place, number in enumerate(settings.start[:DIMENSION_MAX]):
            raw.start[place] = number
        raised: list[BaseException] = []

        def called(x: Any, limit: float, into: Any, _context: object) -> int:
            try:
                into[0] = cost(np.array(x[:dimension]), limit)
            except BaseException as error:  # an exception cannot pass through C
                raised.append(error)
                return 1
            return 0

        found = _Annealed()
        status = self._lib.ema_desk_anneal(ctypes.byref(raw), _COST(called), None, ctypes.byref(found))
        if raised:
            raise raised[0]
        if status != 0:
            raise InputError(f"anneal: {self.status_text(status)}: correct the settings")
        return Annealed(np.array(found.x[:dimension]), found.cost, found.evaluations, OUTCOMES[found.outcome])

    def read_csv(self, path: str | Path) -> tuple[Reals, int, float]:
        """A recording as the host program reads it: table [rows, 7] in the order of RECORD_COLUMNS with NaN for absent columns, the bits of
        the present columns, and the period in s.

        Raises InputError with the reader's line, which names file, row and column.
        """
        name = os.fsencode(path)
        message = ctypes.create_string_buffer(_MESSAGE_BYTES)
        rows, period_s, mask = c_int64(0), c_double(0.0), c_int32(0)
        status = self._lib.ema_csv_count(name, ctypes.byref(rows), message, _MESSAGE_BYTES)
        if status == 0:
            table = np.empty((rows.value, len(RECORD_COLUMNS)))
            status = self._lib.ema_csv_load(
                name, _doubles(table), rows.value, ctypes.byref(rows), ctypes.byref(mask), ctypes.byref(period_s), message, _MESSAGE_BYTES
            )
        if status != 0:
            raise InputError(message.value.decode(errors="backslashreplace"))
        return table, mask.value, period_s.value

    def check_table(self, name: str, table: Reals, mask: int) -> float:
        """The checks of `read_csv` on a table that came from elsewhere, rows counted from 1; the period in s. Raises InputError."""
        message = ctypes.create_string_buffer(_MESSAGE_BYTES)
        period_s = c_double(0.0)
        status = self._lib.ema_csv_table_check(
            os.fsencode(name), _doubles(table), len(table), mask, ctypes.byref(period_s), message, _MESSAGE_BYTES
        )
        if status != 0:
            raise InputError(message.value.decode(errors="backslashreplace"))
        return period_s.value

    def check_fit(self, name: str, table: Reals, travel_mm: float, record_period_s: float) -> None:
        """Raises InputError when a recording cannot be of an actuator with this travel and record period: wrong unit, wrong rate."""
        message = ctypes.create_string_buffer(_MESSAGE_BYTES)
        if (
            self._lib.ema_csv_table_fit(os.fsencode(name), _doubles(table), len(table), travel_mm, record_period_s, message, _MESSAGE_BYTES)
            != 0
        ):
            raise InputError(message.value.decode(errors="backslashreplace"))

    def random_bits(self, seed: int, stream: int, count: int) -> NDArray[np.uint32]:
        """The first `count` numbers of the module's generator, [count]."""
        bits = np.empty(count, dtype=np.uint32)
        self._lib.ema_desk_random(seed, stream, count, bits.ctypes.data_as(POINTER(c_uint32)))
        return bits

    def adjusted(self, values: Reals, options: Integers) -> Reals:
        """The values with what the effects at site PARAMETER make of them, in the same order."""
        out = np.empty(values.size)
        status = self._lib.ema_desk_adjusted(_doubles(values), options.ctypes.data_as(POINTER(c_int32)), _doubles(out))
        self._raise_on(status, "adjusted", values, options)
        return out

    def site(self, values: Reals, options: Integers, site: str, points: Reals) -> Reals:
        """Sum over the active effects of one of SITES that gives a number at a point; `points` [7, rows] by POINT, where READING means the rod's position. [rows]

        Raises InputError for another site.
        """
        rows = np.shape(points)[-1]
        out = np.empty(rows)
        status = self._lib.ema_desk_site(
            _doubles(values),
            options.ctypes.data_as(POINTER(c_int32)),
            SITES.index(site),
            _doubles(_flat(points, (len(POINT), rows), "points")),
            rows,
            _doubles(out),
        )
        self._raise_on(status, f"site {site}", values, options)
        return out

    def warmth(self, values: Reals, options: Integers, site: str, current_A: Reals, period_s: float) -> Reals:
        """Relative change of what warms along a record, none at its first row: of the winding's resistance (`site` WINDING) or of dry and viscous friction (GREASE). [rows]

        Raises InputError for another site.
        """
        current = np.ascontiguousarray(current_A, dtype=np.float64)
        out = np.empty(current.size)
        status = self._lib.ema_desk_warmth(
            _doubles(values),
            options.ctypes.data_as(POINTER(c_int32)),
            SITES.index(site),
            _doubles(current),
            current.size,
            float(period_s),
            _doubles(out),
        )
        self._raise_on(status, f"site {site}", values, options)
        return out

    def contact(self, values: Reals, options: Integers, angle_rad: Reals) -> Reals:
        """Share of the level of dry friction that a stretching contact carries along `angle_rad` [rows], unstretched at the first; zero without such an effect. [rows]"""
        angle = np.ascontiguousarray(angle_rad, dtype=np.float64)
        out = np.empty(angle.size)
        status = self._lib.ema_desk_contact(
            _doubles(values), options.ctypes.data_as(POINTER(c_int32)), _doubles(angle), angle.size, _doubles(out)
        )
        self._raise_on(status, "contact", values, options)
        return out

    def contact_after(self, values: Reals, options: Integers, before: Reals, turn_rad: Reals) -> Reals:
        """The share that a contact carries after a turn [rows] from the one before it [rows]. [rows]"""
        shares, turns = (np.ascontiguousarray(column, dtype=np.float64) for column in (before, turn_rad))
        out = np.empty(shares.size)
        status = self._lib.ema_desk_contact_after(
            _doubles(values), options.ctypes.data_as(POINTER(c_int32)), _doubles(shares), _doubles(turns), shares.size, _doubles(out)
        )
        self._raise_on(status, "contact_after", values, options)
        return out

    def play(self, values: Reals, options: Integers, motor_mm: Reals, start_mm: float) -> Reals:
        """Output of the play behind `motor_mm` [rows], from `start_mm`. [rows]"""
        motor = np.ascontiguousarray(motor_mm, dtype=np.float64)
        out = np.empty(motor.size)
        status = self._lib.ema_desk_play(
            _doubles(values), options.ctypes.data_as(POINTER(c_int32)), _doubles(motor), motor.size, float(start_mm), _doubles(out)
        )
        self._raise_on(status, "play", values, options)
        return out

    def controller(self, values: Reals, options: Integers, command_mm: Reals, feedback_mm: Reals) -> Reals:
        """Normalised output of the control law for a command and a feedback as recorded, both [rows], one row per record period; encoder delay and resolution in it. [rows]

        Raises InputError when the feedback is delayed by more steps than the module keeps.
        """
        command = np.ascontiguousarray(command_mm, dtype=np.float64)
        feedback = _flat(feedback_mm, (command.size,), "feedback_mm")
        out = np.empty(command.size)
        status = self._lib.ema_desk_controller(
            _doubles(values), options.ctypes.data_as(POINTER(c_int32)), _doubles(command), _doubles(feedback), command.size, _doubles(out)
        )
        self._raise_on(status, "controller", values, options)
        return out


@functools.cache
def library(bits: int = 64) -> Library:
    """The library of one precision, 32 as onboard or 64 for analysis; loaded once.

    Raises LibraryError when it is absent or the precisions were built from different lists.
    """
    return Library(library_path(bits), bits)
