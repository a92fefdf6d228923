"""The result of `ema next`."""

from __future__ import annotations

import math

from ema_tools.design.menu import SafeRange
from ema_tools.design.next_experiment import SEPARATE, Next, Option
from ema_tools.results import experiment as result
from ema_tools.results.parts import Provenance
from ema_tools.words.answers.steps import field_of
from ema_tools.words.sentences import experiment as say


def experiment(found: Next, provenance: Provenance) -> result.Experiment:
    """What was found, in the sizes that were asked for or taken."""
    return result.Experiment(
        command="next",
        effects=tuple(found.effects),
        channels=tuple(found.channels),
        sizes={effect: {field_of(name): float(value) for name, value in values.items()} for effect, values in found.values.items()},
        larger=found.larger,
        needed=SEPARATE,
        sentence=say.sentence(found),
        best=_option(found.best) if found.best is not None else None,
        options=tuple(map(_option, found.options)),
        unsafe={command: say.offence(one) for command, one in found.unsafe.items()},
        limits=limits_of(found.limits),
        confused=found.confused,
        advice=say.advice(found),
        provenance=provenance,
    )


def limits_of(found: SafeRange) -> result.SafeLimits:
    """What a command may ask of the machine."""
    speed_mm_s = found.speed_mm_s if math.isfinite(found.speed_mm_s) else None
    return result.SafeLimits(found.stroke_mm, speed_mm_s, found.current_A, found.output)


def _option(option: Option) -> result.OptionEntry:
    return result.OptionEntry(
        option.title,
        option.command,
        option.separation,
        tuple(result.Pair(pair, value) for pair, value in option.pairs.items()),
        dict(option.shown),
        option.peak_current_A,
        option.peak_speed_mm_s,
    )
