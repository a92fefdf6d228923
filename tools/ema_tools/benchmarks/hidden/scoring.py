"""What rows of trials add up to."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np
from rich.console import Console

from ema_tools.benchmarks.hidden.catalogue import SEVERITIES, same_class
from ema_tools.console import table

Row = dict[str, Any]
# Two effects are told apart when this many standard deviations lie between them.
SEPARABLE = 3.0


def first_right(row: Row) -> bool:
    """Whether the first name is the hidden one, or one of its class: a declared one, or one that the answer states and that nobody could tell apart."""
    hidden, first = row["effects"][0], row["first"]
    if same_class(hidden, first):
        return True
    apart = row.get("observer", {}).get("apart", {}).get(first)
    return hidden in row["class"] and apart is not None and apart < SEPARABLE


def accepted_right(row: Row) -> bool:
    """Whether it was also put forward for adding, and nothing else with it."""
    return row["verdict"] == "missing" and first_right(row) and len(row["accepted"]) == 1


def of_kind(rows: Sequence[Row], kind: str, severity: str | None = None) -> list[Row]:
    """The rows of one kind, and of one severity."""
    return [row for row in rows if row["kind"] == kind and (severity is None or row["severity"] == severity)]


def share(flags: Sequence[bool]) -> str:
    """Count and percent."""
    return f"{sum(flags)} of {len(flags)} ({100.0 * sum(flags) / len(flags):.0f} %)" if flags else "-"


def show(console: Console, rows: Sequence[Row]) -> None:
    """The main figures, and every miss."""
    main = table("named first", "kind", "severity", "right", "put forward alone", "observer", "time, s", text_columns=2)
    for kind in ("library", "position", "alone", "fault", "same", "placebo"):
        for severity in SEVERITIES:
            some = of_kind(rows, kind, severity)
            if some:
                watched = [row["observer"]["right"] for row in some if "observer" in row]
                main.add_row(kind, severity, share([first_right(row) for row in some]), share([accepted_right(row) for row in some]), share(watched), f"{np.median([row['run_s'] for row in some]):.1f}")
    console.print(main)
    verdicts = table("verdicts", "kind", "severity", "verdicts", text_columns=3)
    for kind in ("healthy", "outside", "pair", "placebo"):
        for severity in ("", *SEVERITIES):
            some = of_kind(rows, kind, severity)
            if some:
                verdicts.add_row(kind, severity, ", ".join(f"{name} {count}" for name, count in Counter(row["verdict"] for row in some).most_common()))
    console.print(verdicts)
    misses = [row for row in rows if _missed(row)]
    listed = table("misses", "kind", "hidden", "severity", "command", "machine", "verdict", "first", "accepted", "ranked", text_columns=9)
    for row in misses:
        ranked = " ".join(f"{name}:{score:.0f}" for name, score in row["ranked"][:4])
        listed.add_row(row["kind"], "+".join(row["effects"]), row["severity"], row["command"], str(row["machine"]), row["verdict"], row["first"], "+".join(row["accepted"]), ranked)
    console.print(listed)


def _missed(row: Row) -> bool:
    if row["kind"] == "healthy":
        return bool(row["verdict"] != "adequate")
    if row["kind"] == "outside":
        return bool(row["verdict"] != "unknown")
    if row["kind"] == "pair":
        return len(row["accepted"]) != 2 or any(not any(same_class(name, said) for said in row["accepted"]) for name in row["effects"])
    if row["kind"] == "placebo":
        return first_right(row) and row["verdict"] == "missing"
    return not first_right(row)
