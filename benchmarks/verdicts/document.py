"""The document of the verdicts: goals, rates by what was given, and every answer that was surely wrong."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from benchmarks.hidden.documents import table
from benchmarks.verdicts.bounds import allowed_rms, half_widths
from benchmarks.verdicts.trials import units

Row = Mapping[str, Any]
_VERDICTS = ("healthy", "fault", "undecided", "refused")
_TITLES = {"csj": "CSJ", "blk": "BLK"}
_SAMPLED = 6  # units of which the narrowest intervals are worked out: they differ by a tenth [precision]
_WIDER = 1.5  # times what is possible
_SIZE = "size of "  # a wrong answer that is right but for a size begins so
_CHANCE = 0.33  # %, of a normal distribution beyond one and a half 95 % intervals [chance]


def written(rows: Sequence[Row], command: str) -> str:
    """As Markdown; `command` writes it again."""
    parts = [
        _head(command),
        _goals(rows),
        _units(rows, "unit", "At the desk, beside healthy records: a 10 s chirp to 4 Hz, four signals"),
        _units(rows, "flight", "The flight code with the unit's own model: the same records, the rod position alone"),
        _drawn(rows),
        _wrong(rows),
    ]
    return "\n".join(part for part in parts if part)


def _head(command: str) -> str:
    return f"""# How often the verdict is right

Written by a command; do not edit. To write it again, after `cmake --workflow --preset test`:

    {command}

Units are of the truth plant, which shares no code with the module; what is drawn at random is by turns of it and of machines of another build: motor and rod as two masses, the play a gap in
the spring between them, friction a state of its own with a Stribeck bump, a winding that warms, a supply that gives way. At the desk `ema identify` gets what a user has: the data sheet's
actuator file, today's record and the unit's healthy records. The flight code gets the rod position and the model that `ema calibrate` made of the healthy records, thresholds included; nothing
else looks at its verdict.

Units differ from the data sheet as units do, each has standing errors and sensors of its own, odd ones have contacts that yield (LuGre), and every second one has an effect in a form
that the library does not have (Stribeck after Gauss, a smooth dead time, a winding that warms during the record). Days scatter: friction by 0.4 %, grease by 1 %, winding by 0.3 %; in the
setting "scatter" by four times that and by +-8 degC. A worn day has CSJ +20 %, BLK +50 %, or CSJ +40 % and BLK +100 %.

An answer is surely wrong that calls a unit healthy with CSJ +10 % or BLK +20 % and beyond, calls a unit faulty with neither above its threshold (5 and 10 %), or states for a fault a size that is
far off (5 % of CSJ, 15 % of BLK) and farther than one and a half times what its 95 % interval reaches to that side. Undecided, with its reason, is honest but of no use: its share is stated.

An interval is as narrow as possible that reaches the Cramer-Rao bound by the truth plant's own sensitivities, where the size of the scatter and what a degree does to friction are known beforehand;
a unit's three or five healthy runs have to tell that.
"""


def _share(rows: Sequence[Row], holds: Callable[[Row], bool]) -> float:
    return 100.0 * sum(map(holds, rows)) / len(rows) if rows else float("nan")


def _of(rows: Sequence[Row], verdict: str) -> float:
    return _share(rows, lambda row: row["verdict"] == verdict)


def _sizes(rows: Sequence[Row], name: str) -> list[Mapping[str, Any]]:
    return [row["sizes"][name] for row in rows if row["sizes"] and row["verdict"] != "undecided" and row["sizes"][name]["half"] is not None]


def _error(rows: Sequence[Row], name: str) -> float:
    found = [one["shift"] - one["true"] for one in _sizes(rows, name)]
    return float(np.sqrt(np.mean(np.square(found)))) if found else float("nan")


def _held(rows: Sequence[Row], name: str) -> float:
    return _share(_sizes(rows, name), lambda one: bool(one["held"]))


def _allowed(rows: Sequence[Row]) -> float:
    """The rms error of CSJ that the scatter of these answers' units allows, in %."""
    by_setting = {one.setting: one.unit for one in units("unit", 1, 1)}
    some = [row for row in rows if row["sizes"] and row["verdict"] != "undecided"]
    found = [allowed_rms(by_setting[row["setting"]], row["healthy"], row["wear"].get("csj", 0.0)) for row in some]
    return float(np.sqrt(np.mean(np.square(found)))) if found else float("nan")


def _widened(sound: Sequence[Row], name: str) -> float:
    """Half intervals of sound units over the narrowest possible: the median of answers over that of a sample of units, the larger of the numbers of healthy records."""
    found = []
    for given in sorted({row["healthy"] for row in sound}):
        some = [row for row in sound if row["healthy"] == given]
        widths = [one["half"] for one in _sizes(some, name)]
        if widths:
            kind, setting = some[0]["kind"], some[0]["setting"]
            sample = [one for one in units(kind, _SAMPLED, 1, (given,), (setting,)) if not one.wear]
            narrowest = [half_widths(one, kind == "flight")[name] for one in sample]
            found.append(float(np.median(widths) / np.median(narrowest)))
    return max(found, default=float("nan"))


def _goals(rows: Sequence[Row]) -> str:
    of = {
        (kind, setting): [row for row in rows if (row["kind"], row["setting"]) == (kind, setting)]
        for kind in ("unit", "flight")
        for setting in ("", "scatter")
    }
    found = []

    def goal(text: str, wanted: str, value: float, met: bool, unit: str = " %") -> None:
        if not np.isnan(value):
            found.append((text, wanted, "yes" if met else "**no**", f"{value:.3g}{unit}"))

    for (kind, setting), some in of.items():
        title = f"{'flight code' if kind == 'flight' else 'desk'}, {'four times the scatter, +-8 degC' if setting else 'usual scatter'}"
        sound, worn = [row for row in some if row["sound"]], [row for row in some if row["worn"]]
        goal(f"{title}: sound units called healthy", ">= 97 %", value := _of(sound, "healthy"), value >= 97.0)
        goal(f"{title}: sound units called faulty", "<= 0.5 %", value := _of(sound, "fault"), value <= 0.5)
        goal(f"{title}: worn units called faulty", ">= 95 %", value := _of(worn, "fault"), value >= 95.0)
        for name, most in (("csj", 1.0), ("blk", 5.0)):
            # friction scatters and play does not
            allowed = max(most, _WIDER * _allowed(some)) if name == "csj" and setting else most
            goal(f"{title}: rms error of {_TITLES[name]}", f"<= {allowed:.3g} %", value := _error(some, name), value <= allowed)
            held = _held(some, name)
            goal(f"{title}: intervals of {_TITLES[name]} that hold the truth", "92 .. 98 %", held, 92.0 <= held <= 98.0)
            wide = _widened(sound, name)
            goal(
                f"{title}: intervals of {_TITLES[name]}, median, beside the narrowest possible",
                f"<= {_WIDER:g} x",
                wide,
                wide <= _WIDER,
                " x",
            )
    sizes = [row for row in rows if row["wrong"].startswith(_SIZE)]
    verdicts = sum(bool(row["wrong"]) for row in rows) - len(sizes)
    goal(f"surely wrong verdicts, of {len(rows)} answers", "0", float(verdicts), verdicts == 0, "")
    faulty = [row for row in rows if row["verdict"] == "fault"]
    stated = sum(len(_sizes(faulty, name)) for name in _TITLES)
    if stated:
        share = 100.0 * len(sizes) / stated
        goal(f"sizes surely off, of {stated} stated of faults", f"<= {_CHANCE:g} %, by chance", share, share <= _CHANCE)
    return "## Goals\n\n" + table(("", "goal", "met", "reached"), found, 2)


def _verdicts(title: Sequence[str], rows: Sequence[Row]) -> tuple[str, ...]:
    return (*title, str(len(rows)), *(f"{_of(rows, verdict):.1f}" for verdict in _VERDICTS), str(sum(bool(row["wrong"]) for row in rows)))


def _units(rows: Sequence[Row], kind: str, title: str) -> str:
    units = [row for row in rows if row["kind"] == kind]
    if not units:
        return ""
    found = []
    for setting in ("", "scatter"):
        for given in sorted({row["healthy"] for row in units}):
            for wear in ({}, {"csj": 0.2}, {"blk": 0.5}, {"csj": 0.4, "blk": 1.0}):
                some = [row for row in units if (row["setting"], row["healthy"], row["wear"]) == (setting, given, wear)]
                if some:
                    text = ", ".join(f"{_TITLES[name]} {100.0 * share:+.0f} %" for name, share in wear.items()) or "none"
                    widths = [
                        f"{np.median([one['half'] for one in _sizes(some, name)]):.2f}" if _sizes(some, name) else "" for name in _TITLES
                    ]
                    errors = [f"{_error(some, name):.2f}" if _sizes(some, name) else "" for name in _TITLES]
                    found.append((*_verdicts((setting or "usual", str(given), text), some), *errors, *widths))
    headings = ("scatter", "healthy records", "wear", "answers", *(f"{one}, %" for one in _VERDICTS), "wrong")
    more = ("rms error CSJ, %", "BLK, %", "half interval CSJ, %", "BLK, %")
    return f"## {title}\n\n" + table((*headings, *more), found, 10)


def _drawn(rows: Sequence[Row]) -> str:
    drawn = [row for row in rows if row["kind"] == "drawn"]
    if not drawn:
        return ""
    parts = [
        "## Drawn at random\n",
        "Any command, noise white, coloured (30 Hz) or in counts of 20 um, none to three healthy records, worn or not, and in 60 % something else that differs",
    ]
    parts[-1] += (
        " today: winding +-20 %, grease +-60 %, supply +-10 %, gain +-5 %, inverter drop to 0.6 V, or Stribeck friction of 0.2 that begins after 5 s.\n"
    )
    for title, name in (
        ("by machine", "build"),
        ("by what differs", "disturbance"),
        ("by command", "command"),
        ("by noise", "setting"),
        ("by healthy records", "healthy"),
        ("by signals", "alone"),
    ):
        found = []
        for value in sorted({row[name] for row in drawn}):
            words: dict[object, str] = {"": "nothing" if name == "disturbance" else "white"}
            words |= {True: "rod position alone", False: "four signals"} if name == "alone" else {}
            text = words.get(value, str(value))
            found.append(_verdicts((text,), [row for row in drawn if row[name] == value]))
        parts.append(table((title, "answers", *(f"{one}, %" for one in _VERDICTS), "wrong"), found, 6))
    return "\n".join([*parts, _drawn_sizes([row for row in drawn if row["verdict"] == "fault"])])


def _drawn_sizes(faulty: Sequence[Row]) -> str:
    """How right the sizes of these faults are."""
    found = []
    for alone in (False, True):
        some = [row for row in faulty if row["alone"] == alone]
        told = [
            (f"{_error(some, name):.2f}", f"{_held(some, name):.1f}", f"{np.median([one['half'] for one in _sizes(some, name)]):.2f}")
            for name in _TITLES
            if _sizes(some, name)
        ]
        if len(told) == len(_TITLES):
            found.append(("rod position alone" if alone else "four signals", str(len(some)), *told[0], *told[1]))
    each = ("rms error {}, %", "intervals that hold, %", "half interval, median, %")
    headings = [one.format(title) for title in _TITLES.values() for one in each]
    return table(("sizes of faults, by signals", "faults", *headings), found, 7)


def _wrong(rows: Sequence[Row]) -> str:
    wrong = [row for row in rows if row["wrong"]]
    if not wrong:
        return ""
    found = []
    for row in wrong[:60]:
        said = ", ".join(f"{_TITLES[name]} {one['shift']:+.1f} ({one['true']:+.0f})" for name, one in row["sizes"].items())
        given = f"{row['build']}, {row['healthy']} healthy, {'position alone' if row['alone'] or row['kind'] == 'flight' else 'four signals'}, {row['setting'] or 'white'}"
        found.append((row["wrong"], row["command"], given, f"{row['disturbance'] or 'nothing'} {row['off']:+.2f}", row["verdict"], said))
    return "## Surely wrong\n\n" + table(("in what", "command", "given", "differs", "verdict", "said (true), %"), found, 1)
