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


# What `ema identify` may say.
JUDGED = ("identified as faulty", "identified as healthy", "identified beside a missing effect", "identified beside a rival")


def judged(kind: str) -> dict[str, Any]:
    """A result of `ema identify` of one of JUDGED, with thresholds, intervals, every signal and what was held against it."""
    plain = identified()
    curves = plain["curves"]
    for table in (curves["measured"], curves["before"], curves["after"]):
        table["motor_position_mm"] = [1.01 * value for value in table["position_mm"]]
        table["voltage_V"] = [5.0 * value for value in table["position_mm"]]
    sizes = {"identified as healthy": (0.1395, 0.0334), "identified beside a missing effect": (0.205, 0.0816)}.get(kind, (0.3, 0.0412))
    values = {}
    for name, size, healthy, half, limit in zip(("csj_Nm", "blk_mm"), sizes, (0.138, 0.033), (0.0026, 0.0024), (5.0, 10.0), strict=True):
        wide = half if kind != "identified beside a missing effect" else 25.0 * half
        values[name] = {
            "estimate": size, "std": 0.1 * half, "shift_percent": 100.0 * (size / healthy - 1.0), "healthy": healthy,
            "interval95": [size - wide, size + wide], "threshold_percent": limit, "at_bound": False, "bias": 0.0,
        }  # fmt: skip
    signals = ["position_mm", "motor_position_mm", "current_A", "voltage_V"]
    shift = {name: one["shift_percent"] for name, one in values.items()}
    guard: dict[str, Any] = {
        "verdict": "adequate", "objection": None, "signals": signals, "shift_percent": shift, "open_std_percent": {"csj_Nm": 0.03, "blk_mm": 0.4},
        "skipped": "every residual is as small as its sensor's noise", "wall_s": 1.0,
    }  # fmt: skip
    found: dict[str, Any] = {"verdict": "healthy" if kind == "identified as healthy" else "fault", "adequate": True, "guard": guard}
    if kind in JUDGED[2:]:
        rival = kind == JUDGED[3]
        reason = (
            "Stribeck friction (stribeck_friction; rise 0.30) explains the record as well as a fault: record current too, "
            "or ema next ACTUATOR --between csj stribeck_friction finds a command that tells them apart"
            if rival
            else "Stribeck friction (stribeck_friction; rise 0.30) is missing from the model, beside which all signals say CSJ +39.7 %, BLK +100.3 %: "
            "ema add mine.toml stribeck_friction --fit today.csv --known -o NEW.toml puts it in"
        )
        found = {
            "verdict": "undecided", "adequate": rival, "reasons": [reason],
            "guard": {**guard, "verdict": "rival" if rival else "missing", "objection": "rival" if rival else "missing", "shift_percent": {"csj_Nm": 39.7, "blk_mm": 100.3}, "skipped": None},
            "missing_effect": {
                "name": "stribeck_friction", "class": ["stribeck_friction"], "parameters": {"rise": 0.3}, "std": {"rise": 0.005},
                "beside_it": {"screw.csj_Nm": 0.1928, "screw.blk_mm": 0.0661}, "against_healthy_records": 0,
            },
        }  # fmt: skip
    return {
        **plain, **values, **found, "name": "today.csv", "residual_rms_mm": 0.0023, "residual_correlation": -0.002, "outcome": "tolerance",
        "provenance": {"command": "ema identify mine.toml today.csv --healthy 'runs/healthy *.csv' --json i.json", "record": "today.csv"},
    }  # fmt: skip


def compared_whole() -> dict[str, Any]:
    """A result of `ema compare` with every signal and every equation, as the command writes it."""
    curves = judged(JUDGED[0])["curves"]
    told = {"unit": "", "noise_rms": 0.003, "method_rms": 0.004, "resting_percent": 2.0}
    return compared(
        name="today.csv",
        curves={"start_s": 0.0, "period_s": 1e-3, "measured": curves["measured"], "model": curves["before"]},
        channels={name: {"rmse": 0.1, "relative_percent": 5.0} for name in ("position_mm", "motor_position_mm", "current_A", "voltage_V")},
        balances={
            "mechanical": {**told, "unit": "Nm", "rms": 0.05, "relative_percent": 27.7, "excess_percent": 27.5},
            "electrical": {**told, "unit": "V", "rms": 0.006, "relative_percent": 0.9, "excess_percent": 0.0},
            "kinematic": {"rms": None, "relative_percent": None, "unit": "mm", "reason": "motor_position_mm is not recorded"},
        },
        where=[
            {"name": "electrical balance: time 8 to 10 s", "share_percent": 42.0, "time_share": 0.2, "source": "electrical balance", "by": "time", "part": "8 to 10 s"},
            {"name": "mechanical balance: current 3.45 to 5.17 A", "share_percent": 32.0, "time_share": 0.24, "source": "mechanical balance", "by": "current", "part": "3.45 to 5.17 A"},
        ],
        provenance={"command": "ema compare 'my unit.toml' runs/today.csv --json c.json"},
    )  # fmt: skip


def mapped(**changes: Any) -> dict[str, Any]:
    """A result of `ema map` of four speeds, two of them in both directions; `changes` replace keys."""
    points = [
        {"speed_rad_s": speed, "torque_Nm": torque, "low_Nm": torque - 0.01, "high_Nm": torque + 0.01, "interval95": [torque - 0.002, torque + 0.002],
         "model_Nm": model, "runs": 3, "seconds": 1.5, "records": ["slow.csv", "fast.csv"]}
        for speed, torque, model in ((-40.0, -0.15, -0.1495), (-10.0, -0.17, -0.14), (10.0, 0.18, 0.15), (40.0, 0.16, 0.1595))
    ]  # fmt: skip
    return {
        "command": "map",
        "name": "slow.csv",
        "actuator": "my unit",
        "records": ["slow.csv", "fast.csv", "rest.csv"],
        "sentence": "12 runs at constant speed in 2 records.",
        "runs": 12,
        "points": points,
        "both_ways": [
            {"speed_rad_s": 10.0, "friction_Nm": 0.175, "load_Nm": 0.005},
            {"speed_rad_s": 40.0, "friction_Nm": 0.155, "load_Nm": 0.005},
        ],
        "left_out": {"rest.csv": "no speed is kept"},
        "provenance": {"command": "ema map 'my unit.toml' runs --json m.json"},
        **changes,
    }


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
