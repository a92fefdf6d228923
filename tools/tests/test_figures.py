"""Figures of the page as SVG: marks stand where their numbers are, over each kind of axis, and say them."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from typing import Any

import numpy as np
import pytest

from ema_tools.words.page.figure_svg import figure_svg


def trace(x: list[Any], y: list[Any], **changes: Any) -> dict[str, Any]:
    return {
        "type": "scatter",
        "mode": "markers",
        "x": x,
        "y": y,
        "meta": {"role": "after"},
        "marker": {"size": 8},
        "name": "one",
        **changes,
    }


def drawn(*traces: dict[str, Any], **layout: Any) -> ElementTree.Element:
    return ElementTree.fromstring(figure_svg({"data": list(traces), "layout": layout, "height": 300, "label": "a < b"}, "f"))


def circles(found: ElementTree.Element) -> list[tuple[float, float]]:
    return [(float(one.attrib["cx"]), float(one.attrib["cy"])) for one in found.iter("circle")]


def test_marks_stand_where_their_numbers_are() -> None:
    (a, top), (b, middle), (c, low) = circles(drawn(trace([1.0, 2.0, 4.0], [10.0, 5.0, 0.0])))
    assert (c - a) / (b - a) == pytest.approx(3.0, rel=0.01) and low - middle == pytest.approx(middle - top, abs=0.11)
    (a, _), (b, _), (c, _) = circles(drawn(trace([1.0, 10.0, 1000.0], [0.0, 0.0, 1.0]), xaxis={"type": "log"}))
    assert (c - a) / (b - a) == pytest.approx(3.0, rel=0.01)
    # names: the first of the order is the lowest
    first, second = circles(drawn(trace([1.0, 2.0], ["top", "low"]), yaxis={"categoryarray": ["low", "top"]}))
    assert first[1] < second[1]


def test_marks_say_their_numbers_and_texts_cannot_break_out() -> None:
    found = drawn(trace([0.123456], [2.0], hovertemplate="<b>x</b> %{x:.3~g} Nm: %{y:.1f}<extra></extra>"))
    assert [one.text for one in found.iter("title")] == [" x  0.123 Nm: 2.0"]
    assert found.attrib["aria-label"] == "a < b"


def test_lines_break_and_step_and_bands_lie_between() -> None:
    line = trace([0.0, 1.0, None, 2.0, 3.0], [0.0, 1.0, None, 1.0, 0.0], mode="lines")
    assert [len(one.attrib["points"].split()) for one in drawn(line).iter("polyline")] == [2, 2]
    steps = trace([0.0, 1.0, 2.0], [0.0, 1.0, 2.0], mode="lines", line={"shape": "hv", "width": 2})
    assert [len(one.attrib["points"].split()) for one in drawn(steps).iter("polyline")] == [5]
    edge = {"mode": "lines", "line": {"width": 0}}
    between = drawn(trace([0.0, 1.0], [0.0, 0.0], **edge), trace([0.0, 1.0], [1.0, 1.0], fill="tonexty", **edge))
    assert [len(one.attrib["points"].split()) for one in between.iter("polygon")] == [4] and not list(between.iter("polyline"))


def test_long_names_are_parted_and_stay_text() -> None:
    names = ["first model<br><b>48.1</b>", "+ a_very_long_name_of_an_effect &lt;b&gt; &amp; more", *(f"+ {one}" for one in "abcdef")]
    found = drawn(trace(names, [float(place) for place in range(8)], type="bar"))
    said = ["".join(one.itertext()).replace(" ", "") for one in found.iter("text")]
    assert "firstmodel48.1" in said and "+a_very_long_name_of_an_effect<b>&more" in said


def test_bars_and_bars_of_error_reach_as_far_as_they_say() -> None:
    bars = list(
        drawn({"type": "bar", "x": ["a", "b"], "y": [1.0, 2.0], "base": [0.0, 0.0], "meta": {"role": "after"}, "name": "left"}).iter("rect")
    )
    heights = [float(one.attrib["height"]) for one in bars if "clip" not in one.attrib.get("id", "") and len(one)]
    assert heights[1] == pytest.approx(2.0 * heights[0], abs=0.2)
    wide = drawn(trace([1.0, 2.0], [0.0, 1.0], error_x={"array": [0.5, 0.0], "arrayminus": [1.0, 0.0], "thickness": 2}))
    (path,) = [one.attrib["d"] for one in wide.iter("path")]
    first = path.split("M")[1]
    left, right = float(first.split(" ")[0]), float(first.split("H")[1])
    assert left < circles(wide)[0][0] < right


def test_a_contour_is_dark_where_its_quantity_is_small() -> None:
    x, y = np.linspace(0.0, 1.0, 7), np.linspace(0.0, 1.0, 5)
    levels = (x[None, :] - 0.5) ** 2 + (y[:, None] - 0.5) ** 2
    contour = {"type": "contour", "x": x.tolist(), "y": y.tolist(), "z": levels.tolist(), "ncontours": 6, "meta": {"role": "candidate"}}
    found = drawn(contour, xaxis={"range": [0.0, 1.0]}, yaxis={"range": [0.0, 1.0]})
    steps = next(one for one in found.iter("g") if "steps" in one.attrib["class"])
    shades = [float(one.attrib["fill-opacity"]) for one in steps]
    darkest = [one.attrib["d"] for one in steps if float(one.attrib["fill-opacity"]) == max(shades)]
    middle = 0.5 * (float(darkest[0].split("M")[1].split(" ")[0]) + float(darkest[0].split("H")[1].split("V")[0]))
    (rect,) = list(found.iter("rect"))
    assert len(set(shades)) == 6 and middle == pytest.approx(float(rect.attrib["x"]) + 0.5 * float(rect.attrib["width"]), abs=3.0)
