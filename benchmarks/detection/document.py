"""The document of what the ground test sees: computed shifts against readings, how the command moves them, and the rates of the verdicts against shift with their figure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from benchmarks.detection.trials import CONFIRMED, FAULTS, RUNS, WIDE, machine, scatter, sight, tested
from benchmarks.hidden.documents import table
from benchmarks.hidden.pictures import COLOURS, label, svg
from ema_tools.design.detection import Detection, Sight, detection
from ema_tools.fit.detection import ShiftTest

Row = Mapping[str, Any]
_VERDICTS = ("healthy", "fault", "undecided")
_KINDS = {"flight": "flight code, rod position alone", "unit": "desk, four signals beside healthy records"}
_DRAWS = 4_000
_SHOWN = 8


def written(rows: Sequence[Row], command: str, picture: str) -> str:
    """As Markdown; `command` writes it again, `picture` is the file of the figure beside it, empty for none."""
    return "\n".join(part for part in (_head(command), curves(rows, picture), _confirmed(rows), _commands()) if part)


def _head(command: str) -> str:
    return f"""# What the ground test sees

Written by a command; do not edit. To write it again, after `cmake --workflow --preset test`:

    {command}

A shift is found when what is read exceeds a threshold; a threshold is set so that a healthy machine seldom exceeds it. Both follow from how the readings of healthy runs scatter: sensor noise through
the sensitivities of the record, what differs from day to day, and, since few healthy runs show mean and scatter, Student's factor for one value and that of Hotelling's test for both together.
`ema next ACTUATOR --detect` computes it, `ema calibrate` sets the unit's thresholds by the same formula and writes the false alarms behind them.

All records here are of the truth plant, which shares no code with the module.
"""


def _of(rows: Sequence[Row], kind: str) -> list[Row]:
    return [row for row in rows if row["kind"] == kind]


def _rates(rows: Sequence[Row], fault: str) -> dict[float, dict[str, float]]:
    """Shares of the verdicts in % by shift; what has no fault belongs to both."""
    some = [row for row in rows if row["fault"] == fault or row["percent"] == 0.0]
    found = {}
    for percent in sorted({row["percent"] for row in some}):
        here = [row["verdict"] for row in some if row["percent"] == percent]
        found[percent] = {verdict: 100.0 * sum(one == verdict for one in here) / len(here) for verdict in _VERDICTS}
    return found


def _computed(rows: Sequence[Row], fault: str, what: str) -> float:
    """Mean over the units of what was computed for them."""
    return float(np.mean([row[what][fault] for row in _of(rows, "flight")]))


def curves(rows: Sequence[Row], picture: str) -> str:
    """Rates of the verdicts as tables; `picture` is the figure beside them, empty for none."""
    if not _of(rows, "flight"):
        return ""
    units = {kind: len({row["unit"] for row in _of(rows, kind)}) for kind in _KINDS}
    text = (
        f"{units['flight']} units with standing errors and sensors of their own, every second one with an effect in a form that the library does not have, usual scatter, three or five "
        f"healthy records; {units['unit']} of them at the desk, too. Each shift on a day of its own. "
        "The computation counts scatter and sensor noise; it does not count what a unit's model reads wrongly for its standing errors, nor that a model may not be adequate: a flight that is "
        "undecided far from the thresholds is one of these."
    )
    parts = [f"## The three verdicts against the size of a fault\n\n{text}\n"]
    if picture:
        parts.append(f"![Rates of the three verdicts against the shift of CSJ and of BLK]({picture})\n")
    for fault in FAULTS:
        threshold, computed, limit = (_computed(rows, fault, what) for what in ("threshold", "computed", "limit"))
        parts.append(
            f"{fault.upper()}: the units' threshold is {threshold:.3g} % in the mean; computed is that the flight code calls 95 % of the shifts from {computed:.3g} % on a fault; "
            f"with a threshold by the scatter alone, at 1 % false alarms, it would find them from {limit:.3g} % on.\n"
        )
        found = []
        rates = {kind: _rates(_of(rows, kind), fault) for kind in _KINDS}
        for percent in sorted({percent for one in rates.values() for percent in one}):
            cells = [f"{rates[kind][percent][verdict]:.0f}" if percent in rates[kind] else "" for kind in _KINDS for verdict in _VERDICTS]
            found.append((f"{percent:+g} %", *cells))
        heads = [f"{'flight' if kind == 'flight' else 'desk'}: {verdict}, %" for kind in _KINDS for verdict in _VERDICTS]
        parts.append(table((fault.upper(), *heads), found, len(heads)))
    return "\n".join(parts)


def figure(rows: Sequence[Row]) -> str:
    """Rates of the verdicts against shift: a panel for each fault and each who judges, thresholds as dashed lines. SVG text."""
    left, top, width, height, gap = 50.0, 46.0, 300.0, 150.0, 70.0
    colours = dict(zip(_VERDICTS, (COLOURS[2], COLOURS[1], COLOURS[4]), strict=True))
    kinds = [kind for kind in _KINDS if _of(rows, kind)]
    parts = [label(left, 18.0, "Verdicts against shift, % of the units", "start", ' font-weight="bold"')]
    for down, kind in enumerate(kinds):
        for across, fault in enumerate(FAULTS):
            x0, y0 = left + across * (width + gap), top + down * (height + gap)
            rates = _rates(_of(rows, kind), fault)
            most = max(rates)

            def at(percent: float, rate: float, x0: float = x0, y0: float = y0, most: float = most) -> tuple[float, float]:
                return x0 + width * percent / most, y0 + height * (1.0 - rate / 100.0)

            parts.append(label(x0, y0 - 8.0, f"{fault.upper()}: {_KINDS[kind]}", "start"))
            for rate in range(0, 101, 25):
                y = at(0.0, rate)[1]
                parts += [
                    f'<line x1="{x0:.1f}" x2="{x0 + width:.1f}" y1="{y:.1f}" y2="{y:.1f}" stroke="#dddddd"/>',
                    label(x0 - 6.0, y + 4.0, f"{rate}", "end"),
                ]
            step = next(one for one in (1.0, 2.0, 5.0, 10.0) if most / one <= 8.0)
            parts += [label(at(tick, 0.0)[0], y0 + height + 16.0, f"{tick:g} %") for tick in np.arange(0.0, most + 0.5 * step, step)]
            for what, dash in (("threshold", "2 3"), ("computed", "7 4")):
                x = at(min(_computed(rows, fault, what), most), 0.0)[0]
                parts.append(
                    f'<line x1="{x:.1f}" x2="{x:.1f}" y1="{y0:.1f}" y2="{y0 + height:.1f}" stroke="#333333" stroke-dasharray="{dash}"/>'
                )
            for verdict in _VERDICTS:
                points = [at(percent, one[verdict]) for percent, one in rates.items()]
                line = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
                parts.append(f'<polyline points="{line}" fill="none" stroke="{colours[verdict]}" stroke-width="2"/>')
                parts += [f'<circle cx="{x:.1f}" cy="{y:.1f}" r="2.5" fill="{colours[verdict]}"/>' for x, y in points]
    foot = top + len(kinds) * (height + gap) - gap + 44.0
    place = left
    for verdict in _VERDICTS:
        parts += [
            f'<line x1="{place}" x2="{place + 24.0}" y1="{foot - 4.0}" y2="{foot - 4.0}" stroke="{colours[verdict]}" stroke-width="2"/>',
            label(place + 30.0, foot, verdict, "start"),
        ]
        place += 110.0
    for text, dash in (("threshold of the units", "2 3"), ("computed: 95 % called a fault", "7 4")):
        parts += [
            f'<line x1="{place}" x2="{place + 24.0}" y1="{foot - 4.0}" y2="{foot - 4.0}" stroke="#333333" stroke-dasharray="{dash}"/>',
            label(place + 30.0, foot, text, "start"),
        ]
        place += 170.0
    return svg(left + 2.0 * width + gap + 30.0, foot + 14.0, parts)


def _confirmed(rows: Sequence[Row]) -> str:
    read = _of(rows, "reading")
    if not read:
        return ""
    found = []
    days = 0
    for searched, command in CONFIRMED:
        some = [row for row in read if (row["day_searched"], row["command"], row["times"]) == (searched, command, 1.0)]
        by = {worn: np.array([row["read"] for row in some if row["worn"] == worn]) for worn in ("", *FAULTS)}
        days = max(days, len(by[""]))
        for runs in RUNS:
            now, made = sight(searched, command, runs), sight(searched, command, RUNS[0])
            moves = {
                name: (now.onboard[name].alone - made.onboard[name].alone, now.onboard[name].together - made.onboard[name].alone)
                for name in FAULTS
            }
            rates, test = tested(by, scatter(searched, command), runs, moves, _DRAWS), ShiftTest(runs=runs)
            spread = " / ".join(
                f"{np.std(by[''][:, place], ddof=1):.2f} ({now.onboard[name].std:.2f})" for place, name in enumerate(FAULTS)
            )
            for place, (title, alarms, shifts) in enumerate(
                (
                    ("each alone", test.usual_false_alarms(), [now.onboard[name].alone for name in FAULTS]),
                    ("both together", test.usual_false_alarms_together(), [now.onboard[name].together for name in FAULTS]),
                )
            ):
                found.append(
                    (
                        _short(command),
                        "four values" if searched else "two values",
                        str(runs),
                        title,
                        spread if place == 0 else "",
                        f"{100.0 * rates[''][place]:.1f} ({100.0 * alarms:.1f})",
                        " / ".join(f"{shift:.1f}" for shift in shifts),
                        " / ".join(f"{100.0 * rates[name][place]:.0f}" for name in FAULTS),
                    )
                )
    heads = (
        "command",
        "searched",
        "healthy runs",
        "test",
        "scatter CSJ / BLK, % (computed)",
        "false alarms, % (computed)",
        "computed smallest shift CSJ / BLK, %",
        "found CSJ / BLK, %",
    )
    text = (
        "Readings of the onboard search (rod position, noise of 5 um rms) on the reference machine without standing errors: "
        f"{days} healthy days, and {days} days with each fault at the smallest shift that is computed for 3 healthy runs, for each command. "
        f"Friction, grease and winding scatter as usual (0.4, 1, 0.3 %). {_DRAWS} draws of so many healthy days as runs and one day more, each with its own thresholds. "
        "Stated are 1 % false alarms for a machine of which nothing is known before its runs, and 95 % found; a machine whose scatter is the usual one has fewer false alarms, computed in brackets."
    )
    return f"## Computed and simulated\n\n{text}\n\n{table(heads, found, 4)}\n{_wide(read)}"


def _wide(read: Sequence[Row]) -> str:
    """What becomes of the false alarms on a machine that scatters more than usual."""
    searched, command = CONFIRMED[0]
    healthy = np.array([row["read"] for row in read if row["times"] == WIDE])
    if not len(healthy):
        return ""
    found = []
    for runs in (*RUNS, 10):
        alone, together = tested({"": healthy}, scatter(searched, command), runs, {}, _DRAWS)[""]
        found.append((str(runs), f"{100.0 * alone:.1f}", f"{100.0 * together:.1f}"))
    return (
        f"A healthy machine whose friction, grease and winding scatter {WIDE:g} times as much as usual, which only its own runs tell ({len(healthy)} days, the first command). "
        "What is above 1 % here is the price of counting the usual scatter as two runs:\n\n"
        + table(("healthy runs", "false alarms, each alone, %", "both together, %"), found, 2)
    )


def _short(command: str) -> str:
    kind, _, numbers = command.partition(":")
    given = dict(part.split("=") for part in numbers.split(","))
    ends = "-".join(given[name] for name in ("start_hz", "end_hz") if name in given)
    return f"{kind} {given['amplitude_mm']} mm, {ends} Hz, {given['duration_s']} s"


def _commands() -> str:
    text = (
        "Smallest shift found at 1 % false alarms and 95 % power by three healthy runs, computed, on the reference actuator with a rod sensor of 5 um rms. *Today*: how far the onboard reading "
        "moves besides for what the machine may be today without anybody knowing (one standard deviation of winding, grease, magnets, supply, gain together). "
        "The best safe commands, those first that are no longer than the reference chirp; one that hangs more on today could not replace it."
    )
    parts = [f"## How the command moves it\n\n{text}\n"]
    for searched, title in (
        (True, "Grease and winding searched beside (a unit's own model)"),
        (False, "CSJ and BLK alone (the data sheet's model)"),
    ):
        found = detection(machine(searched), ShiftTest(runs=RUNS[0]))
        parts += [f"### {title}\n", _menu(found)]
    return "\n".join(parts)


def _menu(found: Detection) -> str:
    longer = [one for one in found.options if one.duration_s > found.present.duration_s]
    shown = [found.present, *[one for one in found.options if one not in longer][:_SHOWN], *longer[: _SHOWN // 2]]
    heads = (
        "command",
        "onboard CSJ, %",
        "BLK, %",
        "both: CSJ, %",
        "BLK, %",
        "all signals CSJ, %",
        "BLK, %",
        "today CSJ, %",
        "BLK, %",
        "could replace it",
    )
    return table(heads, [_cells(one, found) for one in shown], len(heads) - 1)


def _cells(one: Sight, found: Detection) -> tuple[str, ...]:
    numbers = [f"{limit.alone:.2f}" for limit in one.onboard.values()]
    numbers += [f"{limit.together:.2f}" for limit in one.onboard.values()]
    numbers += [f"{limit.alone:.2f}" for limit in one.signals.values()]
    numbers += [f"{limit.today:.1f}" for limit in one.onboard.values()]
    note = "now" if one is found.present else "the best" if one is found.best else "yes" if one.serves_for(found.present) else ""
    return (_short(one.command) if "amplitude_mm" in one.command else one.command, *numbers, note)
