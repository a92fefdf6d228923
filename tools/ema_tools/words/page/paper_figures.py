"""Figures of the page of the paper's cases: the objective over the whole box of the search, and the annealer's way down."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ema_tools.results.paper import PaperResponses
from ema_tools.words.page import text as words
from ema_tools.words.page.figures import Figure
from ema_tools.words.page.results import ShownIdentification

SIZES = ("one", "two", "three")  # roles of curves in rising sizes, and of the cases [layout]
LEAST = 1e-12  # mm2 s that is drawn of an objective [layout]


def box_surface(found: PaperResponses) -> Figure:
    box = found.box
    levels = np.log10(np.maximum(box.objective_mm2s, LEAST))
    worn, healthy = found.cases[0], found.healthy
    points = [
        {
            "type": "scatter",
            "mode": "markers",
            "x": [run.csj_Nm],
            "y": [run.blk_mm],
            "name": name,
            "meta": {"role": role},
            "marker": {"symbol": symbol, "size": 13},
            "hovertemplate": f"{name}: CSJ %{{x:.4~g}} Nm, BLK %{{y:.4~g}} mm",
        }
        for run, name, role, symbol in ((healthy, "Healthy", "before", "diamond"), (worn, "Truth", "after", "circle"))
    ]
    contour: Figure = {
        "type": "contour",
        "x": np.log10(box.csj_Nm).tolist(),
        "y": box.blk_mm.tolist(),
        "z": levels.tolist(),
        "ncontours": 20,
        "meta": {"role": "candidate"},
    }
    ends = [float(np.log10(box.csj_Nm[0])), float(np.log10(box.csj_Nm[-1]))]
    layout = {
        "xaxis": {"title": {"text": "CSJ, Nm, logarithmic"}, "type": "log", "range": ends},
        "yaxis": {"title": {"text": "BLK, mm"}, "range": [float(box.blk_mm[0]), float(box.blk_mm[-1])]},
    }
    label = f"Objective over CSJ and BLK of case {box.case}: smallest at CSJ {worn.csj_Nm:g} Nm, BLK {worn.blk_mm:g} mm"
    return {"data": [contour, *points], "layout": layout, "height": 320, "label": label}


def best_so_far(shown: Sequence[ShownIdentification]) -> Figure:
    dashes = {"one": "dot", "two": "dash"}
    traces = []
    for one, role in zip(shown, SIZES, strict=False):
        assert one.search is not None
        best = np.maximum(one.search.best, LEAST)
        line = {"width": 2, "shape": "hv", **({"dash": dashes[role]} if role in dashes else {})}
        traces.append(
            {
                "type": "scatter",
                "mode": "lines",
                "x": list(range(1, best.size + 1)),
                "y": best.tolist(),
                "name": one.label,
                "meta": {"role": role},
                "line": line,
            }
        )
    layout = {
        "xaxis": {"title": {"text": "Model run"}, "rangemode": "tozero"},
        "yaxis": {"title": {"text": "E<sub>int</sub>, mm² s"}, "type": "log"},
    }
    ends = [
        f"case {one.label} {words.number(float(one.search.best[-1]))} mm2 s after {one.search.best.size} runs"
        for one in shown
        if one.search
    ]
    label = "Best objective against model run: " + "; ".join(ends)
    return {"data": traces, "layout": layout, "height": 320, "label": label}
