"""The page of one result as a sheet: a sentence and five answers on its first screen, and sections that a menu leads to. One file that opens from disk and asks nothing of any network."""

from __future__ import annotations

import itertools
import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from importlib import resources
from typing import Any

from ema_tools.words.advice import Advice
from ema_tools.words.page import workbench
from ema_tools.words.page.uplot import library

_POLICY = "default-src 'none'; {scripts}; style-src 'unsafe-inline'; img-src data:"
_SCRIPTS = "script-src 'unsafe-inline'"
# A head that begins with this stands over words, not over numbers.
_LEFT = "<"
_WORDS = ' class="words"'
# Of every page; further ones a page names itself.
_STYLES = ("sheet.css", "gauges.css", "charts.css")
_SCRIPTS_OF_ALL = ("sheet.js",)


@dataclass(frozen=True)
class Reply:
    """One of the five answers. `tone`: good, bad, unsure or nothing; `command` to copy and `link`, the section that says more, where there is one."""

    question: str
    short: str
    more: str
    tone: str = ""
    command: str = ""
    link: str = ""


@dataclass(frozen=True)
class FirstScreen:
    """The sentence and the answers, in their order; `tiles`: whether the answers are of as many things, and not five to one."""

    sentence: str
    replies: tuple[Reply, ...]
    tiles: bool = False


@dataclass(frozen=True)
class Chapter:
    """One section of the sheet; one without markup is left out. `listed`: whether the menu has it."""

    identity: str
    title: str
    html: str
    listed: bool = True


def next_reply(advice: Advice) -> Reply:
    """The answer to what to do next."""
    return Reply("What next?", advice.short, advice.more, advice.tone, advice.command)


def document(
    name: str,
    first: FirstScreen,
    beside: str,
    chapters: Sequence[Chapter],
    data: Mapping[str, Any],
    computes: bool,
    styles: Sequence[str] = (),
    scripts: Sequence[str] = (),
) -> str:
    """The whole file. `beside`: markup between the answers and the sections; `data`: what the scripts draw; `computes`: whether a workbench stands in it; `styles`, `scripts`: files of the
    page's own beside those of every page."""
    assets = resources.files("ema_tools.words.page") / "assets"
    style = "\n".join((assets / one).read_text(encoding="utf-8") for one in (*_STYLES, *styles))
    script = "\n".join((assets / one).read_text(encoding="utf-8") for one in (*_SCRIPTS_OF_ALL, *scripts))
    loaded = library()
    there = [one for one in chapters if one.html]
    menu = "".join(f'<li><a href="#{one.identity}">{escape(one.title)}</a></li>' for one in there if one.listed)
    body = "".join(
        f'<section id="{one.identity}" aria-labelledby="{one.identity}-title"><h2 id="{one.identity}-title">{escape(one.title)}</h2>{one.html}</section>'
        for one in there
    )
    draws = f"<script>{loaded.script}</script>" if loaded.there else ""
    # `<` would let a text in the data end the script element.
    shown = json.dumps(data, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    return f"""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="{_POLICY.format(scripts=workbench.POLICY if computes else _SCRIPTS)}">
<meta name="color-scheme" content="light dark">
<link rel="icon" href="data:,">
<title>{escape(name)}: {escape(first.sentence)}</title>
<style>
{loaded.style}
{style}</style>
</head>
<body>
<a class="skip" href="#main">Skip to the answer</a>
<nav aria-label="Sections"><span class="name">{escape(name)}</span><ul>{menu}</ul></nav>
<main id="main">
<header>
<h1>{kept(first.sentence)}</h1>
{replies(first)}
{beside}</header>
{body}
</main>
<noscript><p class="absent">The curves need JavaScript; sentences, maps and tables do not.</p></noscript>
<script id="page-data" type="application/json">{shown}</script>
{draws}
<script>
{script}</script>
</body>
</html>
"""


def kept(text: str) -> str:
    """Escaped text in which a number stays on one line with its unit, and the ends of an interval stand as on a page."""
    return escape(re.sub(r"(?<=\d) (?=%|mm|Nm|µm|s\b)|(?<=mm²) (?=s\b)", "\u00a0", re.sub(r"(?<=\d) \.\. (?=[-\d])", " … ", text)))


def replies(first: FirstScreen, identity: str = "command") -> str:
    """The answers as they stand on a page; `identity`: of the command among all of the page."""
    kind = "tiles" if first.tiles else "answers"
    return f'<dl class="replies {kind}">{"".join(_reply(one, identity) for one in first.replies)}</dl>'


def _reply(one: Reply, identity: str) -> str:
    copied = ""
    if one.command:
        # a line ends between words of the command, not at the dash of an option; of a folder three dots are seen, and all of it is copied
        parts = " ".join(f"<span>{_folded(part)}</span>" for part in one.command.split(" "))
        copied = (
            f'<div class="copy"><code id="{identity}" tabindex="0">{parts}</code>'
            f'<button type="button" data-copy="{identity}">copy<span class="spoken"> the next command</span></button></div>'
        )
    more = f"<small>{kept(one.more)}</small>" if one.more else ""
    question = f'<a href="#{one.link}">{escape(one.question)}</a>' if one.link else escape(one.question)
    return f'<div class="reply {one.tone}"><dt>{question}</dt><dd><b>{kept(one.short)}</b>{more}{copied}</dd></div>'


def _folded(part: str) -> str:
    """A word of a command, the folder of a path apart."""
    folder, slash, name = part.rpartition("/")
    return f'<span class="folder">{escape(folder + slash)}</span>{escape(name)}' if folder else escape(part)


def table(label: str, caption: str, heads: tuple[str, ...], rows: Sequence[str]) -> str:
    """Rows of markup under heads, of which one that begins with `<` stands over words; on a narrow page each cell has its head beside it."""
    titles = [head.removeprefix(_LEFT) for head in heads[1:]]

    def titled(row: str) -> str:
        left = itertools.chain(titles, itertools.repeat(""))
        return re.sub(r"<td\b", lambda _: f'<td data-head="{next(left)}"', row)

    shown = "".join(f'<th scope="col"{_WORDS if head.startswith(_LEFT) else ""}>{head.removeprefix(_LEFT)}</th>' for head in heads)
    return (
        f'<div class="scroll" role="region" aria-label="Table: {label}" tabindex="0"><table class="plain"><caption>{caption}</caption>'
        f"<thead><tr>{shown}</tr></thead><tbody>{''.join(map(titled, rows))}</tbody></table></div>"
    )


def origin(command: str, provenance: Mapping[str, str]) -> str:
    """What made the page and its result; `command` made the page."""
    told = "".join(
        f"<dt>{escape(key)}</dt><dd>{f'<code>{escape(value)}</code>' if key in ('page', 'command') else escape(value)}</dd>"
        for key, value in {"page": command, **provenance}.items()
    )
    return f'<dl class="origin">{told}</dl>'
