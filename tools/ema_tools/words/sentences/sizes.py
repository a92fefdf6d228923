"""Values with their errors and units."""

from __future__ import annotations

from ema_tools.data.actuator import row_of


def size_text(name: str, value: float, std: float | None) -> str:
    """A value with its standard error and unit, as in `0.31 +- 0.02 Nm`."""
    unit = row_of(name).unit
    doubt = f" +- {std:.2g}" if std is not None else ""
    return f"{value:.4g}{doubt}{' ' + unit if unit else ''}"
