"""A recording followed as it grows: curves beside the model's, what the onboard search reads so far, and the verdict once no further row comes."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.base.errors import InputError
from ema_tools.data.actuator import Actuator
from ema_tools.data.growing import Growing
from ema_tools.data.records import Record, simulated
from ema_tools.plant.native import Identification, SearchSettings, Simulation
from ema_tools.tasks.baseline_records import baseline_records_of
from ema_tools.tasks.identify import Identified, identify
from ema_tools.tasks.onboard_search import check_record, run

Phase = Literal["waiting", "recording", "judging", "judged"]

QUIET_S = 3.0  # without a further row, after which a recording is complete [layout]
_LEAST_S = 1.0  # of a recording before it is searched for the first time [layout]
_FEW_LINES = 200  # of a file: fewer may be no recording yet, and that is no trouble [layout]
_EVERY_S = 1.0  # between two searches of what there is so far [layout]


@dataclass(frozen=True)
class Seen:
    """What is known of the recording by now. `version` rises with every change; `notes`: what happened to the file, the latest last; `trouble`: why what there is cannot be read or searched."""

    version: int = 0
    phase: Phase = "waiting"
    record: Record | None = None
    model: Simulation | None = None
    so_far: Identification | None = None
    found: Identified | None = None
    healthy: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    trouble: str = ""


class Watch:
    """One recording, followed. `step` does what there is to do; `seen` is what is known, and may be read from another thread."""

    def __init__(
        self,
        actuator: Actuator,
        growing: Growing,
        healthy: Sequence[Record] = (),
        quiet_s: float = QUIET_S,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """`healthy`: the unit's healthy runs, those that its file names when there are none; `clock`: seconds, only to see how long no row has come."""
        self.seen = Seen()
        self._actuator, self._growing, self._healthy = actuator, growing, tuple(healthy)
        self._quiet_s, self._clock = quiet_s, clock
        self._last_row_s = self._last_search_s = clock()
        self._begun = growing.begun
        self._untold = False  # rows have come that no verdict was said of
        self._unread = ""  # why they cannot be read, all of them

    def step(self) -> bool:
        """Read what has come, and search or judge it where it is time; whether anything has changed. Raises InputError where there is nothing to read from."""
        version = self.seen.version
        grown = self._growing.read()
        now = self._clock()
        if self._growing.begun != self._begun:
            self._begun = self._growing.begun
            told = f"{self._growing.file} was begun anew after {self.seen.record.rows if self.seen.record else 0} rows"
            self._change(phase="waiting", record=None, model=None, so_far=None, found=None, trouble="", notes=(*self.seen.notes, told))
        if grown:
            self._last_row_s, self._untold = now, True
            self._take()
        elif self._untold and now - self._last_row_s >= self._quiet_s:
            self._untold = False
            self._judge()
        return self.seen.version != version

    def _change(self, **changes: object) -> None:
        self.seen = replace(self.seen, version=self.seen.version + 1, **changes)  # type: ignore[arg-type]

    def _say_trouble(self, text: str) -> None:
        if text != self.seen.trouble:
            self._change(trouble=text)

    def _take(self) -> None:
        """The rows so far, beside the model; what cannot be read leaves what was read before."""
        try:
            record = self._growing.record(self._actuator)
            model = simulated(self._actuator, record)
        except InputError as error:
            self._unread = str(error)
            if self._growing.lines >= _FEW_LINES:
                self._say_trouble(self._unread)
            return
        self._unread = ""
        if self.seen.record is not None and record.rows == self.seen.record.rows:
            return
        if self.seen.phase == "judged":
            self._change(
                notes=(*self.seen.notes, f"{self._growing.file} grew again after {self.seen.record.rows if self.seen.record else 0} rows")
            )
        self._change(phase="recording", record=record, model=model, found=None, trouble="")
        if record.rows * record.period_s >= _LEAST_S and self._clock() - self._last_search_s >= _EVERY_S:
            self._search(record)
            self._last_search_s = self._clock()

    def _search(self, record: Record) -> None:
        """What the onboard search reads of the rows so far."""
        try:
            check_record(self._actuator, record, SearchSettings())
            self._change(so_far=run(self._actuator, record, SearchSettings(), 32))
        except InputError as error:
            self._change(so_far=None)
            self._say_trouble(f"so far: {error}")

    def _judge(self) -> None:
        """The verdict on the whole recording, beside the unit's healthy runs."""
        record = self.seen.record
        if record is None:
            self._change(phase="judged", trouble=self._unread)
            return
        self._change(phase="judging")
        try:
            healthy = self._healthy or baseline_records_of(self._actuator, record)
            found = identify(self._actuator, record, healthy)
        except InputError as error:
            self._change(phase="judged", trouble=self._unread or str(error))
            return
        held = tuple(one.file for one in healthy)
        self._change(phase="judged", found=found, healthy=held, trouble=self._unread, model=simulated(found.actuator, record))


def residual(record: Record, model: Simulation, name: str) -> Reals:
    """Measured minus simulated of one channel, [rows]."""
    simulated_values: Reals = getattr(model, name)
    return np.asarray(record.recorded(name) - simulated_values)
