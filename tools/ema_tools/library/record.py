"""What is known of one effect beside its row of `ema_effects.def`, as types: what `library/effects/<name>.py` fills in as `EFFECT`.

Every field but `shows` may be left out; what then holds is said at the field, and it is what an effect of the user's own gets. Values are named by their field in the effect's row.
Code asks a record and never the name of an effect.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from ema_tools.library.measurements import Measurement
from ema_tools.library.torques import AlongStroke, Bending, LocalTorque, PeriodicTorque, Shape, combined


@dataclass(frozen=True)
class Typical:
    """The lower end of what is usual, on the reference actuator: values by field, the size among them, and where they come from."""

    values: Mapping[str, float]
    why: str


@dataclass(frozen=True)
class Slight:
    """What every machine has of an effect and no data sheet states, so that it is not named without healthy repeats: one standard deviation of its size.

    `of_friction`: the size is a share of the dry friction's level. `free`: values by field that are free within one standard deviation when a unit is known by its data sheet alone.
    """

    size: float
    of_friction: bool = False
    free: tuple[Mapping[str, float], ...] = ()

    def usual(self, friction_Nm: float) -> float:
        """One standard deviation of the size on a machine with this level of dry friction."""
        return self.size * friction_Nm if self.of_friction else self.size


@dataclass(frozen=True)
class ConfoundedParameter:
    """A parameter of the machine that does exactly what the effect does; `size_per_change`: the effect's size per relative change of it, or per its own unit where a data sheet has it as zero."""

    parameter: str
    size_per_change: float


@dataclass(frozen=True)
class BelowPeak:
    """An effect that acts only below the largest current, whatever its size is above that: sizes as shares of the peak, the mildest first."""

    tried: tuple[float, ...]
    typical: float
    onboard: tuple[float, ...]


@dataclass(frozen=True)
class Onboard:
    """What the onboard table holds of an effect: shapes by field, `of_reach`: fields whose values are shares of the command's reach.

    `sizes`: fixed ones, for a signature that changes with the size; none: one that stands as far out of the noise as the table wants. `larger`: further distances from the noise,
    in standard deviations, for a signature that turns with the size.
    """

    shapes: Mapping[str, Sequence[float]] = field(default_factory=dict)
    of_reach: tuple[str, ...] = ()
    sizes: tuple[float, ...] = ()
    larger: tuple[float, ...] = ()

    def shapes_at(self, reach_mm: float) -> list[Shape]:
        """Every shape by field under a command that reaches so far."""
        return combined(
            {name: [share * reach_mm for share in shares] if name in self.of_reach else shares for name, shares in self.shapes.items()}
        )


@dataclass(frozen=True)
class LearnedKind:
    """A table that is learned: what is left of which balance it holds, as friction or as it is, and the axes (by number, see EMA_TABLE) of which it can be a function."""

    balance: str
    axes: frozenset[int]
    friction: bool = False


@dataclass(frozen=True)
class EffectRecord:
    """All that the tools know of one effect and its row does not say."""

    # Where a chirp of the position command shows it: balance, state, frequencies.
    shows: str
    # None: the size at which the first command of a menu shows it plainly.
    typical: Typical | None = None
    # None: whatever is found of it is named.
    slight: Slight | None = None
    # Size that a known machine may have of it today with nobody the wiser, one standard deviation; none: only what is named.
    today: float = 0.0
    # The same between the runs of a machine that is known by its baseline records.
    varies: float = 0.0
    # Shapes that are as good as independent of each other: among so many the best one explains some noise.
    independent_shapes: int = 1
    # Values of shape that are tried where no torque suggests them; none: they stay as they are.
    shapes: Mapping[str, Sequence[float]] = field(default_factory=dict)
    # First sizes tried; none: a ladder of shares of the row's range.
    first: tuple[float, ...] = ()
    # The power of the size with which what it shows grows.
    power: float = 1.0
    below_peak: BelowPeak | None = None
    # The torque that it makes, in closed form, so that hundreds of shapes are tried at once. None: by simulation and by the balance with and without it.
    periodic: PeriodicTorque | None = None
    local: LocalTorque | None = None
    bending: Bending | None = None
    # A table that the balance of forces finds over the stroke; by simulation it is what is left over the position.
    along: AlongStroke | None = None
    # A parameter whose spread hides it without healthy repeats.
    confounded: ConfoundedParameter | None = None
    # A base value of the mechanical balance that it is one with.
    base_value: str = ""
    # Whether beside base values that are fitted less than none of it is another effect.
    adds: bool = False
    # Whether the balance of forces seeks it; one that would stand in there for others is sought by simulation alone.
    in_balance: bool = True
    # The effect that it is in a special case, which is named in its place while it explains nearly as much.
    special_case: str = ""
    # What to say where nothing else was found in a machine of which no healthy records are known, since nearly all machines have it; empty for what is a change.
    usual: str = ""
    # Effects from which no record of one machine tells it apart; they name it too.
    inseparable: tuple[str, ...] = ()
    # What tells it from others that are separated by the same, where a command does not.
    separated_by: tuple[Measurement, ...] = ()
    onboard: Onboard = Onboard()
    learned: LearnedKind | None = None

    @property
    def is_shaped(self) -> bool:
        """Whether a little of it hangs on more than its size: on an angle, a place or a shape that differs from machine to machine."""
        more = self.slight is not None and any(len(values) > 1 for values in self.slight.free)
        return more or self.periodic is not None or (self.local is not None and bool(self.local.spot))


# Of an effect of the user's own.
GENERIC = EffectRecord(shows="not stated: an effect of your own; ema diagnose ranks it by simulation")
