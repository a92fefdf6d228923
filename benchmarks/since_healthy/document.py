"""The answers as tables."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from benchmarks.goals import Rows, at_least, at_most, rarely, share, table
from benchmarks.machines.plants import EFFECTS, KINDS, SCATTER
from benchmarks.since_healthy.trials import CHANGES, MOVING, NOTHING


def right(row: Mapping[str, Any]) -> bool:
    """Whether the answer says what has happened and nothing else: the value, the effect or one that such records cannot tell from it, or nothing."""
    accepted, changed = row.get("accepted", []), row.get("changed", {})
    if "refused" in row:
        return False
    if row["since"] in row["as_well"]:
        return True
    if row["since"] == NOTHING:
        return row["verdict"] == "adequate" and not accepted and not changed
    if row["since"] in CHANGES:
        return not accepted and list(changed) == [CHANGES[row["since"]][0]]
    return len(accepted) == 1 and row["since"] in row["classes"][0] and not changed


def wrong(row: Mapping[str, Any]) -> bool:
    """Whether the answer says something that has not happened. A constant load that stands as a changed load, or a change that is told beside a right one, is one as well."""
    accepted, changed = row.get("accepted", []), row.get("changed", {})
    told = CHANGES[row["since"]][0] if row["since"] in CHANGES else ""
    if row["since"] in row.get("as_well", []):
        return False
    return (
        any(row["since"] not in alike for alike in row.get("classes", []))
        or any(name != told for name in changed)
        or (told != "" and bool(accepted))
    )


def _answer(row: Mapping[str, Any]) -> str:
    """What was said, in a few words."""
    if "refused" in row:
        return str(row["refused"])
    changed = [f"{name} {percent:+.0f} %" if percent is not None else name for name, percent in row["changed"].items()]
    alike = [f"as well {name}" for name in row["as_well"]]
    return ", ".join([*row["accepted"], *changed, *alike]) or row["verdict"]


def written(rows: Rows, call: str) -> str:
    """The document."""
    nothing = [row for row in rows if row["since"] == NOTHING]
    values = [row for row in rows if row["since"] in CHANGES]
    effects = [row for row in rows if row["since"] in EFFECTS]
    goals = (
        at_least("a value that changed is told, and nothing else", share(values, right)),
        at_least("an effect that began is told, and nothing else", share(effects, right)),
        at_most("something told that has not happened", share([*values, *effects], wrong)),
        rarely("unchanged machines accused", share(nothing, wrong)),
    )
    lines = [
        "# What has happened since a machine was healthy, its controller being unknown",
        "",
        "Written by a command; do not edit. To write it again, after `cmake --workflow --preset test`, in the project's folder with the build's Python:",
        "",
        f"    {call}",
        "",
        "The machines are those of MACHINES.md, which share nothing with the library. Two days of three healthy records are given by `--healthy`, and three of a third day, when one",
        f"thing has happened: {', '.join(f'{name} {100.0 * share:+g} %' for name, (_, share) in CHANGES.items())}, or an effect has begun (sizes as there), or nothing. From record to",
        f"record friction differs by {100.0 * SCATTER['friction']:g} % and drag by {100.0 * SCATTER['viscous']:g} % (standard deviation); what moves by chance moves otherwise every time.",
        "*Right* is what happened, or an effect that the answer says these records cannot tell from it, and nothing beside it; *wrong* is anything told that did not happen. An answer that names",
        "nothing where something happened is neither. A changed value is right for an effect where the answer says beside it that the effect explains these records as well (`as_well`): most bumps",
        "of friction at low speed are told by the torque at which the machine leaves its rests.",
        "",
        *table(goals),
    ]
    for title, key, names in (
        ("By what happened", "since", (NOTHING, *CHANGES, *EFFECTS)),
        ("By kind of machine", "kind", tuple(KINDS)),
        ("By command", "command", MOVING),
    ):
        lines += [f"## {title}", "", f"| {key} | right | wrong |", "|---|---:|---:|"]
        for name in names:
            here = [row for row in rows if row[key] == name]
            lines.append(f"| {name} | {share(here, right)[1]} | {share(here, wrong)[1]} |")
        lines.append("")
    lines += ["## What was not right", "", "| machine, command and what happened | answer |", "|---|---|"]
    lines += [f"| {row['key']} | {_answer(row)} |" for row in rows if not right(row)]
    return "\n".join(lines) + "\n"
