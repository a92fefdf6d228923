"""The drive foretold from the motion alone: what a fit is worth where an effect reads the measured torque, current or voltage, in whose error it could find itself.

The fit's own drive takes the place of the measured one wherever an effect looks at it, over and over until both are the same.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ema_tools.balances.effects import adjusted
from ema_tools.balances.mechanical import mechanical_model
from ema_tools.base.arrays import Reals
from ema_tools.base.errors import InputError
from ema_tools.data.actuator import Actuator
from ema_tools.library.definitions import load_definitions
from ema_tools.plant.native import POINT, library
from ema_tools.select.balance_bench import Bench, Fitted
from ema_tools.select.balance_setting import Setting
from ema_tools.select.torque_patterns import rows_of

_ROUNDS = 3  # after which the foretold drive has settled: what reads it is a small part of it [effort]
_PROBE = 0.1  # of an effect's range, at which it is asked whether it reads the drive [judgement]


def reads_drive(actuator: Actuator, effect: str) -> bool:
    """Whether an effect's torque depends on the current, by its own equation."""
    row = load_definitions().effect(effect)
    if row.site == "MOTOR":
        return True
    if row.site not in ("FRICTION", "TORQUE", "LOAD"):
        return False
    size = row.size
    end = size.upper if size.upper > size.nominal else size.lower
    try:
        with_it = actuator.changed({size.name: size.nominal + _PROBE * (end - size.nominal)})
        points = np.ones((len(POINT), 3))
        points[POINT.index("current_A")] = (-1.0, 0.5, 2.0)
        points[POINT.index("level_Nm")] = max(actuator["screw.csj_Nm"], 1e-6)
        return bool(np.ptp(library().site(*with_it.arrays(), row.site, points)) > 0.0)
    except InputError:
        return False


def foretold_percent(bench: Bench, fit: Fitted) -> float:
    """Relative error in % of the drive that a fit foretells from the motion alone, on everything that is ever fitted."""
    setting = fit.samples.setting
    moves = setting.joined(lambda piece: (~piece.model.resting).astype(float)) > 0.0
    measured = setting.drive_Nm
    told = measured
    for _ in range(_ROUNDS):
        told = np.where(moves, _asked(bench, fit, setting, told), measured)
    seen = bench.decimated(np.column_stack([measured, told]))
    return bench.error_of(seen[:, 0] - seen[:, 1], seen[:, 0], bench.fitted)


def _asked(bench: Bench, fit: Fitted, setting: Setting, drive_Nm: Reals) -> Reals:
    """What the fit asks of the drive, effects that look at it looking at `drive_Nm`, [rows]."""
    here = _with_drive(setting, drive_Nm)
    # what the model has already may read the drive as well
    total = here.joined(lambda piece: piece.model.load_Nm + piece.model.added_Nm)
    base = fit.coefficients[:4] + bench.taken_coefficients(setting)
    total = total + np.concatenate([piece.model.columns for piece in here.pieces]) @ base
    place = 4
    for pattern in fit.patterns:
        width = pattern.columns.shape[1]
        columns = rows_of(here if reads_drive(setting.actuator, pattern.effect) else setting, pattern)
        total = total + columns @ fit.coefficients[place : place + width]
        place += width
    return total


def _with_drive(setting: Setting, drive_Nm: Reals) -> Setting:
    """The setting with another drive in place of the recorded one."""
    constant = adjusted(setting.actuator)["motor.torque_constant_Nm_per_A"]
    ends = np.cumsum([piece.record.rows for piece in setting.pieces])[:-1]
    pieces = []
    for piece, drive in zip(setting.pieces, np.split(drive_Nm, ends), strict=True):
        motion = replace(piece.motion, current_A=drive / constant)
        model = mechanical_model(setting.actuator, piece.record, piece.model.smoother, motion)
        pieces.append(replace(piece, motion=motion, model=model, foretold=True))
    return Setting(setting.actuator, tuple(pieces), setting.carried)
