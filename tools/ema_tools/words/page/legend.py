"""The legend of a picture in which each series is switched by its key: a box to tick, so that mouse, keyboard and screen reader have the same."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape


@dataclass(frozen=True)
class LegendKey:
    """One series: what the style sheet hides and shows with it, the look of its key, and what it is called."""

    series: str
    look: str
    title: str


def switches(keys: Sequence[LegendKey], of: str, scope: str = "") -> str:
    """Markup of all keys. `of`: whose curves these are, read aloud; `scope`: the plots of a script that they switch, none where the style sheet does it."""
    where = f' data-of="{scope}"' if scope else ""
    shown = "".join(
        f'<label><input type="checkbox" data-show="{escape(one.series)}"{where} checked><span class="key {one.look}"></span>{escape(one.title)}</label>'
        for one in keys
    )
    return f'<fieldset class="toggles"><legend class="spoken">Curves shown: {escape(of)}</legend>{shown}</fieldset>'
