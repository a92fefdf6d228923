"""Is the rest noise? What the last model leaves of every signal: its size beside the noise level, and its spectrum, which is level where nothing but noise is left."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from html import escape

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.words.page import names
from ema_tools.words.page import text as words
from ema_tools.words.page.charts import Drawing, decades
from ema_tools.words.page.signals import Traces

_BANDS = 60  # of a spectrum
_TOP_SHARE = 0.75  # of half the sample rate: above it sensors make noise alone
_LEVEL = 2.0  # a band this many times above the noise is not noise


@dataclass(frozen=True)
class Left:
    """What a model leaves of one signal: rms and noise in the residual's unit, its spectrum as rms per band over the noise's, [bands]."""

    name: str
    rms: float
    noise: float
    frequency_hz: Reals
    multiples: dict[str, Reals]
    beyond_hz: tuple[float, float] | None  # where the last model's stands above the noise


def left_of(found: Traces) -> list[Left]:
    """Of every signal that was recorded."""
    curves = found.curves
    frequency = np.fft.rfftfreq(curves.rows, curves.period_s)
    half = 0.5 / curves.period_s
    low = 1.0 / (curves.rows * curves.period_s)
    if not half > 10.0 * low:
        return []
    edges = np.geomspace(low, half, _BANDS + 1)
    band = np.clip(np.digitize(frequency[1:], edges) - 1, 0, _BANDS - 1)
    count = np.bincount(band, minlength=_BANDS)
    there = count > 0
    top = frequency > _TOP_SHARE * half
    last = tuple(curves.models)[-1]
    drawn = []
    for name in found.names:
        if name in curves.derived:
            continue
        power = {key: np.abs(np.fft.rfft(found.residual(name, key))) ** 2 for key in curves.models}
        noise = float(np.mean(power[last][top]))
        if not noise > 0.0:
            continue
        multiples = {key: np.sqrt(np.bincount(band, one[1:], minlength=_BANDS)[there] / count[there] / noise) for key, one in power.items()}
        center = np.sqrt(edges[:-1] * edges[1:])[there]
        loud = center[multiples[last] > _LEVEL]
        scale = names.SIGNALS[name][3]
        rms = float(np.sqrt(np.mean(found.residual(name, last) ** 2)))
        beyond = (float(loud[0]), float(loud[-1])) if loud.size else None
        drawn.append(Left(name, rms * scale, math.sqrt(noise / curves.rows) * scale, center, multiples, beyond))
    return drawn


def spectra(found: Traces | None, titles: Mapping[str, str], floors: Mapping[str, float | None]) -> str:
    """A spectrum of every signal with what is left of it in words, and the legend. `titles`: what each model is called; `floors`: what baseline runs differ by, in the channel's unit."""
    drawn = left_of(found) if found is not None else []
    if not drawn:
        return ""
    parts = ['<div class="thirds">']
    for one in drawn:
        title, _, unit, scale = names.SIGNALS[one.name]
        between = floors.get(one.name)
        told = f"left {words.number(one.rms)} {unit}"
        if between is not None:
            told += f", baseline runs differ by {words.number(between * scale)} {unit}"
        told += f"; white noise {words.number(one.noise)} {unit}"
        if one.beyond_hz is None:
            told += ": noise at every frequency"
        elif one.beyond_hz[0] == one.beyond_hz[1]:
            told += f": above it at {words.number(one.beyond_hz[0], 2)} Hz"
        else:
            told += f": above it from {words.number(one.beyond_hz[0], 2)} to {words.number(one.beyond_hz[1], 2)} Hz"
        high = max(float(np.max(values)) for values in one.multiples.values())
        ends = decades(0.3, max(1.2 * high, 10.0))
        picture = Drawing(
            f"Spectrum of what is left of the {title.lower()}: {told}", "Frequency, Hz", "× white noise",
            (float(one.frequency_hz[0]), float(one.frequency_hz[-1])), ends, (True, True),
        )  # fmt: skip
        picture.line(np.array([one.frequency_hz[0], one.frequency_hz[-1]]), np.array([1.0, 1.0]), "noise")
        for key, values in one.multiples.items():
            picture.line(one.frequency_hz, values, key)
        parts.append(f"<figure><h3>{escape(title)}</h3>{picture.svg()}<figcaption>{escape(told)}.</figcaption></figure>")
    legend = "".join(f'<li><span class="key {key}"></span>{escape(title)}</li>' for key, title in titles.items())
    parts.append(f'</div><ul class="legend">{legend}<li><span class="key noise"></span>white noise of the sensor</li></ul>')
    return "".join(parts)
