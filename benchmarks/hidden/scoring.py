"""What rows of trials add up to, and how far that is from the goals."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from rich.console import Console

from benchmarks.hidden.catalogue import FORMS, LIBRARY, SEVERITIES, stands_for
from benchmarks.hidden.machines import width_of_units
from benchmarks.hidden.trials import SET, TIMED
from ema_tools.library.registry import record_of
from ema_tools.words.terminal.console import table

Row = dict[str, Any]
# Two effects are told apart when this many standard deviations lie between them.
SEPARABLE = 3.0
_TRAINING_LIMIT, _HELD_OUT_LIMIT = 1.05, 1.15
STRONG = ("medium", "large")
# What a diagnosis may take, s on two cores: longer, and nobody waits beside it.
TIME_LIMITS = {
    "time": ("with five repeats", 2.5),
    "time_alone": ("without healthy repeats", 5.0),
    "time_position": ("with command and rod position alone", 5.0),
}
# Kinds of trial in which nothing is hidden: against repeats, and against the data sheet alone.
HEALTHY = ("healthy", "stranger")
# What real machines have and the other trials do not: forms that the library lacks, days that scatter more, units unlike what is assumed, another voltage.
UNLIKE = ("form", "scatter", "twice", "half", "terminals")
# A unit is farther from its data sheet than so many standard deviations in any of nine values once in 200 units: nobody who knows one record can name less without accusing more of them.
OF_UNITS = 3.45
_UNLIKE_TEXT = "other forms, four times the scatter, other units, voltage at the motor"


@dataclass(frozen=True)
class Share:
    """So many of so many."""

    count: int
    total: int

    @property
    def percent(self) -> float:
        """NaN of none."""
        return 100.0 * self.count / self.total if self.total else float("nan")

    def __str__(self) -> str:
        return f"{self.percent:.1f} % ({self.count} of {self.total})" if self.total else "-"


def share_of(rows: Sequence[Row], test: Callable[[Row], bool]) -> Share:
    """How many rows pass."""
    return Share(sum(bool(test(row)) for row in rows), len(rows))


def of_kind(rows: Sequence[Row], kind: str, *severities: str) -> list[Row]:
    """The rows of one kind, and of some severities."""
    return [row for row in rows if row["kind"] == kind and (not severities or row["severity"] in severities)]


def put_forward(row: Row) -> list[str]:
    """The names that the answer would add, effects and faults."""
    return [] if row["verdict"] in ("unknown", "refused") else row["accepted"]


def matches(row: Row, hidden: str, said: str) -> bool:
    """Whether a name says what is hidden: it stands for it, or is of the class that the answer states while nobody could tell the two apart."""
    if stands_for(said, hidden):
        return True
    apart = row.get("observer", {}).get("apart", {}).get(said)
    stated = any(stands_for(name, hidden) for name in row["class"])
    return stated and len(row["effects"]) == 1 and apart is not None and apart < SEPARABLE


def _beside(row: Row, said: str) -> bool:
    """Whether a name is a true part of a hidden form beside what the form counts as."""
    return any(hidden in FORMS and said in FORMS[hidden].beside for hidden in row["effects"])


def first_right(row: Row) -> bool:
    """Whether the first name is the hidden one or of its class."""
    return matches(row, row["effects"][0], row["first"])


def exact_set(row: Row) -> bool:
    """Whether all that is hidden is put forward for adding, and nothing else."""
    return len([said for said in _changed(row) if not _beside(row, said)]) == len(row["effects"]) and all_named(row)


def all_named(row: Row) -> bool:
    """Whether all that is hidden is put forward, beside whatever else."""
    return all(any(matches(row, hidden, said) for said in put_forward(row)) for hidden in row["effects"])


def _changed(row: Row) -> list[str]:
    """The names put forward but for what the unit has by itself, by its true size, which a data sheet alone does not tell."""
    return [said for said in put_forward(row) if said not in row.get("standing", ())]


def accused(row: Row) -> bool:
    """Whether any name is put forward for adding that the unit does not have by itself."""
    return bool(_changed(row))


def wrongly_accused(row: Row) -> bool:
    """Whether a name is put forward that is neither hidden nor the unit's own."""
    return any(not _beside(row, said) and not any(matches(row, hidden, said) for hidden in row["effects"]) for said in _changed(row))


def observed(rows: Sequence[Row]) -> Share:
    """The ideal observer's rate."""
    return share_of([row for row in rows if "right" in row.get("observer", {})], lambda row: row["observer"]["right"])


def of_units(row: Row) -> bool:
    """Whether what is hidden does what a value of the machine does, and goes no farther than units themselves do."""

    def within(effect: str) -> bool:
        twin = record_of(effect).confounded if effect in LIBRARY else None
        if twin is None:
            return False
        change = abs(LIBRARY[effect].medium * SEVERITIES[row["severity"]] / twin.size_per_change)
        return change < OF_UNITS * width_of_units(twin.parameter, row["kind"])

    return any(map(within, row["effects"]))


def training_ratio(row: Row) -> float:
    """Weighted rms error over the floor with what was found added."""
    return float(row["error"]["after"] / row["error"]["floor"])


def sizes(rows: Sequence[Row]) -> list[Row]:
    """All sizes of effects that were put forward by their own names."""
    return [size for row in rows for size in row["sizes"]]


def size_error_percent(size: Row) -> float:
    """Error of a size in percent of the true one."""
    return float(100.0 * abs(size["estimate"] - size["true"]) / abs(size["true"]))


@dataclass(frozen=True)
class Goal:
    """One goal: what, what was reached, the limit, and whether it is met; `beside` the ideal observer's figure or another to compare with."""

    text: str
    reached: str
    limit: str
    met: bool
    beside: str = ""


def _at_least(text: str, reached: Share, percent: float, beside: str = "") -> Goal:
    return Goal(text, str(reached), f">= {percent:g} %", reached.percent >= percent, beside)


def _accused(text: str, rows: Sequence[Row]) -> Goal:
    wrong = share_of(rows, accused)
    return Goal(text, str(wrong), "<= 1 of 200", 200 * wrong.count <= wrong.total)


def _gap(text: str, rows: Sequence[Row]) -> Goal:
    gap = observed(rows).percent - share_of(rows, first_right).percent
    return Goal(f"gap to the ideal observer, {text}", f"{gap:.1f}", "<= 3 percentage points", gap <= 3.0)


def goals(rows: Sequence[Row]) -> list[Goal]:
    """Every goal that these rows can judge."""
    found = []
    for severities, percent in ((STRONG, 99.0), (("small",), 97.0), (("edge",), 85.0)):
        some = of_kind(rows, "library", *severities)
        if some:
            found.append(
                _at_least(
                    f"right name or class first, {' and '.join(severities)}", share_of(some, first_right), percent, str(observed(some))
                )
            )
            found.append(_gap(" and ".join(severities), some))
    some = of_kind(rows, "position", "medium")
    if some:
        found.append(
            _at_least("the same with command and rod position alone, medium", share_of(some, first_right), 90.0, str(observed(some)))
        )
        found.append(_gap("with command and rod position alone, medium", some))
    for severity, percent in (("large", 90.0), ("medium", 75.0)):
        some = of_kind(rows, "alone", severity)
        if some:
            found.append(
                _at_least(
                    f"right name or class first without healthy repeats, {severity}",
                    share_of(some, first_right),
                    percent,
                    str(observed(some)),
                )
            )
            found.append(_gap(f"without healthy repeats, {severity}", some))
    for kind, text in zip(HEALTHY, ("healthy records accused", "healthy machines accused without healthy repeats"), strict=True):
        some = of_kind(rows, kind)
        if some:
            found.append(_accused(text, some))
    found += _unlike(rows)
    some = of_kind(rows, "outside", *STRONG)
    if some:
        found.append(_at_least("unknown for effects outside the library", share_of(some, lambda row: row["verdict"] == "unknown"), 90.0))
        wrong = share_of(some, accused)
        found.append(Goal("a name put forward for them", str(wrong), "none", wrong.count == 0))
    some = of_kind(rows, "pair", *STRONG)
    if some:
        found.append(_at_least("both of a pair named", share_of(some, all_named), 90.0))
        found.append(_at_least("the exact pair", share_of(some, exact_set), 80.0))
    some = [row for row in of_kind(rows, "library", *STRONG) if exact_set(row)]
    if some:
        found.append(
            _at_least(
                f"error after adding at most {_TRAINING_LIMIT:g} x the floor",
                share_of(some, lambda row: training_ratio(row) <= _TRAINING_LIMIT),
                100.0,
            )
        )
        held = [row for row in some if row.get("held_out")]
        if held:
            found.append(
                _at_least(
                    f"on a held-out command at most {_HELD_OUT_LIMIT:g} x",
                    share_of(held, lambda row: row["held_out"]["after"] <= _HELD_OUT_LIMIT),
                    100.0,
                )
            )
    stated = sizes(of_kind(rows, "library"))
    if stated:
        held_share = Share(sum(size["held"] for size in stated), len(stated))
        found.append(
            Goal("stated 95 % intervals that hold the true size", str(held_share), "90 .. 99 %", 90.0 <= held_share.percent <= 99.0)
        )
    for kind, (text, limit_s) in TIME_LIMITS.items():
        timed = of_kind(rows, kind)
        if timed:
            slowest = max(row["run_s"] for row in timed)
            found.append(Goal(f"a diagnosis {text} on all cores", f"{slowest:.1f} s", f"<= {limit_s:g} s", slowest <= limit_s))
    return found


def _unlike(rows: Sequence[Row]) -> list[Goal]:
    """Of UNLIKE, with healthy repeats and without."""
    found = []
    unlike = [row for kind in UNLIKE for row in of_kind(rows, kind)]
    for text, some in (
        (_UNLIKE_TEXT, [row for row in unlike if row["repeats"]]),
        ("other units without healthy repeats", [row for row in unlike if not row["repeats"]]),
    ):
        hidden = [row for row in some if row["effects"] and row["severity"] in STRONG]
        if hidden:
            found.append(
                _at_least(f"{text}: the right one accepted, medium and large", share_of(hidden, all_named), 95.0, str(observed(hidden)))
            )
            beyond = [row for row in hidden if row["repeats"] or not of_units(row)]
            if len(beyond) < len(hidden):
                found.append(
                    _at_least(
                        f"{text}: the same of what goes farther than units do by themselves",
                        share_of(beyond, all_named),
                        95.0,
                        str(observed(beyond)),
                    )
                )
            wrong = share_of(hidden, wrongly_accused)
            found.append(Goal(f"{text}: a wrong one accepted", str(wrong), "<= 1 %", wrong.percent <= 1.0))
        healthy = [row for row in some if not row["effects"]]
        if healthy:
            found.append(_accused(f"{text}: healthy accused", healthy))
    return found


def missed(row: Row) -> bool:
    """Whether a row is worth a look."""
    if row["kind"] == "placebo" or not row["effects"]:
        return accused(row)
    if row["kind"] == "outside":
        return bool(row["verdict"] != "unknown")
    if row["kind"] == "pair":
        return not exact_set(row)
    return row["kind"] not in TIMED and not first_right(row)


def set_rows(rows: Sequence[Row]) -> dict[str, list[Row]]:
    """The rows of each setting of machines, those without repeats by themselves."""
    found = {}
    for setting in SET:
        some = of_kind(rows, setting)
        found[setting] = [row for row in some if row["repeats"]]
        found[f"{setting}, no repeats"] = [row for row in some if not row["repeats"]]
    return {name: some for name, some in found.items() if some}


def confusions(rows: Sequence[Row]) -> dict[str, Counter[str]]:
    """Per hidden effect how often each name came first; what was not put forward counts as nothing, or unknown, by the verdict."""
    found: dict[str, Counter[str]] = {}
    for row in rows:
        said = row["first"] if accused(row) else row["verdict"] if row["verdict"] in ("unknown", "refused") else "nothing"
        found.setdefault(row["effects"][0] if row["effects"] else "healthy", Counter())[said] += 1
    return found


def show(console: Console, rows: Sequence[Row]) -> None:
    """The main figures, and every miss."""
    main = table(
        "hidden effects",
        "kind",
        "severity",
        "right first",
        "put forward, alone",
        "wrongly put forward",
        "unknown",
        "observer",
        "processor, s",
        text_columns=2,
    )
    plain = ("library", "position", "alone", "fault", "same", "placebo", "outside", "pair", *HEALTHY, "form", *TIMED)
    for name, kind_rows in [*((kind, of_kind(rows, kind)) for kind in plain), *set_rows(rows).items()]:
        for severity in ("", *SEVERITIES):
            some = [row for row in kind_rows if row["severity"] == severity]
            if some:
                nothing = not some[0]["effects"]
                named = "-" if nothing or name in ("outside", "pair") else str(share_of(some, first_right))
                alone = "-" if nothing or name == "outside" else str(share_of(some, exact_set))
                wrong = share_of(some, accused if nothing or name in ("placebo", "outside") else wrongly_accused)
                unknown = share_of(some, lambda row: row["verdict"] == "unknown")
                processor = f"{np.median([row['cpu_s'] for row in some]):.1f}"
                main.add_row(name, severity, named, alone, str(wrong), str(unknown), str(observed(some)), processor)
    console.print(main)
    for row in rows:
        if row["verdict"] == "refused":
            console.print(f"refused: {row['key']}: {row['refused']}", highlight=False)
    for row in filter(missed, rows):
        ranked = " ".join(f"{name}:{score:.0f}" for name, score in row["ranked"][:4])
        apart = " ".join(f"{value:.0f}" for value in row.get("observer", {}).get("size", []))
        hidden, said = "+".join(row["effects"]) or "healthy", "+".join(row["accepted"]) or "nothing"
        console.print(
            f"missed: {row['key']}: {hidden} (d' {apart or '-'}): {row['verdict']}, first {row['first']}, put forward {said}; scores {ranked}; left {row['unexplained']:.2f}"
        )
    for row in of_kind(rows, "library"):
        for size in row["sizes"]:
            if not size["held"]:
                off = (size["estimate"] - size["true"]) / max(size["std"], 1e-30)
                console.print(
                    f"size: {row['key']}: true {size['true']:.5g}, estimate {size['estimate']:.5g} +- {size['std']:.2g}, {off:+.1f} standard errors off"
                )
    judged = table("goals", "goal", "reached", "limit", "beside it", "met", text_columns=5)
    for goal in goals(rows):
        judged.add_row(goal.text, goal.reached, goal.limit, goal.beside, "yes" if goal.met else "NO")
    console.print(judged)
