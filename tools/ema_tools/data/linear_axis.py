"""The mechanics of an actuator as a linear axis would state them, at the rod: force = mass a + viscous v + coulomb sgn v + offset."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass

from ema_tools.data.actuator import Actuator

VALUES = ("screw.inertia_kgm2", "screw.viscous_Nm_s_per_rad", "screw.csj_Nm", "screw.load_torque_Nm")


@dataclass(frozen=True)
class ForceModel:
    """force = mass a + viscous v + coulomb sgn v + offset, at the rod; or the standard errors of these."""

    mass_kg: float
    viscous_N_s_per_m: float
    coulomb_N: float
    offset_N: float

    def as_dict(self) -> dict[str, float]:
        """By field."""
        return asdict(self)


def to_values(model: ForceModel, n_m_per_rad: float) -> dict[str, float]:
    """A force model as values of an actuator whose rod travels `n_m_per_rad` per motor angle."""
    n = n_m_per_rad
    return dict(zip(VALUES, (model.mass_kg * n * n, model.viscous_N_s_per_m * n * n, model.coulomb_N * n, model.offset_N * n), strict=True))


def at_rod(values: Mapping[str, float], n_m_per_rad: float) -> ForceModel:
    """Values of an actuator, or their standard errors, as a force model; the reverse of `to_values`."""
    n = n_m_per_rad
    inertia, viscous, friction, load = (values[name] for name in VALUES)
    return ForceModel(inertia / (n * n), viscous / (n * n), friction / n, load / n)


def lead_m_per_rad(actuator: Actuator) -> float:
    """Rod travel per motor angle, m/rad."""
    return 1e-3 * actuator.lead_mm_per_rad
