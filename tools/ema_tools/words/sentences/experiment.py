"""What `ema next` says: the command that separates effects, or what would where none does."""

from __future__ import annotations

from collections.abc import Mapping

from ema_tools.design.menu import Asked, Offence
from ema_tools.design.next_experiment import SEPARATE, Next
from ema_tools.library.display_names import all_coded, coded
from ema_tools.library.measurements import MEASUREMENTS
from ema_tools.library.registry import separating
from ema_tools.results.experiment import SafeLimits

# What a run does with a limit, its unit, and in how many of that unit the limit is counted.
_ASKED: Mapping[Asked, tuple[str, str, float]] = {
    "stroke_mm": ("reaches", "mm", 1.0),
    "speed_mm_s": ("runs at", "mm/s", 1.0),
    "current_A": ("draws", "A", 1.0),
    "output": ("takes", "% of the controller's range", 100.0),
}


def offence(found: Offence) -> str:
    """Why a command is not safe."""
    verb, unit, scale = _ASKED[found.limit]
    text = f"{verb} {scale * found.value:.3g} {unit}, allowed is {scale * found.allowed:.3g}"
    return f"with {coded(found.effect)} it {text}" if found.effect else text


def limits(found: SafeLimits) -> str:
    """What is safe."""
    speed = f"{found.speed_mm_s:.3g} mm/s" if found.speed_mm_s is not None else "any speed (no back-EMF is known)"
    return f"at most {found.stroke_mm:.3g} mm from the middle, {speed}, {found.current_A:.3g} A, {100.0 * found.output:.0f} % of the controller's range"


def sentence(found: Next) -> str:
    """The command to run, or that none helps and what would."""
    names = all_coded(found.effects, " and " if len(found.effects) == 2 else ", ")
    if not found.options:
        return f"No command of the menu is safe on this actuator: {next(map(offence, found.unsafe.values()), 'the menu is empty')}."
    first = found.options[0]
    if found.best is not None:
        size = f", at sizes {found.larger:g} times the usual lower end" if found.larger > 1.0 else ""
        return f"Next: {first.title}, --command {first.command}: it separates {names} by {first.separation:.3g} standard deviations{size} ({SEPARATE:g} tell them apart)."
    if not found.confused:
        each_pair = "; ".join(
            f"{all_coded(pair, ' and ')}: --command {best.command} ({best.pairs[pair]:.3g})" for pair, best in found.best_of_each.items()
        )
        return f"No single command separates {names}, but each pair has one: {each_pair}."
    most = max(option.separation for option in found.options)
    pairs = "; ".join(all_coded(pair, " and ") for pair in found.confused)
    return f"No command of the menu separates {pairs}: at best {most:.2g} standard deviations, {SEPARATE:g} are needed. {' '.join(advice(found))}".strip()


def advice(found: Next) -> tuple[str, ...]:
    """What would separate the pairs that are left, a sentence each."""
    if not found.confused:
        return ()
    said = []
    if found.hidden:
        said.append(
            f"At these sizes no command shows {all_coded(found.hidden, ' or ')} plainly: ask again with larger sizes (--set), or with less noise."
        )
    if found.with_channels is not None:
        names, option = found.with_channels
        said.append(
            f"Record {' and '.join(name for name in names if name not in found.channels)} too: --command {option.command} then separates them by {option.separation:.3g}."
        )
    count = found.repeats()
    if count is not None:
        said.append(f"The mean of {count} repeats of --command {found.options[0].command} would.")
    would = {one for pair in found.confused for one in separating(pair)}
    said += [f"What would: {one.do}: {one.because}." for one in MEASUREMENTS if one in would]
    return tuple(said) or ("What would is outside this record: another sensor, a known load, or a change of temperature.",)
