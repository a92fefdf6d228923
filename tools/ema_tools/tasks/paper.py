"""Simulates what the paper's figures show: the command and the responses, what CSJ and BLK each do to them, and the objective over the whole box of the search."""

from __future__ import annotations

import numpy as np

from ema_tools.base.parallel import each
from ema_tools.data.actuator import Actuator
from ema_tools.data.cases import CASES
from ema_tools.data.commands import make_command
from ema_tools.data.records import Record
from ema_tools.plant.native import library
from ema_tools.results.paper import PaperResponses, PaperRun, WholeBox
from ema_tools.tasks.onboard_search import BOUNDS, POSITION_ALONE

COMMAND = "chirp"  # with its usual numbers: a linear sweep, unloaded, as the paper has it
CSJ_SHIFTS_PERCENT = (25.0, 50.0, 117.4)  # of CSJ alone; the last is that of case A [layout]
BLK_SHIFTS_PERCENT = (25.0, 100.0, 200.0)  # of BLK alone; the second is that of case B [layout]
_COLUMNS, _ROWS = 33, 23  # points of the objective over CSJ and BLK [layout]
_BITS = 64  # of the module: what is drawn is as exact as it can be [precision]


def paper_responses(actuator: Actuator) -> PaperResponses:
    """The runs on the reference actuator, or one like it: `actuator` healthy."""
    command = make_command(COMMAND, actuator)
    healthy_csj, healthy_blk = actuator["screw.csj_Nm"], actuator["screw.blk_mm"]

    def run(name: str, csj_Nm: float = healthy_csj, blk_mm: float = healthy_blk) -> PaperRun:
        machine = actuator.changed({"screw.csj_Nm": csj_Nm, "screw.blk_mm": blk_mm})
        made = library(_BITS).simulate(*machine.arrays(), command.samples_mm, command.start_mm)
        return PaperRun(name, csj_Nm, blk_mm, made.position_mm, made.speed_mm_s, made.current_A)

    cases = tuple(run(f"case {case.letter}", case.csj_Nm, case.blk_mm) for case in CASES)
    period_s = actuator.record_period_s
    measured = Record(period_s, command.samples_mm, position_mm=cases[0].position_mm)
    return PaperResponses(
        period_s,
        command.samples_mm,
        run("healthy"),
        cases,
        tuple(run(f"CSJ +{shift:g} %", csj_Nm=healthy_csj * (1.0 + 0.01 * shift)) for shift in CSJ_SHIFTS_PERCENT),
        tuple(run(f"BLK +{shift:g} %", blk_mm=healthy_blk * (1.0 + 0.01 * shift)) for shift in BLK_SHIFTS_PERCENT),
        _box(actuator, measured, CASES[0].letter, command.start_mm),
    )


def _box(actuator: Actuator, measured: Record, case: str, start_mm: float) -> WholeBox:
    """Denser in CSJ where it is small: the box is ten times the healthy value wide."""
    ends = [[actuator[name] for name in BOUNDS[value]] for value in ("screw.csj_Nm", "screw.blk_mm")]
    csj = ends[0][0] + (ends[0][1] - ends[0][0]) * np.linspace(0.0, 1.0, _COLUMNS) ** 1.5
    blk = np.linspace(ends[1][0], ends[1][1], _ROWS)
    table = measured.table()

    def objective(point: tuple[float, float]) -> float:
        machine = actuator.changed({"screw.csj_Nm": point[0], "screw.blk_mm": point[1]})
        return library(_BITS).objective(*machine.arrays(), measured.command_mm, table, POSITION_ALONE, start_mm)

    found = each(objective, [(float(one), float(other)) for other in blk for one in csj])
    return WholeBox(case, csj, blk, np.array(found).reshape(blk.size, csj.size))
