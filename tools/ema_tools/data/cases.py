"""The three demonstration cases of Dalla Vedova, Lauria, Maggiore and Pace, and what their paper prints for them.

Source: M. D. L. Dalla Vedova, D. Lauria, P. Maggiore, L. Pace, "Electromechanical actuators affected by multiple failures: a
simulated-annealing-based fault identification algorithm". Its Table 3 repeats 2.21 % where Table 5 has 0.83 %, and a reduction of 0.655 by
99.936 % is not the 9.39e-5 printed; only the numbers used here are free of such doubts.
"""

from __future__ import annotations

from dataclasses import dataclass

HEALTHY_CSJ_NM = 0.138
HEALTHY_BLK_MM = 0.033


@dataclass(frozen=True)
class PaperCase:
    """One case: what was put in, and what the paper found. CSJ in Nm at the motor shaft, BLK in mm at the rod."""

    letter: str
    title: str
    csj_Nm: float
    blk_mm: float
    paper_csj_Nm: float
    paper_blk_mm: float
    paper_reduction_percent: float
    paper_iterations: int
    paper_wall_s: float

    def shift_percent(self, name: str) -> float:
        """True shift of `csj_Nm` or `blk_mm`, % of the healthy value."""
        return _shift_percent(name, getattr(self, name))

    def paper_shift_percent(self, name: str) -> float:
        """Shift that the paper found, % of the healthy value."""
        return _shift_percent(name, getattr(self, f"paper_{name}"))


def _shift_percent(name: str, value: float) -> float:
    healthy = {"csj_Nm": HEALTHY_CSJ_NM, "blk_mm": HEALTHY_BLK_MM}[name]
    return 100.0 * (value - healthy) / healthy


CASES = (
    PaperCase("A", "moderate seizure, low backlash", 0.3, 0.04125, 0.297, 0.0403, -99.94, 2535, 75.0),
    PaperCase("B", "low seizure, high backlash", 0.1449, 0.066, 0.14771, 0.06545, -96.5, 1651, 45.0),
    PaperCase("C", "one percent of each", 0.13938, 0.03333, 0.13896, 0.03608, -92.6, 1500, 40.0),
)
