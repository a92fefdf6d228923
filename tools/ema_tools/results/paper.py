"""What the page of the paper's cases draws besides their results: responses of the healthy and the faulty actuator, and the objective over the whole box of the search."""

from __future__ import annotations

from dataclasses import dataclass

from ema_tools.base.arrays import Reals


@dataclass(frozen=True)
class PaperRun:
    """The reference actuator under the paper's command with one CSJ and BLK; arrays [rows]."""

    name: str  # in words
    csj_Nm: float
    blk_mm: float
    position_mm: Reals
    speed_mm_s: Reals
    current_A: Reals


@dataclass(frozen=True)
class WholeBox:
    """The objective of a case over the whole box of its search: `csj_Nm` [m], `blk_mm` [n], `objective_mm2s` [n, m]."""

    case: str
    csj_Nm: Reals
    blk_mm: Reals
    objective_mm2s: Reals


@dataclass(frozen=True)
class PaperResponses:
    """All runs under one command [rows]: the healthy one, the cases by letter, and CSJ alone and BLK alone in rising sizes."""

    period_s: float
    command_mm: Reals
    healthy: PaperRun
    cases: tuple[PaperRun, ...]
    csj: tuple[PaperRun, ...]
    blk: tuple[PaperRun, ...]
    box: WholeBox
