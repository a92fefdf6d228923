"""`python -m benchmarks.flights -o docs`: sixty flights of a unit from healthy to the paper's case A, what is said on the way, and the same by firmware.

The unit's friction rises to the paper's case A, the faster the farther it is gone, and its play evenly, from the eleventh flight on; a few flights are missing. The limit of CSJ is set to +150 %,
which the same wear reaches some flights later. Every ground test is a recording of the reference actuator under the reference chirp with sensor noise, judged as `ema fleet` does.
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Mapping
from datetime import date, timedelta
from pathlib import Path

import click
import numpy as np

from ema_tools.base.files import write_text
from ema_tools.data.actuator import Actuator, reference_actuator
from ema_tools.data.cases import CASES
from ema_tools.data.commands import make_command
from ema_tools.data.manifest import read_manifest
from ema_tools.data.records import write_record
from ema_tools.fit.wear import outlook
from ema_tools.plant.trend import onboard_outlooks
from ema_tools.results.provenance import provenance
from ema_tools.results.store import read_rows
from ema_tools.tasks.fleet import RESULTS, judge, planned
from ema_tools.tasks.history import FALSE_ALARM, LIMITS, Trend, UnitHistory, histories
from ema_tools.tasks.simulate import simulate_record
from ema_tools.words.answers.fleet import fleet_result
from ema_tools.words.page.trend import drawing
from ema_tools.words.terminal.console import run_command

_NOISE = {"position_mm": 0.002, "motor_position_mm": 0.002, "current_A": 0.03, "voltage_V": 0.01}
_HEALTHY = 3  # healthy runs of a unit
_FLIGHTS = 60
_SOUND = 10  # flights before wear begins
_EVERY_DAYS = 2
_MISSING = 0.15  # of the flights
_SCATTER = 0.004  # of the friction, from flight to flight
_POWER = 1.5  # of the time since wear began, with which friction rises
_CASE_A = {name: CASES[0].shift_percent(f"{name}_{unit}") for name, unit in (("csj", "Nm"), ("blk", "mm"))}
_LIMITS = {**LIMITS, "csj": 150.0}
_LOOKS = (20, 30, 40, 50)  # readings after which it is told what is said, and after the last
_STYLE = (
    "<style>svg{font:11px sans-serif;background:#fff}text{fill:#555}.grid{stroke:#e4e7ea}polyline,path{fill:none;stroke:#0a6aa8;stroke-width:1.4}"
    ".dots{stroke-linecap:round;stroke-width:4}.noise{stroke:#8a6d00;stroke-dasharray:5 4}.back{stroke:#888;stroke-dasharray:4 4}"
    ".band{stroke:none;fill:#c8501e;opacity:.18}.band.after{fill:#0a6aa8}</style>"
)


def simulate(path: Path, machine: Actuator, csj_percent: float, blk_percent: float, seed: int) -> None:
    """One record with its friction and play risen so far."""
    random = np.random.default_rng(seed)
    worn = machine.changed(
        {
            "screw.csj_Nm": machine["screw.csj_Nm"] * (1.0 + csj_percent / 100.0) * (1.0 + _SCATTER * random.normal()),
            "screw.blk_mm": machine["screw.blk_mm"] * (1.0 + blk_percent / 100.0),
        }
    )
    write_record(path, simulate_record(worn, make_command("chirp", machine), 64, _NOISE, seed), (), True, 9)


def flights(folder: Path) -> UnitHistory:
    """The unit, judged as a fleet of one."""
    machine = reference_actuator()
    own = folder / "flights" / "case_a"
    own.mkdir(parents=True)
    machine.write(folder / "flights" / "reference.toml")
    random = np.random.default_rng(1)
    for flight in range(_FLIGHTS):
        if flight >= _HEALTHY and random.random() < _MISSING:
            continue
        gone = max(0, flight - _SOUND) / (_FLIGHTS - 1 - _SOUND)
        healthy = "_healthy" if flight < _HEALTHY else ""
        day = date(2026, 1, 1) + timedelta(days=_EVERY_DAYS * flight)
        simulate(own / f"{day}{healthy}.csv", machine, _CASE_A["csj"] * gone**_POWER, _CASE_A["blk"] * gone, flight)
    for batch in planned(read_manifest(folder / "flights"), folder / "judged", guarded=False)[0]:
        judge(batch)
    (unit,) = histories(read_rows(folder / "judged" / RESULTS), _LIMITS)
    return unit


def reached(name: str) -> float:
    """Day after the first flight on which the wear reaches its limit."""
    power = _POWER if name == "csj" else 1.0
    gone = (_LIMITS[name] / _CASE_A[name]) ** (1.0 / power)
    return float(_EVERY_DAYS * (_SOUND + gone * (_FLIGHTS - 1 - _SOUND)))


def _days(value: float) -> str:
    return f"{value:.0f}" if math.isfinite(value) else "no end"


def said(trend: Trend) -> list[str]:
    """Rows of what is said after some readings, at the desk and onboard."""
    looks = (*(one for one in _LOOKS if one < trend.days.size), trend.days.size)
    false_alarm = FALSE_ALARM / len(LIMITS)
    days, shift, std = trend.days, trend.shift_percent, trend.std_percent
    onboard = onboard_outlooks(days, shift, std, trend.limit_percent, looks, false_alarm)
    rows = []
    for count, aboard in zip(looks, onboard, strict=True):
        desk = outlook(days[:count], shift[:count], std[:count], trend.limit_percent, false_alarm)
        head = f"| {count} | {trend.days[count - 1]:.0f} |"
        if desk is None or not desk.drift.changed:
            rows.append(
                f"{head} no drift | | | {'a drift' if aboard.drifts else 'no drift'} | {reached(trend.name) - trend.days[count - 1]:.0f} |"
            )
            continue
        life = desk.life
        rows.append(
            f"{head} {desk.rate:+.2f} ± {desk.rate_std:.2f} | {_days(life.median)} | {_days(life.low)} … {_days(life.high)} | "
            f"{_days(aboard.median_days)} ({_days(aboard.low_days)} … {_days(aboard.high_days)}) | {reached(trend.name) - trend.days[count - 1]:.0f} |"
        )
    return rows


def document(unit: UnitHistory, sentences: Mapping[str, str]) -> str:
    """What docs/FLIGHTS.md says."""
    titles = {"csj": "CSJ", "blk": "BLK"}
    lines = [
        "# Sixty flights to case A",
        "",
        "Written by a command; do not edit. To write it again, after `cmake --workflow --preset test`:",
        "",
        "    python -m benchmarks.flights -o docs",
        "",
        " ".join((__doc__ or "").partition("\n\n")[2].split()),
    ]
    for trend in unit.trends:
        lines += [
            "",
            f"## {titles[trend.name]}",
            "",
            sentences[trend.name],
            "",
            f"![{titles[trend.name]} over days, with the interval of the time until its limit](flights_{trend.name}.svg)",
            "",
            f"What was said on the way, times in days from then on, until the limit of +{trend.limit_percent:g} %; `onboard` is the module's float32, as firmware keeps it in under 1 KiB:",
            "",
            "| readings | day | trend, % a day | median | 90 % interval | onboard | in truth |",
            "|---:|---:|---:|---:|---:|---:|---:|",
            *said(trend),
        ]
    return "\n".join([*lines, ""])


@click.command()
@click.option("-o", "--output", "out", type=click.Path(path_type=Path), required=True, help="Folder of the document and its pictures.")
def main(out: Path) -> None:
    """Judge sixty flights of a unit that wears, and write what is said of them."""
    with tempfile.TemporaryDirectory() as place:
        unit = flights(Path(place))
    told = fleet_result([unit], _LIMITS, FALSE_ALARM, len(unit.rows), 0.0, provenance("ema fleet")).units[0]
    write_text(out / "FLIGHTS.md", document(unit, {name: trend.sentence for name, trend in told.trends.items()}), True)
    for name, trend in told.trends.items():
        svg = drawing(name, trend).replace("<svg ", '<svg xmlns="http://www.w3.org/2000/svg" ', 1)
        write_text(out / f"flights_{name}.svg", svg.replace(">", f">{_STYLE}", 1) + "\n", True)


if __name__ == "__main__":
    run_command(main)
