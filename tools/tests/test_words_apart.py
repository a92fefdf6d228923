"""Words stand apart from computation: nothing below `words` knows a sentence or JSON, and what is shown is read from results alone."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

import ema_tools

PACKAGE = Path(ema_tools.__file__).parent
COMPUTING = ("base", "library", "plant", "data", "results", "balances", "fit", "compare", "select", "design", "tasks")


def imported(path: Path) -> Iterator[str]:
    """Modules that a file imports, at its top or in a function."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (name.name for name in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield node.module


@pytest.mark.parametrize("folder", COMPUTING)
def test_computation_knows_no_words(folder: str) -> None:
    paths = sorted((PACKAGE / folder).rglob("*.py"))
    assert paths
    for path in paths:
        assert not [name for name in imported(path) if name.startswith(("ema_tools.words", "ema_tools.cli", "rich", "matplotlib"))], path


@pytest.mark.parametrize("folder", ["terminal", "page"])
def test_what_is_shown_is_read_from_results(folder: str) -> None:
    for path in sorted((PACKAGE / "words" / folder).rglob("*.py")):
        forbidden = ("ema_tools.tasks", "ema_tools.design", "ema_tools.words.answers")
        assert not [name for name in imported(path) if name.startswith(forbidden)], path


@pytest.mark.parametrize("folder", COMPUTING)
def test_computation_makes_no_sentences_and_no_json(folder: str) -> None:
    for path in sorted((PACKAGE / folder).rglob("*.py")):
        named = [node.name for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))) if isinstance(node, ast.FunctionDef)]
        assert not {"result", "sentence", "next_step"} & set(named), path
