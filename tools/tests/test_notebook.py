"""The notebook runs as it stands, and its cells say what the commands say."""

from __future__ import annotations

import ast
import contextlib
import io
import json
import os

import pytest

from ema_tools.words.page.pictures import NotebookPicture
from support import ROOT

NOTEBOOK = ROOT / "examples" / "notebook" / "hidden_effect.ipynb"


@pytest.mark.slow
def test_the_notebook_tells_the_story() -> None:
    """Cell by cell in plain Python, in the notebook's own folder, the last expression kept as Jupyter would show it."""
    cells = [cell for cell in json.loads(NOTEBOOK.read_text(encoding="utf-8"))["cells"] if cell["cell_type"] == "code"]
    assert all(cell["outputs"] == [] for cell in cells)
    assert sum(len(cell["source"]) for cell in cells) <= 24
    names: dict[str, object] = {}
    printed = io.StringIO()
    shown: list[object] = []
    before = os.getcwd()
    os.chdir(NOTEBOOK.parent)
    try:
        with contextlib.redirect_stdout(printed):
            for cell in cells:
                tree = ast.parse("".join(cell["source"]))
                last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
                exec(compile(tree, NOTEBOOK.name, "exec"), names)
                if last is not None:
                    shown.append(eval(compile(ast.Expression(last.value), NOTEBOOK.name, "eval"), names))
    finally:
        os.chdir(before)
    said = printed.getvalue()
    assert "in the mechanical balance" in said
    assert "missing is Stribeck friction (stribeck_friction; rise" in said
    assert said.rstrip().splitlines()[-1].startswith("Fault: CSJ +")
    (picture,) = [one for one in shown if isinstance(one, NotebookPicture)]
    assert "+ csj and blk and stribeck_friction" in picture._repr_svg_()
