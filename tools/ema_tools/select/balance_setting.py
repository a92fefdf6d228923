"""Records seen by the mechanical balance under one actuator: what the torques of effects are made from, the rows of all records one after another."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ema_tools.balances.effects import adjusted
from ema_tools.balances.filtering import Smoother
from ema_tools.balances.mechanical import Mechanical, mechanical_model
from ema_tools.balances.motion import Motion, motion_of, train_of
from ema_tools.base.arrays import Reals
from ema_tools.base.lag import lagged
from ema_tools.data.actuator import Actuator
from ema_tools.data.motion_records import AnyRecord, MotionRecord
from ema_tools.library.definitions import load_definitions
from ema_tools.library.registry import record_of
from ema_tools.library.torques import States

# Another place and another screw, of no simple relation to the first [judgement]
_ANOTHER_RAD, _OTHERWISE = 1.0, 0.73
_SCREW = ("screw.lead_mm", "gearbox.ratio")
LEVEL = "screw.csj_Nm"
VISCOUS = "screw.viscous_Nm_s_per_rad"


@dataclass(frozen=True)
class Piece:
    """One record: its balance and its motion, each on every row."""

    record: AnyRecord
    model: Mechanical
    motion: Motion
    read_with: tuple[object, ...]  # what of the actuator the motion was made with
    foretold: bool = False  # whether the current is what the model asks for, not what was recorded

    @staticmethod
    def of(actuator: Actuator, record: AnyRecord, smoother: Smoother, like: Piece | None = None) -> Piece:
        """`like`: the same record under another actuator, whose motion serves again where nothing that it is made with has changed. Raises MissingSignal."""
        read_with = _read_with(actuator, record)
        same = like is not None and like.record is record and like.model.smoother == smoother and read_with and like.read_with == read_with
        slid = like.model.slides if like is not None and same else None
        if like is not None and like.foretold:
            return replace(like, model=mechanical_model(actuator, record, smoother, like.motion, slid))
        motion = like.motion if like is not None and same else motion_of(actuator, record, smoother)
        return Piece(record, mechanical_model(actuator, record, smoother, motion, slid), motion, read_with)


def _read_with(actuator: Actuator, record: AnyRecord) -> tuple[object, ...]:
    """What the motion of a record is made with; nothing for one whose position effects may read wrongly."""
    if not isinstance(record, MotionRecord):
        return ()
    return (train_of(actuator), adjusted(actuator)["motor.torque_constant_Nm_per_A"], *(actuator.values[name] for name in _SCREW))


@dataclass(frozen=True)
class Setting:
    """The actuator as far as it is known, and the records' balances under it. What is joined has the rows of all records one after another, [rows].

    `carried`: torques of what the machine is known to carry beside the actuator, [rows, k], which are part of a drive that is foretold.
    """

    actuator: Actuator
    pieces: tuple[Piece, ...]
    carried: Reals | None = None
    _required: dict[str, Reals] = field(default_factory=dict)

    @staticmethod
    def of(actuator: Actuator, records: Sequence[AnyRecord], smoothers: Sequence[Smoother]) -> Setting:
        """Raises MissingSignal."""
        return Setting(actuator, tuple(Piece.of(actuator, record, smoother) for record, smoother in zip(records, smoothers, strict=True)))

    def with_actuator(self, actuator: Actuator) -> Setting:
        """The same records under another actuator. Raises MissingSignal, InputError."""
        return Setting(
            actuator, tuple(Piece.of(actuator, piece.record, piece.model.smoother, piece) for piece in self.pieces), self.carried
        )

    @functools.cached_property
    def waveless(self) -> Setting:
        """The same without the waves that the actuator has, which make everything beside them depend a little on the place."""
        zero = {size: zero for name, size, zero in load_definitions().sizes if record_of(name).periodic is not None}
        waves = {size: value for size, value in zero.items() if self.actuator.values[size] != value}
        return self.with_actuator(self.actuator.changed(waves)) if waves else self

    @functools.cached_property
    def elsewhere(self) -> Setting:
        """The same as if every record whose place is not known had begun at another one."""
        moved = [
            replace(piece.record, start_rad=_ANOTHER_RAD) if isinstance(piece.record, MotionRecord) else piece.record
            for piece in self.pieces
        ]
        return replace(Setting.of(self.actuator, moved, [piece.model.smoother for piece in self.pieces]), carried=self.carried)

    @functools.cached_property
    def on_another_screw(self) -> Setting:
        """The same as if the lead and the ratio that are not stated were others."""
        changes = {name: _OTHERWISE * self.actuator.values[name] for name in _SCREW if not self.actuator.has(name)}
        if not changes:
            return self
        # still not stated: nothing is converted by them
        other = replace(self.actuator.changed(changes), absent=self.actuator.absent)
        return self.with_actuator(other)

    @property
    def rows(self) -> int:
        """Of all records."""
        return sum(piece.record.rows for piece in self.pieces)

    def joined(self, of_piece: Callable[[Piece], Reals]) -> Reals:
        """A column of every record, [rows]."""
        return np.concatenate([of_piece(piece) for piece in self.pieces])

    def as_seen(self, columns: Reals) -> Reals:
        """Torques worked out row by row, as the filtered drives show them, [rows, k]."""
        ends = np.cumsum([piece.record.rows for piece in self.pieces])[:-1]
        parts = zip(self.pieces, np.split(columns, ends), strict=True)
        seen = ((piece, piece.model.smoother.as_seen(part)) for piece, part in parts)
        return np.concatenate([lagged(part, piece.record.period_s, piece.model.lag_s) for piece, part in seen])

    @property
    def drive_Nm(self) -> Reals:
        """The motor's torque, [rows]."""
        return self.joined(lambda piece: piece.model.drive_Nm)

    @functools.cached_property
    def foretold(self) -> Setting:
        """The same with the drive that the base values, and what is carried, ask for in place of the recorded one, in whose error an effect that reads the drive would find itself."""
        constant = adjusted(self.actuator)["motor.torque_constant_Nm_per_A"]
        carried = np.zeros((self.rows, 0)) if self.carried is None else self.carried
        ends = np.cumsum([piece.record.rows for piece in self.pieces])[:-1]
        pieces = []
        for piece, beside in zip(self.pieces, np.split(carried, ends), strict=True):
            model = piece.model
            columns = np.column_stack([model.columns, beside])
            moves = ~model.resting
            target = model.drive_Nm - model.load_Nm - model.added_Nm
            base = np.linalg.lstsq(columns[moves], target[moves], rcond=None)[0]
            asked = np.where(moves, model.load_Nm + model.added_Nm + columns @ base, model.drive_Nm)
            motion = replace(piece.motion, current_A=asked / constant)
            pieces.append(
                replace(piece, motion=motion, model=mechanical_model(self.actuator, piece.record, model.smoother, motion), foretold=True)
            )
        return Setting(self.actuator, tuple(pieces))

    @property
    def placed(self) -> bool:
        """Whether every record says where the machine is, and not only how it moves."""
        return all(piece.motion.placed for piece in self.pieces)

    @functools.cached_property
    def states(self) -> States:
        """The measured motion, as the torques of effects take it."""
        values = adjusted(self.actuator)
        motor_mm = self.joined(lambda piece: piece.motion.motor_mm)
        return States(
            self.joined(lambda piece: piece.model.contact),
            self.joined(lambda piece: piece.motion.speed_rad_s),
            self.joined(lambda piece: piece.motion.angle_rad),
            2.0 * np.pi * motor_mm / self.actuator.values["screw.lead_mm"],
            motor_mm,
            self.joined(lambda piece: piece.motion.current_A),
            self.joined(lambda piece: piece.record.time_s - piece.record.first_time_s),
            values["motor.torque_constant_Nm_per_A"],
            values["motor.back_emf_V_s_per_rad"],
            values["screw.dynamic_ratio"] * values[LEVEL],
            values[VISCOUS],
        )

    def required_Nm(self, halved: str = "") -> Reals:
        """What the balance says the motor must bring up, less what it does, on every row that slides, a constant torque apart; with one base value halved, [rows]."""
        if halved not in self._required:
            setting = self.with_actuator(self.actuator.changed({halved: 0.5 * self.actuator[halved]})) if halved else self
            values = adjusted(setting.actuator)
            base = np.array(
                (
                    values["screw.inertia_kgm2"],
                    values[VISCOUS],
                    values["screw.dynamic_ratio"] * values[LEVEL],
                    values["screw.load_torque_Nm"],
                )
            )
            self._required[halved] = setting.joined(
                lambda piece: piece.model.load_Nm + piece.model.added_Nm + piece.model.columns @ base - piece.model.drive_Nm
            )
        return self._required[halved]
