"""What `ema next --detect` says: what the ground test sees, and whether another sees more."""

from __future__ import annotations

from collections.abc import Mapping

from ema_tools.design.detection import Detection, Sight
from ema_tools.fit.detection import rate_text

ONE_WAY = "pushes the rod one way alone, which shows no play"


def sentence(found: Detection) -> str:
    """What the present test finds, what its verdict makes of it, and the better test."""
    test, present = found.test, found.present
    by = f"by {test.runs} healthy runs" if test.runs is not None else "with the scatter known"
    together = _shifts({name: one.together for name, one in present.onboard.items()})
    return (
        f"At {100.0 * test.false_alarm:g} % false alarms the onboard test finds {100.0 * test.power:g} % of the shifts from {_shifts(_alone(present))} on, {by}; "
        f"one test of both together finds {together}. By the actuator's own thresholds its verdict is a fault from {_shifts(present.verdict)} on, "
        f"and a false one in {rate_text(present.false_alarms)} of ground tests; "
        f"all signals together could find {_shifts({name: one.alone for name, one in present.signals.items()})}. {_better(found)}"
    )


def _alone(one: Sight) -> dict[str, float]:
    return {name: limit.alone for name, limit in one.onboard.items()}


def _shifts(percent: Mapping[str, float]) -> str:
    return " and ".join(f"{name.upper()} +{value:.2g} %" for name, value in percent.items())


def _better(found: Detection) -> str:
    best, longer = found.best, found.best_of_any_length
    said = []
    if best is not None:
        said.append(f"Better: --command {best.command}, {_gain(best, found.present)}.")
    else:
        said.append("No safe command of the same length is better.")
    if longer is not None and longer != best:
        said.append(f"Better still in {longer.duration_s:g} s, --command {longer.command}, {_gain(longer, found.present)}.")
    return " ".join(said)


def _gain(one: Sight, present: Sight) -> str:
    gains = []
    for name, limit in one.onboard.items():
        times = present.onboard[name].alone / limit.alone
        change = f"{times:.2g} times smaller" if times >= 1.0 else f"{1.0 / times:.2g} times larger"
        gains.append(f"{name.upper()} +{limit.alone:.2g} % ({change})")
    return "which finds " + " and ".join(gains)
