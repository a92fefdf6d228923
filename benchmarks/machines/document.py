"""The answers as tables."""

from __future__ import annotations

from benchmarks.goals import Rows, at_least, at_most, rarely, share, table
from benchmarks.machines.plants import BEHIND, COMMANDS, EFFECTS, KINDS
from benchmarks.machines.trials import HEALTHY, SIZES, named, right, wrong


def _cells(rows: Rows) -> str:
    hidden = [dict(row) for row in rows if row["effect"] != HEALTHY]
    sound = [dict(row) for row in rows if row["effect"] == HEALTHY]
    by_size = [share([row for row in hidden if row["size"] == size], right)[1] for size in SIZES]
    return " | ".join([*by_size, share(hidden, lambda row: bool(wrong(row)))[1], share(sound, lambda row: bool(wrong(row)))[1]])


def _best(rows: Rows) -> str:
    """What the ideal observer would name rightly, in %."""
    chances = [row["chance"] for row in rows if row["effect"] != HEALTHY]
    return f"{100.0 * sum(chances) / len(chances):.1f} %" if chances else "-"


def written(rows: Rows, best: Rows, call: str) -> str:
    """The document: `best` are the rows of the ideal observer."""
    hidden, sound = named([dict(row) for row in rows]), [dict(row) for row in rows if row["effect"] == HEALTHY]
    goals = (
        at_least("right effect or class accepted first, medium and large", share(hidden, right)),
        at_most("a wrong effect accepted", share(hidden, lambda row: bool(wrong(row)))),
        rarely("healthy machines accused", share(sound, lambda row: bool(wrong(row)))),
    )
    head = f"| {' | '.join(SIZES)} | wrong accepted | healthy accused |"
    lines = [
        "# Machines whose controller nobody knows",
        "",
        "Written by a command; do not edit. To write it again, after `cmake --workflow --preset test`, in the project's folder with the build's Python:",
        "",
        f"    {call}",
        "",
        "Six kinds of machines are simulated that share nothing with the library: bristle friction whose bump falls as 1 / (1 + (w/w0)^2) where the library has an",
        "exponential, waves with a second harmonic of 15 %, a speed loop of which no record tells, fixed steps of 20 µs. Recorded are one motion and one drive, as that",
        "machine's drive gives them: twelve records at steady speeds, or three of each other command. The diagnosis gets the inertia to 5 %, the kind's friction, and the",
        "records. *Right* is the hidden effect, or one that the answer says these records cannot tell from it, accepted and before any other; *wrong* is any other",
        "accepted effect but `presliding`, which all these machines have. Medium and large, as a share of the friction, of the drag, of the torque constant or of half the stroke: "
        + ", ".join(f"{name} {100.0 * share:g} and {250.0 * share:g} %" for name, share in EFFECTS.items())
        + ". A play",
        f"(`elastic_backlash`) has a second mass behind it, {100.0 * BEHIND:g} % of the inertia, and a damped spring at either end; the library's law has no mass.",
        "",
        f"The ideal observer, who knows the machine and the form of every effect and asks which of them made the torque (`observer.py`), would name {_best(best)} of what is hidden:",
        "what is missed below is missed for the forms that nobody knows, and for the sensors of the motion.",
        "",
        *table(goals),
    ]
    for title, key, values in (
        ("By effect", "effect", tuple(EFFECTS)),
        ("By kind of machine", "kind", tuple(KINDS)),
        ("By command", "command", COMMANDS),
    ):
        lines += [f"## {title}", "", f"| {key} {head}", "|---|---:|---:|---:|---:|"]
        lines += [f"| {value} | {_cells([row for row in rows if row[key] == value])} |" for value in values]
        lines.append("")
    off = [row for row in rows if row.get("refused") or wrong(dict(row)) or (row["effect"] != HEALTHY and not right(dict(row)))]
    lines += ["## What was not right", "", "| machine, command and what was hidden | answer |", "|---|---|"]
    lines += [f"| {row['key']} | {row.get('refused') or ', '.join(row['accepted']) or row['verdict']} |" for row in off]
    return "\n".join(lines) + "\n"
