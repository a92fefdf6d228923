"""A winding that warms as the record runs."""

from ema_tools.library import measurements
from ema_tools.library.record import EffectRecord, Onboard, Slight, Typical

EFFECT = EffectRecord(
    shows="electrical balance: voltage in proportion to the current that grows from the record's start to its end; the position shows it where currents are large",
    typical=Typical(
        {"rise_degC_per_W": 6.0, "time_s": 5.0},
        "usual: 1 to 20 % of the resistance within a record; motor makers state 1 to 10 degC per W and seconds to minutes",
    ),
    # what any winding does within a chirp: a degree or two
    slight=Slight(0.3),
    independent_shapes=2,
    shapes={"time_s": (1.5, 5.0, 20.0)},
    separated_by=(measurements.BUS_AND_WINDING,),
    onboard=Onboard({"time_s": (5.0,)}),
)
