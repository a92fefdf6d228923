"""Several curves over one time, drawn by the page's script: what it is told, and the markup that they are drawn into."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

from ema_tools.base.arrays import Reals
from ema_tools.words.page.curves import packed
from ema_tools.words.page.legend import LegendKey, switches

_DASHES: dict[str, list[int]] = {"one": [2, 3], "two": [7, 4]}


@dataclass(frozen=True)
class NamedCurve:
    """One curve [rows]; its role gives colour and stroke."""

    label: str
    role: str
    values: Reals


@dataclass(frozen=True)
class LineChart:
    """Curves of one unit, from time 0 in steps of `period_s`; those of a `group` are zoomed together, and begin with the `view`, s."""

    identity: str
    title: str
    unit: str
    group: str
    period_s: float
    curves: Sequence[NamedCurve]
    view: tuple[float, float] | None = None

    def data(self) -> dict[str, Any]:
        """For the script."""
        series = [
            {
                "label": one.label,
                "role": one.role,
                "packed": packed(one.values),
                **({"dash": _DASHES[one.role]} if one.role in _DASHES else {}),
            }
            for one in self.curves
        ]
        view = {"view": self.view} if self.view else {}
        return {
            "id": self.identity,
            "group": self.group,
            "unit": self.unit,
            "period_s": self.period_s,
            "rows": int(self.curves[0].values.size),
            "series": series,
            **view,
        }

    def markup(self, caption: str = "") -> str:
        """A figure with its legend, by which its curves are switched; `caption` is text."""
        keys = switches([LegendKey(one.label, one.role, one.label) for one in self.curves], self.title, self.identity)
        names = ", ".join(one.label for one in self.curves)
        told = f"<figcaption>{escape(caption)}</figcaption>" if caption else ""
        return (
            f'<figure><div class="figure-head"><h3>{escape(self.title)}, {escape(self.unit)}</h3>{keys}</div>'
            f'<div class="lines" id="{self.identity}" role="img" aria-label="{escape(f"{self.title} over time: {names}")}"></div><div class="values"></div>{told}</figure>'
        )
