"""The pictures of where the model fails: friction against speed, loops at reversals, orders per turn, and the worst equation over the axes of which it says most."""

from __future__ import annotations

from html import escape

import numpy as np

from ema_tools.results.addition import Addition
from ema_tools.results.localisation import BinsEntry, LinesEntry, Loop, Pictures, TorqueSpeed, TurnTorque
from ema_tools.words.page import names
from ema_tools.words.page import text as words
from ema_tools.words.page.charts import Drawing, ends
from ema_tools.words.page.diagnosis_results import Diagnosed, Picture
from ema_tools.words.page.first_screen import telling

_MORE_MAX = 6
_SLOWEST = 3e-3  # of the largest speed: where the logarithmic axis begins
_MIDDLE = (5.0, 99.5)  # percentiles that the friction law shows: just at a reversal torque has either sign
_OTHER = {"healthy": "baseline runs", "model": "model"}


def figures(result: Diagnosed) -> list[str]:
    """The fixed pictures, as far as the result has them."""
    if isinstance(result.found, Addition):
        return []
    found = result.found.where.pictures
    drawn = []
    if found.torque_speed is not None:
        drawn += _law(found.torque_speed)
    if found.turn is not None:
        drawn += _turn(found.turn)
    drawn += _loops(found)
    loud = {one.name for one in telling(result)}
    for name, orders in ((name, orders) for name, orders in found.orders.items() if name in loud):
        drawn += _orders(name, orders.unit, orders.turns, "motor turn")
        drawn += _orders(name, orders.unit, orders.leads, "screw lead")
    return drawn


def _figure(title: str, picture: Drawing, caption: str, keys: tuple[tuple[str, str], ...] = ()) -> str:
    legend = "".join(f'<li><span class="key {kind}"></span>{escape(name)}</li>' for kind, name in keys)
    shown = f'<ul class="legend">{legend}</ul>' if keys else ""
    return f'<figure><div class="figure-head"><h3>{escape(title)}</h3>{shown}</div>{picture.svg()}<figcaption>{escape(caption)}</figcaption></figure>'


def _law(found: TorqueSpeed) -> list[str]:
    """Torque without inertia against the motion, over the logarithm of speed."""
    points, measured, expected = found.points, found.measured, found.expected
    speed, torque = np.asarray(points.x), np.asarray(points.y)
    fastest = float(np.max(np.abs(speed), initial=0.0))
    slowest = _SLOWEST * fastest
    moving = np.abs(speed) >= slowest
    if not fastest > 0.0:
        return []
    x_ends = (slowest, 1.1 * fastest)
    picture = Drawing(
        "Friction against speed, logarithmic", f"Speed of the motor, {found.axis_unit}", f"Torque against the motion, {found.unit}",
        x_ends, ends(np.percentile(torque[moving] * np.sign(speed[moving]), _MIDDLE), zero=True), (True, False),
    )  # fmt: skip
    for side, dash in ((1.0, ""), (-1.0, " back")):
        here = moving & (speed * side > 0.0)
        picture.dots(np.abs(speed[here]), side * torque[here], "measured")
        for entry, kind in ((expected, "after"), (measured, "before")):
            if entry is not None:
                _side(picture, entry, side, slowest, kind + dash)
    caption = "Dots: samples; lines: means in equal steps of speed, dashed backward. Inertia is taken off."
    return [_figure("Torque against speed: the friction law", picture, caption, (("before", "today"), ("after", _OTHER[found.other])))]


def _side(picture: Drawing, entry: BinsEntry, side: float, slowest: float, kind: str) -> None:
    center, mean = np.asarray(entry.center), np.asarray(entry.mean)
    here = center * side > slowest
    if np.count_nonzero(here) > 1:
        order = np.argsort(np.abs(center[here]))
        picture.line(np.abs(center[here])[order], side * mean[here][order], kind)


def _turn(found: TurnTorque) -> list[str]:
    """Torque over one turn, of the record and of what the model's effects make."""
    sides = {"after": found.model, "before": found.measured}
    lines = {kind: (np.asarray(one.center), np.asarray(one.mean), np.asarray(one.low), np.asarray(one.high)) for kind, one in sides.items()}
    title = "Torque over one turn of the motor, less base values"
    across, up = ends(*(one[0] for one in lines.values())), ends(*(edge for one in lines.values() for edge in one[2:]))
    picture = Drawing(title, f"Angle of the motor, {found.axis_unit}", f"Torque, {found.unit}", across, up)
    for kind, (center, mean, low, high) in lines.items():
        picture.band(center, low, high, kind)
        picture.line(center, mean, kind)
    return [_figure(title, picture, "Mean, and band of one standard deviation.", (("before", "today"), ("after", "model's effects")))]


def _loops(found: Pictures) -> list[str]:
    drawn = []
    shown: tuple[tuple[str, Loop | None, str], ...] = (
        ("Play: rod minus motor position", found.hysteresis.play, "Rod minus motor"),
        ("Torque at reversals", found.hysteresis.torque, "Torque without inertia"),
    )
    for title, loop, quantity in shown:
        if loop is None or len(loop.measured.x) < 2:
            continue
        sides = {
            "measured": loop.measured,
            **{key: side for key, side in (("model", loop.model), ("healthy", loop.healthy)) if side is not None},
        }
        other = "healthy" if "healthy" in sides else "model"
        kept = {key: side for key, side in sides.items() if key in ("measured", other)}
        unit = loop.unit.replace("um", "µm")
        picture = Drawing(
            f"{title}, over position", f"Position, {loop.axis_unit}", f"{quantity}, {unit}",
            ends(*(np.asarray(side.x) for side in kept.values())), ends(*(np.asarray(side.y) for side in kept.values())),
        )  # fmt: skip
        picture.line(np.asarray(kept["measured"].x), np.asarray(kept["measured"].y), "before")
        if other in kept:
            picture.line(np.asarray(kept[other].x), np.asarray(kept[other].y), "after thin")
        drawn.append(_figure(title, picture, "To and fro over the stroke.", (("before", "today"), ("after", _OTHER[other]))))
    return drawn


def _orders(name: str, unit: str, found: LinesEntry, turn: str) -> list[str]:
    """Orders, where one stands above what chance makes."""
    order, amplitude = np.asarray(found.order), np.asarray(found.amplitude)
    chance = np.asarray(found.chance)
    if not order.size or chance.size != order.size or not np.any(amplitude > 2.0 * chance):
        return []
    place = int(np.argmax(amplitude / np.maximum(chance, 1e-300)))
    said = f"Largest over chance: {order[place]:g} per {turn}, {words.number(float(amplitude[place]))} {unit}, {words.number(float(amplitude[place] / chance[place]), 2)} times what noise makes."
    picture = Drawing(
        f"Orders of the {names.block(name).lower()} equation per {turn}. {said}", f"Periods per {turn}", f"Amplitude, {unit}", ends(order), ends(amplitude, chance, zero=True)
    )  # fmt: skip
    picture.stems(order, amplitude, "before")
    picture.line(order, chance, "noise")
    return [_figure(f"{names.block(name)}: orders per {turn}", picture, said, (("before", "amplitude"), ("noise", "what noise makes")))]


def uneven(shown: Picture) -> float:
    """How differently the excess and the time are spread over the bins, by relative entropy."""
    if shown.share is None or shown.time is None:
        return 0.0
    there = (shown.share > 0.0) & (shown.time > 0.0)
    return float(np.sum(shown.share[there] * np.log(shown.share[there] / shown.time[there])))


def more(result: Diagnosed) -> list[str]:
    """The worst equation over every axis, the most uneven first."""
    worst = next(iter(telling(result)), None)
    if worst is None:
        return []
    found = sorted((one for one in result.pictures if one.share is not None and one.source == worst.name), key=uneven, reverse=True)
    return [over(one) for one in found[:_MORE_MAX]]


def over(shown: Picture, told: str = "") -> str:
    """A residual over an axis: its mean, and the band of one standard deviation."""
    line = shown.lines["excess"]
    scale, unit = 1.0, shown.unit
    if unit == "mm" and float(np.max(np.abs(line.y))) < 0.1:
        scale, unit = 1e3, "µm"
    low, high = (scale * (line.y if edge is None else edge) for edge in (line.low, line.high))
    axis_unit = shown.axis_unit.replace("um", "µm").replace("s2", "s²")
    title = f"Over {shown.by}{', against the motion' if shown.friction else ''}"
    place = int(np.argmax(np.abs(line.y)))
    said = f"largest {words.number(scale * float(line.y[place]))} {unit} at {words.number(float(line.x[place]))} {axis_unit}"
    picture = Drawing(
        f"{shown.source} {title.lower()}: {said}", f"{shown.by.capitalize()}, {axis_unit}", unit, ends(line.x), ends(low, high)
    )
    picture.band(line.x, low, high, "before")
    picture.line(line.x, scale * line.y, "before")
    caption = told or said[:1].upper() + said[1:] + "."
    return _figure(title, picture, caption)
