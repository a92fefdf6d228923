"""Names on the axes of a figure: in as many lines as they need."""

from __future__ import annotations

import re
import textwrap
from html import escape, unescape

CHARACTER = 5.9  # width of a letter [layout]
LINE = 12.0  # from line to line of a name [layout]


def folded(name: str, width: float) -> str:
    """A name in as many lines as it needs; it may be parted behind an underscore."""
    most, rows = max(8, int(width / CHARACTER)), []
    for row in name.split("<br>"):
        parted = [row] if "<b>" in row else map(escape, textwrap.wrap(unescape(row).replace("_", "_ "), most))
        rows += [line.replace("_ ", "_") for line in parted]
    return "<br>".join(rows)


def lines_of(text: str, x: float, y: float, anchor: str, centred: bool = False) -> str:
    """A text of one or more lines, `<br>` between them; a line of bold words is bold. Words of names are escaped already."""
    rows, spans = text.split("<br>"), []
    y -= 0.5 * LINE * (len(rows) - 1) if centred else 0.0
    for place, row in enumerate(rows):
        bold = ' class="told"' if "<b>" in row else ""
        spans.append(f'<tspan x="{x:.1f}" y="{y + LINE * place:.1f}"{bold}>{re.sub(r"</?b>", "", row)}</tspan>')
    return f'<text text-anchor="{anchor}">{"".join(spans)}</text>'
