"""The live page as text: everything is in it, and it asks its own server alone."""

from __future__ import annotations

from html import escape
from importlib import resources

from ema_tools.words.page.legend import LegendKey, switches
from ema_tools.words.page.uplot import ABSENT, library

_KEYS = (LegendKey("measured", "measured", "measured"), LegendKey("after", "after", "model, and what it leaves"))
POLICY = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:; connect-src 'self'"


def page(actuator: str, file: str) -> str:
    """The page that follows `file` beside the model of `actuator`."""
    styles = resources.files("ema_tools.words.page") / "assets" / "sheet.css"
    own = resources.files("ema_tools.words.live") / "assets"
    loaded = library()
    draws = f"<script>{loaded.script}</script>" if loaded.there else ""
    absent = "" if loaded.there else f'<p class="absent">{escape(ABSENT)}</p>'
    return f"""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<link rel="icon" href="data:,">
<title>{escape(file)}: followed</title>
<style>
{loaded.style}
{styles.read_text(encoding="utf-8")}
{(own / "live.css").read_text(encoding="utf-8")}</style>
</head>
<body>
<a class="skip" href="#main">Skip to the answer</a>
<main id="main">
<header>
<p class="note"><span id="lamp" aria-hidden="true"></span><b>{escape(file)}</b> beside the model of {escape(actuator)} · <span id="state">waiting</span></p>
<h1 id="headline" aria-live="polite">Waiting for the first rows of {escape(file)}.</h1>
<ul id="details"></ul>
<dl class="replies" id="values"></dl>
</header>
{absent}
<div class="bar" id="shown" hidden>{switches(_KEYS, "all signals", "live")}</div>
<div class="plots" id="plots"></div>
<p class="note" id="notes">Signals are drawn as their rows come; the verdict follows a few seconds after the last of them.</p>
</main>
<noscript><p class="absent">The page follows the recording by JavaScript; the terminal says the verdict without it.</p></noscript>
{draws}
<script>
{(own / "live.js").read_text(encoding="utf-8")}</script>
</body>
</html>
"""
