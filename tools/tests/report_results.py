"""Small made-up results for the tests of the page."""

from __future__ import annotations

from typing import Any

import numpy as np

ROWS = 1200


def identified(**changes: Any) -> dict[str, Any]:
    """A result of `ema identify` with every part that the page shows; `changes` replace keys."""
    time = np.arange(ROWS) * 1e-3
    measured = 2.0 * np.sin(2.0 * np.pi * 3.0 * time)
    result = {
        "command": "identify",
        "csj_Nm": {"estimate": 0.3, "std": 1e-4, "shift_percent": 117.3913},
        "blk_mm": {"estimate": 0.04125, "std": 2.6e-4, "shift_percent": 25.0},
        "objective_before_mm2s": 0.674,
        "objective_after_mm2s": 2.5e-4,
        "evaluations": 7,
        "verdict": "fault",
        "adequate": True,
        "reasons": [],
        "wall_s": 0.07,
        "search": {"cost_mm2s": [0.674, 1.2, 0.1, 0.3, 0.01, 2.5e-4, 2.6e-4]},
        "curves": {
            "start_s": 0.0,
            "period_s": 1e-3,
            "measured": {"position_mm": measured.tolist(), "current_A": (3.0 * measured).tolist()},
            "before": {"position_mm": (0.9 * measured).tolist(), "current_A": (2.0 * measured).tolist()},
            "after": {"position_mm": (measured + 1e-3).tolist(), "current_A": (3.0 * measured + 1e-2).tolist()},
        },
        "provenance": {"command": "ema identify reference.toml today.csv", "seed": "1"},
    }
    return {**result, **changes}


def compared(**changes: Any) -> dict[str, Any]:
    """A result of `ema compare`; `changes` replace keys."""
    curves = identified()["curves"]
    result = {
        "command": "compare",
        "channels": {"position_mm": {"rmse": 0.1, "relative_percent": 5.0}, "current_A": {"rmse": 0.0, "relative_percent": None}},
        "balances": {
            "mechanical": {"rms": 0.01, "relative_percent": 4.08, "reason": None},
            "electrical": {"rms": None, "relative_percent": None, "reason": "voltage_V is not recorded"},
        },
        "where": [
            {"name": "rod position: speed 0 to 5 mm/s", "share_percent": 60.0, "time_share": 0.2},
            {"name": "rod position: direction extending", "share_percent": 40.0, "time_share": 0.5},
            {"name": "balances mechanical", "share_percent": 100.0, "time_share": None},
        ],
        "sentence": "Most of the error is in the mechanical balance.",
        "curves": {"start_s": 0.0, "period_s": 1e-3, "measured": curves["measured"], "model": curves["before"]},
    }
    return {**result, **changes}
