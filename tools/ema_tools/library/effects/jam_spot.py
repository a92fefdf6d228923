"""A damaged spot of the raceway."""

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.library import measurements
from ema_tools.library.record import EffectRecord, Onboard, Slight, Typical
from ema_tools.library.torques import LocalTorque, Shape, States, places, shares_of_stroke

_PLACES = 61  # places that are tried along the stroke: as far apart as the narrowest spot is wide on the reference chirp's [effort]


def _torque(states: States, shape: Shape) -> Reals:
    return -(states.direction * np.exp(-(((states.screw_mm - shape["place_mm"]) / shape["width_mm"]) ** 2)))


EFFECT = EffectRecord(
    shows="mechanical balance: friction at one place of the stroke, on every pass and in both directions",
    typical=Typical({"amplitude_Nm": 0.02, "place_mm": 0.5, "width_mm": 0.1}, "usual: 0.02 to 0.5 Nm over 0.1 to 1 mm; the place is any"),
    # it stands in for the ripple of a screw where a record shows less than a lead
    slight=Slight(0.004, of_friction=True),
    independent_shapes=60,
    local=LocalTorque(
        torque=_torque,
        tried={"place_mm": places(_PLACES), "width_mm": (0.06, 0.12, 0.25, 0.5, 1.0)},
        spot="width_mm",
        in_balance={"place_mm": places(_PLACES), "width_mm": shares_of_stroke((0.003, 0.006, 0.0125, 0.025, 0.05))},
    ),
    separated_by=(measurements.BREAK_AWAY,),
    onboard=Onboard({"place_mm": (-0.8, -0.55, -0.3, 0.0, 0.3, 0.55, 0.8), "width_mm": (0.15,)}, of_reach=("place_mm", "width_mm")),
)
