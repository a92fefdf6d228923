"""Results as tables on the terminal, the sentence first."""

from __future__ import annotations

from rich.console import Console
from rich.text import Text

from ema_tools.compare.comparison import TITLES, UNITS, Comparison
from ema_tools.data.actuator import row_of, shown
from ema_tools.data.linear_axis import ForceModel
from ema_tools.select.holdout import Step
from ema_tools.select.search import Diagnosis
from ema_tools.tasks.add import Added
from ema_tools.tasks.calibrate import Calibration
from ema_tools.tasks.diagnose import Answer, size_text
from ema_tools.tasks.diagnose_by_laps import LapsAnswer, size_of
from ema_tools.tasks.identify import TITLES as FAULTS
from ema_tools.tasks.identify import Identified
from ema_tools.words.terminal.console import number, table

_PLACES = 8
# The share of the limit below which an effect is not worth a look.
_WORTH_SHOWING = 0.1


def say(console: Console, text: str) -> None:
    """A sentence, as it is."""
    console.print(Text(text))


def comparison(console: Console, found: Comparison, actuator: str, record: str) -> None:
    """What `ema compare` found."""
    say(console, found.sentence)
    console.print()
    shown = table(f"{actuator} against {record}", "channel", "unit", "rms error", "of measured", text_columns=2)
    for name, error in found.channels.items():
        shown.add_row(TITLES[name], UNITS[name], number(error.rmse), f"{number(error.relative_percent, 3)} %")
    console.print(shown)
    console.print()
    shown = table("Balances", "balance", "unit", "rms residual", "of measured", "noise", "method", "remark", text_columns=2)
    shown.columns[-1].justify = "left"
    shown.columns[-1].no_wrap = False
    for name, balance in found.balances.items():
        if balance.reason:
            shown.add_row(name, "", "-", "-", "-", "-", balance.reason)
        else:
            rest = f"at rest {balance.resting_percent:.0f} % of the time" if balance.resting_percent >= 0.5 else ""
            shown.add_row(
                name,
                balance.unit,
                number(balance.rms),
                f"{number(balance.relative_percent)} %",
                number(balance.noise_rms, 2),
                number(balance.method_rms, 2),
                rest,
            )
    console.print(shown)
    telling = sorted((place for place in found.where if place.surprise > 0.0), key=lambda place: -place.surprise)[:_PLACES]
    if telling:
        console.print()
        shown = table("Where more of the squared residual lies than of the time", "residual", "part", "share", "time", text_columns=2)
        for place in telling:
            shown.add_row(
                place.source, f"{place.by} {place.part}", f"{100.0 * place.share:.0f} %", f"{100.0 * (place.time_share or 0.0):.0f} %"
            )
        console.print(shown)


def calibration(console: Console, found: Calibration) -> None:
    """What `ema calibrate` found."""
    shown_table = table("Calibrated", "value", "unit", "before", "after", "std error", "from", text_columns=2)
    shown_table.columns[-1].justify = "left"
    for parameter in found.parameters:
        source = parameter.source + (", at its bound" if parameter.at_bound else "")
        row = row_of(parameter.name)
        shown_table.add_row(shown(row), row.unit, number(parameter.before, 5), number(parameter.after, 5), number(parameter.std, 2), source)
    console.print(shown_table)
    for names, why in found.left_out.items():
        say(console, f"No balance for {names}: {why}.")
    if found.at_rod():
        console.print()
        force_models(console, "The mechanics at the rod: force = M a + Fv v + Fc sgn v + offset", found.at_rod())
    console.print()
    errors = table("Measured minus simulated, rms", "channel", "unit", "before", "after", text_columns=2)
    for name, before in found.errors_before.items():
        errors.add_row(TITLES[name], UNITS[name], number(before), number(found.errors_after[name]))
    console.print(errors)
    left = found.unexplained()
    if left:
        times = ", ".join(f"{TITLES[name]} {number(value, 2)}" for name, value in left.items())
        say(
            console,
            f"What is left is many times the sensors' noise ({times} times): the values also make up for what the model lacks, or for a fault. "
            "Calibrate on healthy records; ema diagnose says what is missing.",
        )


def identification(console: Console, found: Identified) -> None:
    """What `ema identify` found."""
    say(console, found.sentence())
    console.print()
    rows = table("", "fault", "unit", "healthy", "estimate", "std error", "shift", text_columns=2)
    for estimate in found.answer.identified:
        unit = row_of(estimate.name).unit
        title = FAULTS.get(estimate.name, estimate.name) + (" (at its bound)" if estimate.at_bound else "")
        healthy = found.healthy[estimate.name]
        rows.add_row(
            title, unit, number(healthy, 5), number(estimate.estimate, 5), number(estimate.std, 2), f"{estimate.shift_percent:+.3f} %"
        )
    console.print(rows)
    answer = found.answer
    say(
        console,
        f"verdict {found.verdict}; model {'adequate' if found.adequate else 'not adequate'}: residual {number(answer.residual_rms_mm, 3)} mm rms",
    )
    for reason in found.reasons:
        say(console, f"  because {reason}")
    say(
        console,
        f"{answer.evaluations} model runs, {answer.model_steps} steps, {found.wall_s:.2f} s, {found.precision} bit, seed {found.seed}, ended by {answer.outcome}",
    )
    if found.baseline is not None:
        text = ", ".join(
            f"{FAULTS.get(name, name)} {number(value, 5)} +- {number(found.baseline.std[name], 2)}"
            for name, value in found.baseline.values.items()
        )
        say(console, f"healthy values from {found.baseline.records} healthy record{'s' if found.baseline.records > 1 else ''}: {text}")
    if found.seeds:
        for place, estimate in enumerate(answer.identified):
            values = [estimate.estimate, *(other.identified[place].estimate for other in found.seeds)]
            spread = 100.0 * (max(values) - min(values)) / abs(found.healthy[estimate.name])
            say(
                console,
                f"{FAULTS.get(estimate.name, estimate.name)} over {len(values)} seeds: {spread:.2g} % of the healthy value between the largest and the smallest",
            )


def diagnosis(console: Console, found: Answer) -> None:
    """What `ema diagnose` found, in the order in which a user asks."""
    say(console, found.sentence())
    console.print()
    say(console, found.gate.sentence)
    say(console, found.where.sentence)
    if found.hidden():
        say(console, found.hidden())
    console.print()
    _candidates(console, found.diagnosis)
    console.print()
    steps(console, found.steps, found.errors.floor)
    for left in found.left[:1]:
        say(console, left.sentence)
    if found.learned is not None:
        say(console, f"It can be flown without a name: {found.learned.sentence}.")
    say(console, found.next_step())


def _candidates(console: Console, found: Diagnosis) -> None:
    """What was accepted, and what would take off enough to be worth a look."""
    telling = [one for one in found.named[:_PLACES] if one.accepted or one.score > _WORTH_SHOWING * one.limit]
    if not telling:
        say(console, f"No effect of the library would take off a tenth of what it must, {number(found.limit, 3)} for most.")
        return
    rows = table("What would lower the error", "effect", "looks like", "size", "takes off", "limit", "", text_columns=3)
    for one in telling:
        size = next(iter(one.values), None)
        shown_size = size_text(size, one.values[size], one.std.get(size)) if size is not None else ""
        rows.add_row(
            one.name, ", ".join(one.alike[1:]), shown_size, number(one.score, 4), number(one.limit, 3), "accepted" if one.accepted else ""
        )
    console.print(rows)


def laps(console: Console, found: LapsAnswer) -> None:
    """What `ema diagnose` found by the laps of one record."""
    say(console, found.sentence())
    console.print()
    say(console, found.gate.sentence)
    say(console, found.where.sentence)
    console.print()
    forces = found.forces
    rows = table(
        "Force error, in % of the drive's force",
        "step",
        "looks like",
        "size in the last fit",
        "laps fitted",
        "laps held out",
        text_columns=3,
    )
    rows.add_row("as given", "", "", number(forces.given.training, 3), number(forces.given.holdout, 3))
    rows.add_row("base values refitted", "", "", number(forces.refitted.training, 3), number(forces.refitted.holdout, 3))
    for step in forces.steps:
        rows.add_row(
            f"+ {step.effect}",
            ", ".join(step.alike),
            size_of(step, forces.steps[-1]),
            number(step.errors.training, 3),
            number(step.errors.holdout, 3),
        )
    rows.add_row("floor: lap to lap", "", "", number(forces.floor_percent, 3), "")
    console.print(rows)
    refused = table("Refused", "effect", "why", text_columns=2)
    refused.columns[-1].no_wrap = False
    for one in forces.refused:
        refused.add_row(one.effect, one.reason)
    console.print()
    console.print(refused)
    say(console, found.next_step())


def steps(console: Console, way: tuple[Step, ...], floor: float) -> None:
    """The fall of the error."""
    held = any(step.holdout is not None for step in way)
    rows = table("Weighted error", "model", "on the record", *(("held out",) if held else ()))
    for place, step in enumerate(way):
        title = "as given" if place == 0 else f"+ {step.added}"
        rows.add_row(title, number(step.error, 4), *((number(step.holdout, 4),) if held else ()))
    rows.add_row("floor", number(floor, 4), *(("",) if held else ()))
    console.print(rows)


def added(console: Console, found: Added) -> None:
    """What `ema add` did."""
    say(console, found.sentence())
    console.print()
    rows = table("Fitted", "value", "unit", "after", "std error", "", text_columns=2)
    for name, value in found.fit.values.items():
        rows.add_row(
            shown(row_of(name)),
            row_of(name).unit,
            number(value, 5),
            number(found.fit.std.get(name), 2),
            "at its bound" if name in found.fit.at_bound else "",
        )
    console.print(rows)
    console.print()
    steps(console, found.steps, found.errors.floor)
    for first, second, value in found.correlations:
        say(console, f"{first} and {second} cannot be told apart on this record (correlation {value:.3f}).")


def force_models(console: Console, title: str, models: dict[str, ForceModel]) -> None:
    """Force models at a carriage, side by side."""
    rows = table(title, "", "M kg", "Fv N s/m", "Fc N", "offset N")
    for name, model in models.items():
        rows.add_row(name, f"{model.mass_kg:.4f}", f"{model.viscous_N_s_per_m:.4f}", f"{model.coulomb_N:.4f}", f"{model.offset_N:.4f}")
    console.print(rows)
