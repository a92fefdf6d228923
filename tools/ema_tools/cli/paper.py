"""`ema demo --paper`: the paper's cases alone, on a page with the responses and surfaces that a paper of this kind shows."""

from __future__ import annotations

from pathlib import Path

from rich.console import Console
from rich.text import Text

from ema_tools.base.files import write_text
from ema_tools.cli.demo import shipped_cases, tell_cases
from ema_tools.data.actuator import reference_actuator
from ema_tools.tasks.paper import paper_responses
from ema_tools.words.page.paper_page import paper_page

PAGE = "paper.html"
COMMAND = "ema demo --paper"


def written(folder: Path) -> list[Path]:
    """What is written to `folder`: the results of the cases, and the page."""
    return [*(folder / f"{path.stem}.json" for _, path in shipped_cases(noisy=False)), folder / PAGE]


def run(output: Console, folder: Path) -> Path:
    """Search the paper's cases, print them beside the paper's numbers, and write results and page to `folder`. Raises InputError when a recording is absent."""
    results = tell_cases(output, folder, shipped_cases(noisy=False))
    page = folder / PAGE
    write_text(page, paper_page(paper_responses(reference_actuator()), results, COMMAND), True)
    output.print(Text(f"The page with curves, surfaces and the paper's numbers: {page}"))
    return page
