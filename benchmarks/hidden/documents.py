"""The document of the hidden effects: tables in Markdown and two pictures beside it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from benchmarks.hidden import pictures, scoring
from benchmarks.hidden.catalogue import FAULTS, FORMS, INSEPARABLE, LIBRARY, OUTSIDE, SEVERITIES
from benchmarks.hidden.machines import COMMANDS, SCATTER, SETTINGS, UNITS
from benchmarks.hidden.scoring import Row, of_kind, share_of
from benchmarks.hidden.trials import FULL, TIMED
from ema_tools.base.files import read_text, write_text

_KINDS = {
    "library": "four signals, five healthy repeats",
    "position": "command and rod position alone, five healthy repeats",
    "alone": "four signals, no healthy repeats",
    "fault": "a shift of CSJ or BLK instead of an effect",
    "same": "records of the C model itself: the optimistic bound",
    "placebo": "placebo: differences dealt anew, so that no name is right",
}


@dataclass(frozen=True)
class Earlier:
    """What an earlier document says: what was reached, by goal, and which effects were hidden then."""

    reached: Mapping[str, str] = field(default_factory=dict)
    effects: frozenset[str] = frozenset()

    def knew(self, row: Row) -> bool:
        """Whether all that is hidden in a trial was an effect then; a healthy one, or one outside the library, is what it was."""
        return {effect for effect in row["effects"] if effect in LIBRARY} <= self.effects


def earlier_in(path: Path) -> Earlier:
    """What an earlier document says."""
    lines = read_text(path).splitlines()
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines if line.startswith("|")]
    return Earlier(
        {row[0]: row[3] for row in cells if len(row) >= 5 and row[2].strip("*") in ("yes", "no")},
        frozenset(row[0] for row in cells if len(row) == 1 + len(SEVERITIES) and any(" / " in cell for cell in row[1:])),
    )


def write(rows: Sequence[Row], path: Path, earlier: Earlier) -> list[Path]:
    """Writes the document and its pictures; returns their paths. What an `earlier` one says stands beside it, and what is reached on its effects alone."""
    curve = path.with_name(f"{path.stem.lower()}_detection.svg")
    matrix = path.with_name(f"{path.stem.lower()}_confusion.svg")
    write_text(curve, _curve(rows), force=True)
    write_text(matrix, pictures.matrix("first name put forward, four signals, all severities", _counts(rows)), force=True)
    sections = [
        _head(rows),
        _goals(rows, earlier),
        _rates(rows, curve.name),
        _by_effect(rows),
        _confusions(rows, matrix.name),
        _unasked(rows),
        _forms(rows),
        _settings(rows),
        _pairs(rows),
        _sizes(rows),
        _left(rows),
        _time(rows),
    ]
    write_text(path, "\n".join(section for section in sections if section), force=True)
    return [path, curve, matrix]


def table(headings: Sequence[str], rows: Sequence[Sequence[str]], numbers: int) -> str:
    """The last `numbers` columns hold numbers."""
    rule = ["---"] * (len(headings) - numbers) + ["---:"] * numbers
    return (
        "\n".join(
            "| " + " | ".join(cells) + " |" if cells is not rule else "|" + "|".join(cells) + "|" for cells in [headings, rule, *rows]
        )
        + "\n"
    )


def _head(rows: Sequence[Row]) -> str:
    whole = len(FULL.trials())
    machines = len({row["machine"] for row in rows})
    units = ", ".join(f"{names[0].split('.')[1]} {100.0 * std:g} %" for names, std in UNITS.items())
    scatter = ", ".join(f"{name.split('.')[1]} {100.0 * std:g} %" for name, std in SCATTER.items())
    return f"""# Naming a hidden effect

Written by a command; do not edit. Shown are {len(rows)} trials on {machines} machines, of the {whole} of the whole plan. To run all of it and write this again, after `cmake --workflow --preset test`:

    build/venv/bin/python -m benchmarks.hidden --full -o build/hidden --document docs/NAMING.md

The machines are simulated by the truth plant, which shares no equation's code with the module under test: Heun's method at 10 to 50 us, reversals found by bisection on even machines, LuGre
friction that yields 1 to 3 mrad before it slides on odd ones. Each differs from the data sheet by its number (standard deviations: {units}) and has what every machine has: a pitch ripple of 0.1 to
0.6 % of the friction, a friction asymmetry of 0.3 %, a rod sensor off by 0.02 % and 2 um, a current sensor off by 0.3 % and 20 mA, 0.5 um, 10 mA and 10 mV of resolution, 0.2 um of noise in the loop. From run to run
scatter {scatter}; noise is 2 um on both positions, 30 mA and 10 mV, at 1 kHz. Shapes (phases, periods, places, widths, masses, speeds) are drawn per machine and lie on no grid of the search.
The search gets the data sheet's actuator and the records, nothing else. Counted is the result that `ema diagnose --json` writes, refusals, suspected sensors and records held out among it; a shift of CSJ or BLK
counts where the result states it. Without repeats a name of what the unit has by itself, by its true size to a quarter, is not wrong: nobody told the search that it is usual there.

Medium is the lower end of an effect's typical size, large three times that, small a third, edge a tenth. Commands: {", ".join(COMMANDS)}; mostly the first.
The ideal observer knows every signature on that very machine in its hidden shape, the noise of every signal by frequency and the directions of the scatter, and picks the likeliest effect with its size left free; what it cannot name, no method can.
Classes: {"; ".join(" and ".join(sorted(kind)) for kind in INSEPARABLE)} are one. Another name counts as the class when the answer states the hidden effect as one that looks alike and less than {scoring.SEPARABLE:g} standard
deviations lie between the two for the ideal observer.
"""


def _goals(rows: Sequence[Row], earlier: Earlier) -> str:
    headings = ["goal", "limit", "met", "reached", "beside it, mostly the ideal observer"]
    cells = [[goal.text, goal.limit, "yes" if goal.met else "**no**", goal.reached, goal.beside or ""] for goal in scoring.goals(rows)]
    if earlier.reached:
        then = {goal.text: goal for goal in scoring.goals([row for row in rows if earlier.knew(row)])}
        headings[4:4] = ["earlier", "today on the effects known then"]
        for line in cells:
            known = then.get(line[0])
            line[4:4] = [
                earlier.reached.get(line[0], "-"),
                "-" if known is None else known.reached if known.met else f"**{known.reached}**",
            ]
    return "## Goals\n\n" + table(headings, cells, len(headings) - 3)


def _curve(rows: Sequence[Row]) -> str:
    def percents(some: Callable[[str], list[Row]], rate: Callable[[Sequence[Row]], scoring.Share]) -> list[float | None]:
        shares = [rate(some(severity)) for severity in SEVERITIES]
        return [share.percent if share.total else None for share in shares]

    lines = {
        "ideal observer": percents(lambda severity: of_kind(rows, "library", severity), scoring.observed),
        "right name or class first": percents(
            lambda severity: of_kind(rows, "library", severity), lambda some: share_of(some, scoring.first_right)
        ),
        "put forward for adding, and nothing else": percents(
            lambda severity: of_kind(rows, "library", severity), lambda some: share_of(some, scoring.exact_set)
        ),
        "records of the C model itself, right first": percents(
            lambda severity: of_kind(rows, "same", severity), lambda some: share_of(some, scoring.first_right)
        ),
    }
    return pictures.curves(
        "detection against severity, % of trials",
        tuple(SEVERITIES),
        {name: values for name, values in lines.items() if any(value is not None for value in values)},
    )


def _rates(rows: Sequence[Row], picture: str) -> str:
    cells = []
    for kind, title in _KINDS.items():
        for severity in SEVERITIES:
            some = of_kind(rows, kind, severity)
            if some:
                counted = [
                    share_of(some, scoring.first_right),
                    share_of(some, scoring.exact_set),
                    share_of(some, scoring.accused if kind == "placebo" else scoring.wrongly_accused),
                ]
                cells.append([title, severity, *map(str, counted), str(scoring.observed(some))])
    by_command = []
    for command in COMMANDS:
        some = [row for row in of_kind(rows, "library") if row["command"] == command]
        if some:
            by_command.append([command, str(share_of(some, scoring.first_right)), str(scoring.observed(some))])
    return (
        f"## How often the right name comes first\n\n![Detection against severity]({picture})\n\n"
        + table(
            ("set-up", "severity", "right name or class first", "put forward, alone", "a wrong one put forward", "ideal observer"), cells, 4
        )
        + "\nFour signals, all severities, by command:\n\n"
        + table(("command", "right name or class first", "ideal observer"), by_command, 2)
    )


def _by_effect(rows: Sequence[Row]) -> str:
    cells = []
    for name in (*LIBRARY, *FAULTS):
        own = [row for row in (*of_kind(rows, "library"), *of_kind(rows, "fault")) if row["effects"] == [name]]
        if not own:
            continue
        line = [name]
        for severity in SEVERITIES:
            some = [row for row in own if row["severity"] == severity]
            distance = np.median([row["observer"]["size"][0] for row in some]) if some else float("nan")
            line.append(f"{share_of(some, scoring.first_right).count} / {len(some)} ({distance:.0f})" if some else "-")
        cells.append(line)
    return (
        "## By effect\n\nRight name or class first, of so many; in brackets how many standard deviations lie between the effect and none (median).\n\n"
        + table(("hidden", *SEVERITIES), cells, len(SEVERITIES))
    )


def _counts(rows: Sequence[Row]) -> dict[str, dict[str, int]]:
    shown = [row for kind in ("library", "fault", "outside", "healthy") for row in of_kind(rows, kind)]
    counts = scoring.confusions(shown)
    order = [name for name in (*LIBRARY, *FAULTS, *OUTSIDE, "healthy") if name in counts]
    return {name: dict(counts[name]) for name in order}


def _confusions(rows: Sequence[Row], picture: str) -> str:
    cells = []
    for hidden, said in _counts(rows).items():
        others = ", ".join(
            f"{name} {count}"
            for name, count in sorted(said.items(), key=lambda item: -item[1])
            if name not in (hidden, "unknown", "nothing")
        )
        cells.append([hidden, others or "-", *(str(said.get(name, 0)) for name in (hidden, "unknown", "nothing"))])
    return (
        f"## Confusion matrix\n\n![Confusion matrix]({picture})\n\nFour signals and repeats, all severities: the first name that was put forward for adding; `unknown` and `nothing` are the other verdicts.\n\n"
        + table(("hidden", "another name", "its own name", "unknown", "nothing"), cells, 3)
    )


def _unasked(rows: Sequence[Row]) -> str:
    healthy = of_kind(rows, "healthy")
    text = "## What is not in the library, and healthy records\n\n"
    if healthy:
        accused = share_of(healthy, scoring.accused)
        text += f"Healthy records accused of an effect: {accused}; called unknown: {share_of(healthy, lambda row: row['verdict'] == 'unknown')}.\n\n"
    strangers = of_kind(rows, "stranger")
    if strangers:
        text += f"Healthy machines known by their data sheet alone, accused: {share_of(strangers, scoring.accused)}; called unknown: {share_of(strangers, lambda row: row['verdict'] == 'unknown')}.\n\n"
    cells = []
    for name in OUTSIDE:
        some = [row for row in of_kind(rows, "outside") if row["effects"] == [name]]
        if some:
            beyond = f"{100.0 * np.median([row['observer']['beyond'] for row in some]):.0f} %"
            nearest = some[0]["observer"]["nearest"]
            wrong = ", ".join(sorted({"+".join(row["accepted"]) for row in some if scoring.accused(row)})) or "-"
            cells.append([name, nearest, wrong, beyond, str(share_of(some, lambda row: row["verdict"] == "unknown"))])
    if cells:
        text += "Outside effects, medium and large; `left` is the share of what they do to the signals, beyond the noise, that the nearest effect of the library leaves at its best size.\n\n"
        text += table(("hidden", "nearest in the library", "put forward", "left", "unknown"), cells, 2)
    return text if healthy or strangers or cells else ""


def _forms(rows: Sequence[Row]) -> str:
    cells = []
    for name, form in FORMS.items():
        for severity in scoring.STRONG:
            some = [row for row in of_kind(rows, "form", severity) if row["effects"] == [name]]
            if some:
                cells.append([name, " or ".join(form.counts_as), severity, *_counted(some), _left_by_nearest(some)])
    if not cells:
        return ""
    return (
        "## Other forms than the library's\n\nThe same physics by another author's equation; `left` as above, by the nearest effect in the shape that it has on that machine elsewhere. "
        "The library has Gauss's form, with the exponent 2; LuGre's own rise towards rest may be named as stribeck_friction beside it.\n\n"
        + table(("hidden", "counts as", "severity", *_COUNTED, "left"), cells, len(_COUNTED) + 1)
    )


_COUNTED = ("right name or class first", "put forward, alone", "a wrong one put forward", "unknown", "ideal observer")


def _counted(some: Sequence[Row]) -> list[str]:
    """The cells of `_COUNTED`."""
    tests = (scoring.first_right, scoring.exact_set, scoring.wrongly_accused, lambda row: row["verdict"] == "unknown")
    return [*(str(share_of(some, test)) for test in tests), str(scoring.observed(some))]


def _left_by_nearest(some: Sequence[Row]) -> str:
    return f"{100.0 * np.median([row['observer']['beyond'] for row in some]):.0f} %"


def _settings(rows: Sequence[Row]) -> str:
    cells, healthy = [], []
    for name, some in scoring.set_rows(rows).items():
        setting, _, more = name.partition(",")
        text = SETTINGS[setting].text + (f",{more}" if more else "")
        cells += [
            [text, severity, *_counted(hidden)]
            for severity in scoring.STRONG
            if (hidden := [row for row in some if row["severity"] == severity])
        ]
        nothing = [row for row in some if not row["effects"]]
        if nothing:
            tests = (scoring.accused, lambda row: row["verdict"] == "unknown", lambda row: row["verdict"] == "refused")
            healthy.append([text, *(str(share_of(nothing, test)) for test in tests)])
    if not cells and not healthy:
        return ""
    return (
        "## Other machines and other records\n\nThe effects of the library on machines that differ from those above in one thing.\n\n"
        + table(("in what", "severity", *_COUNTED), cells, len(_COUNTED))
        + "\nNothing hidden:\n\n"
        + table(("in what", "accused", "unknown", "refused"), healthy, 3)
        + _of_units(rows)
    )


def _of_units(rows: Sequence[Row]) -> str:
    """What no one who knows one record alone can name."""
    hidden = [row for kind in scoring.UNLIKE for row in of_kind(rows, kind, *scoring.STRONG) if row["effects"] and not row["repeats"]]
    within = [row for row in hidden if scoring.of_units(row)]
    if not within:
        return ""
    return (
        f"\nWithout healthy runs {len(within)} of the {len(hidden)} hidden changes do what a value of the machine does (a weaker magnet, a larger inertia) and go no farther than {scoring.OF_UNITS:g} standard"
        " deviations of what units differ by themselves, as they are drawn or as is assumed, whichever is more. Whoever is not told how wide units are cannot accept these without accusing more than one of 200"
        f" healthy units; of these the right one is accepted in {share_of(within, scoring.all_named)}, of the others in {share_of([row for row in hidden if not scoring.of_units(row)], scoring.all_named)}."
        " Healthy runs of the unit tell it, as the rows with them show. The ideal observer beside them knows how wide the units of each setting are.\n"
    )


def _pairs(rows: Sequence[Row]) -> str:
    cells = []
    for severity in SEVERITIES:
        some = of_kind(rows, "pair", severity)
        if some:
            cells.append(
                [
                    severity,
                    str(share_of(some, scoring.all_named)),
                    str(share_of(some, scoring.exact_set)),
                    str(share_of(some, scoring.wrongly_accused)),
                ]
            )
    return "## Two effects at once\n\n" + table(("severity", "both named", "the exact set", "a wrong one too"), cells, 3) if cells else ""


def _sizes(rows: Sequence[Row]) -> str:
    cells = []
    for severity in SEVERITIES:
        stated = scoring.sizes(of_kind(rows, "library", severity))
        if stated:
            errors = [scoring.size_error_percent(size) for size in stated]
            held = scoring.Share(sum(size["held"] for size in stated), len(stated))
            cells.append([severity, f"{np.median(errors):.2g}", f"{np.percentile(errors, 95.0):.2g}", str(held)])
    return (
        "## Sizes\n\nOf effects that were put forward under their own name.\n\n"
        + table(("severity", "median error, % of the size", "95th percentile", "95 % interval holds the truth"), cells, 3)
        if cells
        else ""
    )


def _left(rows: Sequence[Row]) -> str:
    cells = []
    for severity in scoring.STRONG:
        some = [row for row in of_kind(rows, "library", severity) if scoring.exact_set(row)]
        held = [row["held_out"] for row in some if row.get("held_out")]
        if some:
            before = [row["error"]["before"] / row["error"]["floor"] for row in some]
            after = [scoring.training_ratio(row) for row in some]
            line = [severity, f"{np.median(before):.2f}", f"{np.median(after):.3f}", f"{max(after):.3f}"]
            line += (
                [f"{np.median([one[place] for one in held]):.3f}" for place in ("before", "after")]
                + [f"{max(one['after'] for one in held):.3f}"]
                if held
                else ["-"] * 3
            )
            cells.append(line)
    text = "## Error left after adding\n\nWeighted rms over that of the healthy repeats, of what was put forward rightly; held out: the same machine under another command, nothing fitted to it.\n\n"
    return (
        text + table(("severity", "before", "after", "worst after", "held out before", "after", "worst after"), cells, 6) if cells else ""
    )


def _time(rows: Sequence[Row]) -> str:
    shared = [row["cpu_s"] for row in rows if row["kind"] not in TIMED]
    text = "## Time\n\n"
    for kind, (way, _) in scoring.TIME_LIMITS.items():
        seconds = ", ".join(f"{row['run_s']:.1f}" for row in of_kind(rows, kind))
        text += f"A diagnosis of a 10 s record {way} on all cores, from records to answer: {seconds} s. " if seconds else ""
    return (
        text
        + f"In the trials, with the fit to the healthy repeats made once a machine: {np.median(shared):.1f} s of one core (median), {max(shared):.0f} s at most.\n"
        if shared
        else ""
    )
