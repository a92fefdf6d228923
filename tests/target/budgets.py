"""What the module costs on its target: measures a cross build, and holds docs/BUDGETS.md against the measurement.

Without --write it is a test: the document must be what this measurement gives, to the digit, and every target must be met or its reason stand in MISSED. With
another compiler than the document's the digits are not compared, the targets still are. Python's standard library alone.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import emulate
import stack

# 64 ns an instruction: one tick of the board's counter is less than one.
SHIFT = 6
CLOCK_HZ = 168_000_000
SLICES = (1, 7, 200, 1000)
UNIT_SLICES = (8, 200)
# Values of the searches by least squares, and their calls.
SQUARES = (2, 8)
SQUARES_CALLS = (("run, 200 steps", "slice_200"), ("result", "result"))
COUNTED_ALL = "counted all"
LOOKED_ALL = "looked everywhere"
# Lines of ema_worst: one model run by name, command and friction, and the longest slice of a session.
LOOKED = re.compile(r"^(\w+) (\w+) (free|seized) slice (\d+) of (\d+) step (\d+) of (\d+) start (\d+)$", re.MULTILINE)
LOOKED_SESSION = re.compile(r"^session (\S+) (\w+) slice (\d+)$", re.MULTILINE)
LOOKED_COMBINED = re.compile(r"^combinations (\w+) of (\d+) slice (\d+) refused (\d+)$", re.MULTILINE)
SHOWN = 8
SHOWN_SESSIONS = 4
CALLS = ("init", "feed", "run", "result")
# Ways to keep the command of a guarded session, by the names of their counts.
GUARDED = {"guarded": "the command recorded", "guarded_function": "the command a function"}
RECORD = "size_record_10s_int16"
STEP = "model_step_effect_"
# Effects whose model step has a limit of its own.
STEPS = {"stribeck_friction": ("Stribeck friction", 1000), "cogging_torque": ("cogging torque", 1500)}

# Why a target is not met, by its name; a reason for one that is met is wrong too.
MISSED = {
    "bare": "no effect is linked, but search and fit (3 KiB), sensitivities and verdict (1.9 KiB), control law, drive and encoder in all their modes (1.3 KiB) are; "
    "the next row leaves the modes out, too",
    "unit_tick": "its standing effects act in motion, so a step asks for their forces many times; a unit that has none costs what case A does",
    "code": "the first stage of the search (1.1 KiB) came after the limit; the flags of the next row meet it, and -DEMA_EFFECTS leaves out what is not needed",
    "tick_1": "between two steps the call, the choice of the part and the loop over the runs side by side are passed; slices of 7 meet it",
    "fixed": "the first stage of the search (1.1 KiB) came after the limit",
}


class BudgetError(Exception):
    """Why there is no measurement."""


@dataclass(frozen=True)
class Target:
    """A limit and what was measured."""

    name: str
    text: str
    limit: int
    measured: int
    unit: str

    @property
    def met(self) -> bool:
        """Whether the limit holds."""
        return self.measured <= self.limit


def steps_of(count: int) -> str:
    """A length of slices."""
    return f"{count} model step{'s' if count > 1 else ''}"


@dataclass(frozen=True)
class Level:
    """What the same code costs at another level of optimisation: bytes of code and constants, and of the deepest public function's stack."""

    option: str
    code: int
    stack: int


@dataclass(frozen=True)
class Looked:
    """The most that one model run has taken under one command: instructions, and the work that was counted for them, in plain steps."""

    name: str
    command: str
    seized: bool
    slice: int
    slice_work: int
    step: int
    step_work: int
    start: int


@dataclass(frozen=True)
class Worst:
    """What was looked for over effects and commands, and over sessions by name and record."""

    runs: tuple[Looked, ...]
    sessions: dict[tuple[str, str], int]
    combined: dict[str, tuple[int, int]]  # by name: how many configurations, and the longest slice of them

    def longest_slice(self) -> int:
        """Of everything that was looked at."""
        return max(self.slices()[0].slice, *self.sessions.values(), *(taken for _, taken in self.combined.values()))

    def slices(self) -> list[Looked]:
        """The run with the longest slice of each effect, the longest first."""
        return self._of_each(lambda run: run.slice)

    def steps(self) -> list[Looked]:
        """The run with the longest step of each effect, the longest first."""
        return self._of_each(lambda run: run.step)

    def fed(self) -> set[str]:
        """What sessions were fed."""
        return {fed for _, fed in self.sessions}

    def longest_sessions(self) -> list[tuple[tuple[str, str], int]]:
        """Those with the longest slices of each actuator, the longest first."""
        names = dict.fromkeys(name for name, _ in self.sessions)
        ordered = sorted(self.sessions.items(), key=lambda found: -found[1])
        return [found for name in names for found in [found for found in ordered if found[0][0] == name][:SHOWN_SESSIONS]]

    def _of_each(self, key: Callable[[Looked], int]) -> list[Looked]:
        names = dict.fromkeys(run.name for run in self.runs)
        return sorted((max((run for run in self.runs if run.name == name), key=key) for name in names), key=key, reverse=True)


def worst_of(output: str) -> Worst:
    """The lines of ema_worst. Raises BudgetError when it did not come to its end."""
    runs = tuple(
        Looked(name, command, friction == "seized", *(int(number) for number in numbers))
        for name, command, friction, *numbers in LOOKED.findall(output)
    )
    sessions = {(name, fed): int(taken) for name, fed, taken in LOOKED_SESSION.findall(output)}
    combined = {name: (int(number), int(taken)) for name, number, taken, _ in LOOKED_COMBINED.findall(output)}
    if LOOKED_ALL not in output.splitlines() or not runs or not sessions or not combined:
        raise BudgetError(f"ema_worst did not come to its end: {output.strip()[-200:]}")
    return Worst(runs, sessions, combined)


@dataclass(frozen=True)
class Measured:
    """Everything that the document tells."""

    compiler: str
    counts: dict[str, float]
    code: int
    whole: int
    whole_flags: str
    bare: int
    fixed: int
    stacks: dict[str, tuple[int, tuple[str, ...]]]
    guarded: int
    day: int
    squares: int
    levels: tuple[Level, ...]
    worst: Worst

    def number(self, name: str) -> int:
        """One of the counts, whole."""
        return round(self.counts[name])

    def targets(self) -> list[Target]:
        """Limits beside their measurements."""
        worst = max(size for size, _ in self.stacks.values())
        identify = [
            Target(
                f"identify_{slice_}",
                f"a whole identification of case A, slices of {steps_of(slice_)}",
                250_000_000,
                self.number(f"identify_int16_{slice_}"),
                "instructions",
            )
            for slice_ in SLICES
        ]
        tick = [
            Target(
                f"tick_{slice_}",
                f"1 ms of model time inside the search, slices of {steps_of(slice_)}",
                400,
                round(self.counts[f"identify_int16_{slice_}"] / self.counts[f"identify_int16_{slice_}_steps"]),
                "instructions",
            )
            for slice_ in SLICES
        ]
        ram = self.number("size_ema_session_t") + self.number("size_ema_session_config_t") + self.number(RECORD)
        return [
            Target("code", "code and constants with all effects", 26 * 1024 + 512, self.code, "bytes"),
            Target(
                "whole",
                f"the same compiled and linked as one, `{self.whole_flags}`: no bit of an answer moves",
                26 * 1024 + 512,
                self.whole,
                "bytes",
            ),
            Target("bare", "the first without effects: friction and backlash alone", 12 * 1024, self.bare, "bytes"),
            Target(
                "fixed",
                "the same with control law, drive, encoder, record and command fixed, ranges left to the desk, by all `-DEMA_ONLY_`",
                15 * 1024,
                self.fixed,
                "bytes",
            ),
            Target("ram", "memory: session, its configuration and a record of 10 s at 1 kHz", 48 * 1024, ram, "bytes"),
            Target("stack", "stack of the deepest public function", 512, worst, "bytes"),
            Target(
                "any_stack",
                f"the same at {', '.join(f'`{level.option}`' for level in self.levels)}",
                1024,
                max(level.stack for level in self.levels),
                "bytes",
            ),
            *tick,
            *identify,
            Target(
                "slice",
                "the longest slice of 200 plain steps, any effects, drive, control law, command or record",
                125_000,
                self.worst.longest_slice(),
                "instructions",
            ),
            Target("step", "the longest model step, any effect or command", 42_000, self.worst.steps()[0].step, "instructions"),
            *(
                Target(f"step_{name}", f"a model step with {text}", limit, self.number(f"{STEP}{name}_mean"), "instructions")
                for name, (text, limit) in STEPS.items()
            ),
            Target(
                "effect",
                f"a model step with its dearest effect, `{self.dearest()}`: 6 times one without",
                round(6 * self.plain()),
                self.number(f"{STEP}{self.dearest()}_mean"),
                "instructions",
            ),
        ]

    def effects(self) -> list[str]:
        """Effects that were counted, the dearest first."""
        names = [name.removeprefix(STEP).removesuffix("_mean") for name in self.counts if name.startswith(STEP) and name.endswith("_mean")]
        return sorted(names, key=lambda name: -self.counts[f"{STEP}{name}_mean"])

    def dearest(self) -> str:
        """The effect whose model step takes longest."""
        return self.effects()[0]

    def plain(self) -> float:
        """Instructions of a model step without effects, mean."""
        return self.counts["model_step_healthy_mean"]

    def per_ms(self, name: str) -> int:
        """Instructions for a millisecond of model time in a guarded identification."""
        return round(self.counts[f"{name}_identify"] / self.counts[f"{name}_steps"])

    def guarded_targets(self) -> list[Target]:
        """The same limits for a session behind a table of signatures, and the table's own."""
        ram = sum(self.number(f"size_ema_{name}_t") for name in ("guarded", "session_config", "command")) + self.number(RECORD)
        return [
            Target("table", "table of signatures of a chirp of 10 s, two signals", 128 * 1024, self.number("size_table"), "bytes"),
            Target(
                "guarded_ram",
                "memory behind it: guarded session, configuration, command, a record of 10 s with the current",
                48 * 1024,
                ram,
                "bytes",
            ),
            *(
                Target(
                    name.replace("guarded", "guarded_tick"), f"1 ms of model time behind it, {text}", 400, self.per_ms(name), "instructions"
                )
                for name, text in GUARDED.items()
            ),
            *(
                Target(
                    name.replace("guarded", "guarded_identify"),
                    f"a whole identification of case A behind it, {text}",
                    6 * CLOCK_HZ,
                    self.number(f"{name}_identify"),
                    "instructions",
                )
                for name, text in GUARDED.items()
            ),
        ]

    def unit_targets(self) -> list[Target]:
        """The same limits for a unit's own model."""
        return [
            Target("unit_tick", "1 ms of model time with a unit's own model", 400, self.unit_per_ms(), "instructions"),
            Target(
                "unit_identify",
                "a whole identification of a worn unit by its own model",
                6 * CLOCK_HZ,
                self.number(f"unit_identify_{UNIT_SLICES[-1]}"),
                "instructions",
            ),
        ]

    def unit_per_ms(self) -> int:
        """Instructions for a millisecond of model time in an identification of the unit."""
        return round(self.counts[f"unit_identify_{UNIT_SLICES[-1]}"] / self.counts["unit_steps"])

    def all_targets(self) -> list[Target]:
        """Without a table, with one, and with a unit's own model."""
        return [*self.targets(), *self.guarded_targets(), *self.unit_targets()]


def counts_of(output: str) -> dict[str, float]:
    """The `name value` lines of ema_count. Raises BudgetError when it did not come to its end."""
    lines = [line.split() for line in output.splitlines() if line.strip()]
    if COUNTED_ALL.split() not in lines:
        raise BudgetError(f"ema_count did not count to its end: {output.strip()[-200:]}")
    counts = {words[0]: float(words[1]) for words in lines if words != COUNTED_ALL.split()}
    zero = [name for name, value in counts.items() if value <= 0.0]
    if zero:
        raise BudgetError(f"ema_count: {zero[0]} is nothing")
    return counts


def code_bytes(size: str, program: Path, caller_object: Path) -> int:
    """Bytes of code and constants that the four calls link, less those of the function that calls them. Raises BudgetError."""
    linked, caller = (subprocess.run([size, str(file)], capture_output=True, text=True, check=False) for file in (program, caller_object))
    if linked.returncode != 0 or caller.returncode != 0:
        raise BudgetError(f"{program.name}: {(linked.stderr or caller.stderr).strip()}: build it first")
    whole, own = (int(done.stdout.splitlines()[1].split()[0]) for done in (linked, caller))
    if whole <= own:
        raise BudgetError(f"{program.name}: the module is not in it: link it")
    return whole - own


def measure(given: argparse.Namespace) -> Measured:
    """Runs, links and reads everything. Raises BudgetError and what it calls."""
    run = emulate.run(given.board, given.count, [], shift=SHIFT)
    if run.exit_code != 0:
        raise BudgetError(f"ema_count ended with {run.exit_code}: {run.output.strip()[-200:]}")
    counts = counts_of(run.output)
    looked = emulate.run(given.board, given.worst, [], shift=SHIFT)
    if looked.exit_code != 0:
        raise BudgetError(f"ema_worst ended with {looked.exit_code}: {looked.output.strip()[-200:]}")
    stacks = stack.worst_of(given.objects, given.include)
    around = stack.load(given.count_objects)
    for call in CALLS:
        # The function around the call has a frame of its own.
        counts[f"stack_session_{call}"] -= around.frame(f"call_{call}")
        used, bound = counts[f"stack_session_{call}"], stacks[f"ema_session_{call}"][0]
        if not 0 < used <= bound:
            raise BudgetError(f"ema_session_{call} used {used:.0f} bytes of stack, and its call graph says {bound}")
    counts["stack_unit_run"] -= around.frame("call_unit")
    if not 0 < counts["stack_unit_run"] <= stacks["ema_session_run"][0]:
        raise BudgetError(f"the unit's ema_session_run used {counts['stack_unit_run']:.0f} bytes of stack: more than its call graph says")
    programs = (given.flash, given.whole, given.bare, given.fixed)
    code, whole, bare, fixed = (code_bytes(given.size, program, given.flash_object) for program in programs)
    guarded = code_bytes(given.size, given.guarded, given.guarded_object)
    day = code_bytes(given.size, given.day, given.day_object)
    squares = code_bytes(given.size, given.squares, given.squares_object)
    # what calls the module is left out by its size at -Os: it is a handful of calls
    levels = [
        Level(
            f"-{level}",
            code_bytes(given.size, Path(program), given.flash_object),
            max(size for size, _ in stack.worst_of(Path(objects), given.include).values()),
        )
        for level, program, objects in given.level
    ]
    return Measured(
        given.compiler,
        counts,
        code,
        whole,
        given.whole_flags,
        bare,
        fixed,
        stacks,
        guarded,
        day,
        squares,
        tuple(levels),
        worst_of(looked.output),
    )


def grouped(value: float) -> str:
    """A whole number with its thousands apart."""
    return f"{round(value):,}".replace(",", " ")


def table(head: list[str], rows: list[list[str]]) -> list[str]:
    """Lines of a Markdown table; all columns but the first are numbers."""
    return ["| " + " | ".join(head) + " |", "|---|" + "---:|" * (len(head) - 1), *("| " + " | ".join(row) + " |" for row in rows), ""]


def effects_table(found: Measured) -> list[str]:
    """What a model step costs with each effect."""
    plain = found.plain()
    rows = [("no effect", "model_step_healthy"), *((name, f"{STEP}{name}") for name in found.effects())]
    return table(
        ["healthy actuator with", "instructions, mean", "times", "most"],
        [
            [
                text,
                grouped(found.counts[f"{name}_mean"]),
                f"{found.counts[f'{name}_mean'] / plain:.2f}",
                grouped(found.counts[f"{name}_most"]),
            ]
            for text, name in rows
        ],
    )


def document(found: Measured) -> str:
    """docs/BUDGETS.md."""
    lines = [
        "# Budgets",
        "",
        "What the module costs on a Cortex-M4F in float32. Written by `cmake --build build-cortex-m4f --target budgets`; the test `budgets` of that build measures anew",
        "and compares every number.",
        "",
        f"Built by gcc {found.compiler} with `-Os`. Instructions are counted in QEMU, where each takes the same time; they are not cycles and no worst-case",
        "execution time: flash wait states and long instructions come on top. The search is that of case A, seed 1, from a record in int16.",
        "",
        "## Targets",
        "",
    ]
    rows = []
    for target in found.all_targets():
        state = "met" if target.met else f"missed: {MISSED.get(target.name, '')}"
        rows.append([target.text, f"{grouped(target.limit)} {target.unit}", grouped(target.measured), state])
    lines += table(["what", "at most", "measured", ""], rows)
    lines += [
        "Code counts everything that the four calls and the default configuration link, gcc's and newlib's helpers included; the exported configuration adds",
        f"{grouped(found.number('size_ema_actuator_t'))} bytes of constants. The module has no variables of its own. `-DEMA_EFFECTS=none`, or names of effects, leaves the others out.",
        "",
        "## Time of the calls",
        "",
    ]
    calls = [
        ("ema_selftest", "selftest"),
        ("ema_session_init", "session_init"),
        ("ema_session_feed", "session_feed"),
        ("ema_session_run, 1 step", "slice_1"),
        ("ema_session_run, 200 steps", "slice_200"),
        ("ema_session_run, 1000 steps", "slice_1000"),
        ("ema_session_result, the search not ended", "session_result"),
        ("ema_session_result, done", "session_result_done"),
    ]
    lines += calls_table(found, calls)
    lines += [
        "Ending a model run and preparing the next is not divided, so a slice is never shorter than that.",
        "",
        "## One model step",
        "",
        "Mean over the chirp and its dearest step; each effect alone in the healthy reference actuator, at the lower end of its usual size.",
        "",
    ]
    lines += effects_table(found)
    lines += worst_section(found)
    lines += [
        "## How long an identification takes",
        "",
        "Case A at 168 MHz and one instruction per cycle, slices of 200 model steps, by the share of the processor that the background gets.",
        "",
    ]
    whole, mean = found.counts["identify_int16_200"], found.counts["slice_200_mean"]
    lines += table(
        ["share", "slices per second", "seconds"],
        [
            [f"{share} %", grouped(CLOCK_HZ * share / 100 / mean), f"{whole / (CLOCK_HZ * share / 100):.1f}"]
            for share in (5, 10, 25, 50, 100)
        ],
    )
    lines += ["## Stack", "", "Bound from the compiler's call graph, without interrupts, and what a whole identification used.", ""]
    lines += table(
        ["function", "bytes, bound", "used"],
        [
            [
                f"`{name}`",
                grouped(size),
                grouped(found.counts[f"stack_{name.removeprefix('ema_')}"]) if f"stack_{name.removeprefix('ema_')}" in found.counts else "",
            ]
            for name, (size, _) in sorted(found.stacks.items(), key=lambda item: (-item[1][0], item[0]))
        ],
    )
    lines += [
        "## Levels of optimisation",
        "",
        "The same sources and flags but for the level; a firmware that is debugged runs at `-Og` or `-O0`.",
        "",
    ]
    worst = max(size for size, _ in found.stacks.values())
    lines += table(
        ["level", "bytes of code and constants, all effects", "bytes of stack, deepest public function"],
        [[f"`{one.option}`", grouped(one.code), grouped(one.stack)] for one in (*found.levels, Level("-Os", found.code, worst))],
    )
    lines += ["## Memory", ""]
    sizes = {name.removeprefix("size_"): value for name, value in found.counts.items() if name.startswith("size_ema_")}
    lines += table(
        ["structure", "bytes"],
        [[f"`{name}`", grouped(value)] for name, value in sorted(sizes.items(), key=lambda item: (-item[1], item[0]))],
    )
    lines += guarded_section(found)
    lines += unit_section(found)
    lines += squares_section(found)
    lines += trend_section(found)
    return "\n".join(lines)


def calls_table(found: Measured, calls: list[tuple[str, str]]) -> list[str]:
    """Lines of a table of calls, each with its name among the counts."""
    return table(
        ["call", "instructions, mean", "most", "most, us at 168 MHz"],
        [
            [
                f"`{text.split(',')[0]}`{text[len(text.split(',')[0]) :]}",
                grouped(found.counts[f"{name}_mean"]),
                grouped(found.counts[f"{name}_most"]),
                f"{found.counts[f'{name}_most'] * 1e6 / CLOCK_HZ:.0f}",
            ]
            for text, name in calls
        ],
    )


def worst_section(found: Measured) -> list[str]:
    """What a slice takes at most."""
    worst = found.worst
    per_work = max(run.slice / run.slice_work for run in worst.runs)
    work = grouped(max(run.step_work for run in worst.runs))
    starts = [run.start for run in worst.runs]
    start = f"{grouped(min(starts))} to {grouped(max(starts))}"
    lines = [
        "## The longest slice",
        "",
        "The work of a slice is counted in plain steps: a model step is one, and what has to be located in it, or asked of effects, counts besides as much as it takes (`ema_step_scratch.h`). A slice",
        "ends with the step that reaches its length. Looked for with every effect, free and with the highest friction of a search, under the chirp's quick end, a jump from end to end in every step,",
        "noise over the whole travel, a square wave, a dither and long drives against the ends of travel; and in whole sessions on records of noise, of a rod at rest, and spoilt in every way",
        f"of [FAULTS](FAULTS.md) that is not refused: {len(worst.fed())} kinds of records, with and without standing effects; the {SHOWN_SESSIONS} with the longest slices of each are shown.",
        "",
    ]
    lines += table(
        ["longest slice of 200", "under", "instructions", "us at 168 MHz", "work, plain steps"],
        [
            *(
                [
                    run.name + (", seized" if run.seized else ""),
                    run.command,
                    grouped(run.slice),
                    f"{run.slice * 1e6 / CLOCK_HZ:.0f}",
                    grouped(run.slice_work),
                ]
                for run in worst.slices()[:SHOWN]
            ),
            *(
                [f"session, {name.replace('+', ' and ')}", fed.replace("_", " "), grouped(taken), f"{taken * 1e6 / CLOCK_HZ:.0f}", ""]
                for (name, fed), taken in worst.longest_sessions()
            ),
        ],
    )
    lines += table(
        ["longest model step", "under", "instructions", "us at 168 MHz", "work, plain steps"],
        [
            [
                run.name + (", seized" if run.seized else ""),
                run.command,
                grouped(run.step),
                f"{run.step * 1e6 / CLOCK_HZ:.0f}",
                grouped(run.step_work),
            ]
            for run in worst.steps()[:SHOWN]
        ],
    )
    lines += [
        "Configurations that are drawn: pairs of effects, triples and all at once, with voltage or current drive, late output, cascade or derivative action, late and stepped feedback,",
        "free or with the highest friction; half of them as model runs under these commands, half as sessions on these records.",
        "`ema_worst combinations 3000` looks at more of them than the test does.",
        "",
    ]
    lines += table(
        ["effects at once", "configurations", "longest slice of 200, instructions", "us at 168 MHz"],
        [[name, grouped(number), grouped(taken), f"{taken * 1e6 / CLOCK_HZ:.0f}"] for name, (number, taken) in worst.combined.items()],
    )
    lines += [
        "By its structure a model step counts at most 8 plain steps and 107 for each of its substeps with one effect (`EMA_STEP_WORK_MAX`), and twice that with an output delay:",
        "eight events in every substep.",
        f"The most that was found is {work}. A plain step of a slice has taken at most {per_work:.0f} instructions, so that a slice of n takes at most n + that many times",
        f"them. Preparing a run, which is not divided and counts as 110 plain steps, takes {start} instructions;",
        "a decision of the search counts as 20 + 3 n^3 with n values, 14 145 instructions with two and 63 045 with four.",
        "",
    ]
    return lines


def guarded_section(found: Measured) -> list[str]:
    """What a session behind a table of signatures costs: the example firmware's table."""
    lines = [
        "## With a table of signatures",
        "",
        f"Case A behind the table of the example firmware: position and current at 25 Hz, {grouped(found.counts['table_products'])} products at the end of every bin of",
        f"{grouped(found.counts['table_bin_rows'])} rows. Everything else as above.",
        "",
    ]
    lines += calls_table(
        found,
        [
            ("ema_guarded_init", "guarded_init"),
            ("ema_guarded_feed", "guarded_feed"),
            ("ema_guarded_run, 1 step", "guarded_slice_1"),
            ("ema_guarded_run, 200 steps", "guarded_slice_200"),
            ("ema_guarded_run, 200 steps, the command a function", "guarded_function_slice_200"),
            ("ema_guarded_result", "guarded_result"),
            ("ema_onboard_start", "onboard_start"),
            ("ema_onboard_run, 200 steps", "onboard_slice_200"),
            ("ema_onboard_result", "onboard_result"),
        ],
    )
    lines += [
        "The longest slices are the first, which also begins a run beside the table, and the last, which also ranks the effects. The rows of `ema_onboard` are those of one run",
        "without a session, with the command recorded. A command that is a function is not rounded to the record's counts, so its search takes another course.",
        "",
    ]
    rows = [
        ["session alone", grouped(found.counts["identify_int16_200"]), f"{found.counts['identify_int16_200'] / CLOCK_HZ:.1f}", "40 000"]
    ]
    rows += [
        [
            f"behind the table, {text}",
            grouped(found.counts[f"{name}_identify"]),
            f"{found.counts[f'{name}_identify'] / CLOCK_HZ:.1f}",
            "40 000" if name == "guarded_function" else "60 000",
        ]
        for name, text in GUARDED.items()
    ]
    rows += [
        ["one run beside the table alone", grouped(found.counts["onboard_whole"]), f"{found.counts['onboard_whole'] / CLOCK_HZ:.2f}", ""]
    ]
    lines += table(["whole identification, slices of 200 model steps", "instructions", "seconds at 168 MHz", "bytes of the record"], rows)
    beyond = found.number("size_ema_guarded_t") - found.number("size_ema_session_t")
    lines += table(
        ["what", "bytes"],
        [
            ["flash: the table", grouped(found.counts["size_table"])],
            ["flash: code beyond the session's", grouped(found.guarded - found.code)],
            ["memory: `ema_guarded_t` beyond the session in it", grouped(beyond)],
            ["memory: `ema_onboard_t`, where it is used without a session", grouped(found.counts["size_ema_onboard_t"])],
        ],
    )
    return lines


def unit_section(found: Measured) -> list[str]:
    """What a unit's own model costs: standing effects in every model step, four values in the search."""
    whole = found.counts[f"unit_identify_{UNIT_SLICES[-1]}"]
    lines = [
        "## With a unit's own model",
        "",
        "The worn unit of `recordings/unit` by the model that `ema calibrate` made of its healthy runs, from a record in int16: two standing effects, a ripple and a contact that yields, in",
        "every model step, and grease and winding of the day searched beside CSJ and BLK. Everything else as above.",
        "",
    ]
    lines += calls_table(
        found, [(f"ema_session_run, {steps_of(count).replace('model ', '')}", f"unit_slice_{count}") for count in UNIT_SLICES]
    )
    lines += [
        "While it holds, a contact that yields takes a model step in many parts, most of all with candidates of high friction, which the motor hardly moves; they count for what they take.",
        "The structures are the same as without, and so is the memory.",
        "",
    ]
    lines += table(
        ["what", "instructions"],
        [
            ["one model step, mean over the chirp", grouped(found.counts["model_step_unit_mean"])],
            ["one model step, most", grouped(found.counts["model_step_unit_most"])],
            ["1 ms of model time inside the search", grouped(found.unit_per_ms())],
            [f"whole identification, {grouped(found.counts['unit_runs'])} model runs: {whole / CLOCK_HZ:.1f} s at 168 MHz", grouped(whole)],
        ],
    )
    lines += table(
        ["what", "bytes"],
        [
            ["flash: `ema_session_config_day` and its call, beyond the session's code", grouped(found.day - found.code)],
            ["flash: the unit's configuration, in the place of the data sheet's", grouped(found.counts["size_ema_actuator_t"])],
            ["stack that `ema_session_run` used", grouped(found.counts["stack_unit_run"])],
        ],
    )
    return lines


def squares_section(found: Measured) -> list[str]:
    """What a search by least squares costs."""
    lines = [
        "## By least squares",
        "",
        "Case A with its current by `ema_least_squares`, from healthy values: CSJ and BLK, and eight values. It is a search of its own beside the session, which does not link it.",
        "",
    ]
    calls = [("ema_least_squares_init", "squares_2_init")]
    for count in SQUARES:
        calls += [(f"ema_least_squares_{name}, {count} values", f"squares_{count}_{key}") for name, key in SQUARES_CALLS]
    lines += calls_table(found, calls)
    lines += table(
        ["what", "instructions"],
        [
            [
                f"a whole search of {count} values, {grouped(found.counts[f'squares_{count}_runs'])} model runs: {found.counts[f'squares_{count}_whole'] / CLOCK_HZ:.1f} s at 168 MHz",
                grouped(found.counts[f"squares_{count}_whole"]),
            ]
            for count in SQUARES
        ],
    )
    lines += table(
        ["what", "bytes"],
        [
            ["flash: code beyond the session's", grouped(found.squares - found.code)],
            ["memory: `ema_least_squares_t`", grouped(found.number("size_ema_least_squares_t"))],
            ["memory: its record of 10 s at 1 kHz, command and rod position", grouped(found.number(RECORD))],
            ["memory: each further signal in it", grouped(found.number(RECORD) / 2)],
        ],
    )
    return lines


def trend_section(found: Measured) -> list[str]:
    """What trend and time to a limit cost."""
    lines = [
        "## Trend and time to a limit",
        "",
        "A trend with all its knots, by `ema_trend.h`. Firmware that does not call it links none of it.",
        "",
    ]
    calls = [
        ("ema_trend_update", "trend_update"),
        ("ema_forecast_run, one law", "trend_law"),
        ("ema_forecast_result", "trend_result"),
        ("ema_trend_save", "trend_save"),
    ]
    lines += calls_table(found, calls)
    lines += table(
        ["what", "instructions"],
        [
            [
                f"all laws of a forecast: {1000.0 * found.counts['trend_whole'] / CLOCK_HZ:.0f} ms at 168 MHz",
                grouped(found.counts["trend_whole"]),
            ]
        ],
    )
    lines += table(
        ["what", "bytes"],
        [
            ["memory of each value: `ema_trend_t`", grouped(found.number("size_ema_trend_t"))],
            ["memory of a forecast, one for all: `ema_forecast_t`", grouped(found.number("size_ema_forecast_t"))],
        ],
    )
    return lines


def summary(found: Measured) -> str:
    """The few numbers that docs/FIRMWARE.md shows between its marks."""
    per_ms = found.counts["identify_int16_200"] / found.counts["identify_int16_200_steps"]
    rows = [
        ["flash, all effects", f"{found.code / 1024:.1f} KiB, and {grouped(found.number('size_ema_actuator_t'))} bytes of configuration"],
        ["flash without effects", f"{found.bare / 1024:.1f} KiB, with all `EMA_ONLY_` {found.fixed / 1024:.1f} KiB"],
        [
            "RAM: session and its configuration",
            f"{grouped(found.number('size_ema_session_t') + found.number('size_ema_session_config_t'))} bytes",
        ],
        ["RAM: record", "4 bytes a row, 40 000 for 10 s at 1 kHz"],
        ["stack, deepest call", f"{grouped(max(size for size, _ in found.stacks.values()))} bytes"],
        ["`ema_session_feed`", f"{grouped(found.counts['session_feed_most'])} instructions"],
        [
            "a slice of 200 plain steps",
            (
                f"{grouped(found.counts['slice_200_mean'])} instructions, at most {grouped(found.counts['slice_200_most'])}; "
                f"with any effects, command or record at most {grouped(found.worst.longest_slice())}"
            ),
        ],
        ["1 ms of model time in the search", f"{grouped(per_ms)} instructions"],
        [
            "a whole identification",
            (
                f"{found.counts['identify_int16_200'] / 1e6:.0f} million instructions: "
                f"{found.counts['identify_int16_200'] / CLOCK_HZ:.1f} s of a core that makes {CLOCK_HZ // 1_000_000} million a second"
            ),
        ],
        [
            "optional: a table of signatures",
            f"{grouped(found.counts['size_table'])} bytes of flash, {grouped(found.guarded - found.code)} of code",
        ],
        [
            "optional: least squares, up to eight values",
            f"{grouped(found.number('size_ema_least_squares_t'))} bytes of RAM, {grouped(found.squares - found.code)} of code",
        ],
        ["a whole identification behind it", f"{found.counts['guarded_identify'] / 1e6:.0f} million instructions"],
        [
            "a whole identification by a unit's own model, with two standing effects",
            (
                f"{found.counts[f'unit_identify_{UNIT_SLICES[-1]}'] / 1e6:.0f} million instructions, "
                f"{grouped(found.day - found.code)} bytes of code"
            ),
        ],
    ]
    return "\n".join(["| what | how much |", "|---|---|", *("| " + " | ".join(row) + " |" for row in rows)])


def with_summary(page: str, found: Measured) -> str:
    """The page with its numbers of today. Raises BudgetError when it has no place for them."""
    parts = re.split(r"(?<=-->\n)(?:.*?\n)??(?=<!-- end of budgets -->)", page, maxsplit=1, flags=re.DOTALL)
    if len(parts) != 2:
        raise BudgetError("the page for firmware has no marks `budgets` and `end of budgets`: put them back")
    return f"{parts[0]}{summary(found)}\n{parts[1]}"


def problems_of(found: Measured, written: str) -> list[str]:
    """Targets missed without a reason or met with one, and the first line of the document that differs."""
    problems = [
        f"{target.text}: {grouped(target.measured)} {target.unit}, at most {grouped(target.limit)}: mend it, or state the reason in MISSED"
        for target in found.all_targets()
        if not target.met and target.name not in MISSED
    ]
    problems += [
        f"{target.text}: met, but MISSED still has a reason: take it out"
        for target in found.all_targets()
        if target.met and target.name in MISSED
    ]
    compiler = re.search(r"Built by gcc (\S+) ", written)
    if compiler is None:
        problems.append("BUDGETS.md: no document of this program: write it by the build's target `budgets`")
    elif compiler[1] != found.compiler:
        print(f"BUDGETS.md is of gcc {compiler[1]}, this is {found.compiler}: its numbers are not compared")
    else:
        fresh = document(found).splitlines()
        old = written.splitlines()
        differing = [(was, now) for was, now in zip(old, fresh, strict=False) if was != now]
        if differing or len(old) != len(fresh):
            was, now = differing[0] if differing else ("its length", "another")
            problems.append(f"BUDGETS.md: `{was}` is now `{now}`: write it anew by the build's target `budgets`")
    return problems


def main() -> int:
    """Entry point."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--board", required=True)
    parser.add_argument("--size", required=True, help="the cross compiler's size")
    parser.add_argument("--compiler", required=True, help="version of the cross compiler")
    parser.add_argument("--count", type=Path, required=True, help="the program ema_count")
    parser.add_argument("--worst", type=Path, required=True, help="the program ema_worst")
    parser.add_argument("--flash", type=Path, required=True, help="the program ema_flash")
    parser.add_argument("--bare", type=Path, required=True, help="the program ema_flash without effects")
    parser.add_argument("--fixed", type=Path, required=True, help="the same with everything fixed that can be")
    parser.add_argument("--whole", type=Path, required=True, help="the program ema_flash, compiled as one by -flto")
    parser.add_argument("--whole-flags", required=True, help="what that was compiled by beside the usual")
    parser.add_argument("--guarded", type=Path, required=True, help="the program ema_flash_guarded")
    parser.add_argument("--guarded-object", type=Path, required=True, help="the object file of ema_flash_guarded.c alone")
    parser.add_argument(
        "--level",
        nargs=3,
        action="append",
        required=True,
        metavar=("LEVEL", "PROGRAM", "OBJECTS"),
        help="ema_flash built with another level of optimisation, and the folder of its library's objects",
    )
    parser.add_argument("--squares", type=Path, required=True, help="the program ema_flash_squares")
    parser.add_argument("--squares-object", type=Path, required=True, help="the object file of ema_flash_squares.c alone")
    parser.add_argument("--day", type=Path, required=True, help="the program ema_flash_day")
    parser.add_argument("--day-object", type=Path, required=True, help="the object file of ema_flash_day.c alone")
    parser.add_argument("--flash-object", type=Path, required=True, help="the object file of ema_flash.c alone")
    parser.add_argument("--count-objects", type=Path, required=True, help="folder with the call graph of ema_count")
    parser.add_argument("--objects", type=Path, required=True, help="folder with the library's call graph")
    parser.add_argument("--include", type=Path, required=True, help="folder of the public headers")
    parser.add_argument("--write", action="store_true", help="write the document instead of comparing it")
    parser.add_argument("--page", type=Path, required=True, help="docs/FIRMWARE.md, which shows a few of the numbers")
    parser.add_argument("document", type=Path)
    given = parser.parse_args()
    try:
        found = measure(given)
        page = given.page.read_text(encoding="utf-8")
        fresh_page = with_summary(page, found)
    except (BudgetError, stack.StackError, FileNotFoundError, ValueError, KeyError) as error:
        print(f"budgets: {error}", file=sys.stderr)
        return 1
    if given.write:
        given.document.write_text(document(found), encoding="utf-8")
        given.page.write_text(fresh_page, encoding="utf-8")
        page = fresh_page
        print(f"{given.document.name} and {given.page.name} written")
    written = given.document.read_text(encoding="utf-8") if given.document.is_file() else ""
    problems = problems_of(found, written)
    if page != fresh_page and f"Built by gcc {found.compiler} " in written:
        problems.append(f"{given.page.name}: its numbers are not those of today: write them by the build's target `budgets`")
    for problem in problems:
        print(f"budgets: {problem}", file=sys.stderr)
    print(
        f"budgets: {len(found.all_targets())} targets, {sum(target.met for target in found.all_targets())} met, {len(found.stacks)} public functions"
    )
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
