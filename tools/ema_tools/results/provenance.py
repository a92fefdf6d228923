"""What result files share: curves for the page, and where a result came from."""

from __future__ import annotations

import platform

import numpy as np

from ema_tools import __version__
from ema_tools.base.arrays import Reals
from ema_tools.data.records import Record
from ema_tools.plant.native import OUTPUTS, Simulation
from ema_tools.results.codec import Series
from ema_tools.results.parts import Channels, CurvesEntry, Provenance

# Longer records are left out of result files; the page would not show more.
CURVE_ROWS_MAX = 200_000
_DIGITS = 8


def rounded(values: Reals) -> Series:
    """Values [n] with the digits that a curve needs."""
    scale = float(np.max(np.abs(values), initial=0.0))
    if not scale > 0.0:
        return (0.0,) * values.size
    return tuple(float(value) for value in np.round(values, max(0, _DIGITS - int(np.ceil(np.log10(scale))))))


def curves(
    record: Record, *, model: Simulation | None = None, before: Simulation | None = None, after: Simulation | None = None
) -> CurvesEntry | None:
    """Measured and simulated channels for the page; None for a very long record."""
    if record.rows > CURVE_ROWS_MAX:
        return None
    measured = {name: rounded(values) for name in OUTPUTS if (values := record.channel(name)) is not None}

    def of(simulation: Simulation | None) -> Channels | None:
        if simulation is None:
            return None
        return Channels(**{name: rounded(getattr(simulation, name)) for name in OUTPUTS if name in measured or name == "position_mm"})

    return CurvesEntry(
        start_s=record.first_time_s,
        period_s=record.period_s,
        measured=Channels(**measured),
        model=of(model),
        before=of(before),
        after=of(after),
    )


def provenance(command: str, **entries: object) -> Provenance:
    """What made a result: the command line, versions, and further entries as text."""
    found = {"command": command, "ema": __version__, "python": platform.python_version(), "numpy": np.__version__}
    return {**found, **{name.replace("_", " "): str(value) for name, value in entries.items()}}
