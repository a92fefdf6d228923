"""What the Python package ships and needs, without building it: the packages workflow builds the wheel and lists its files."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable

import pytest

from support import ROOT

SETTINGS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
LOCKS = {
    "run": "tools/requirements.txt",
    "fleet": "tools/requirements-fleet.txt",
    "check": "tools/requirements-check.txt",
    "test": "tools/requirements-test.txt",
    "benchmarks": "benchmarks/requirements.txt",
}


def names(requirements: Iterable[str]) -> set[str]:
    """The packages of requirements, in lower case and with hyphens."""
    return {match[0].lower().replace("_", "-") for line in requirements if (match := re.match(r"[A-Za-z][\w.-]*", line))}


def locked(kind: str) -> set[str]:
    """The packages of a lock."""
    return names((ROOT / LOCKS[kind]).read_text(encoding="utf-8").splitlines())


def test_the_wheel_takes_the_package_without_its_workshop() -> None:
    assert SETTINGS["tool"]["scikit-build"]["wheel"]["packages"] == ["tools/ema_tools"]
    folders = {path.name for path in (ROOT / "tools" / "ema_tools").rglob("*") if path.is_dir()}
    assert "tasks" in folders
    assert folders.isdisjoint({"benchmarks", "truth", "reference", "reference_model", "vectors", "tests"})


@pytest.mark.parametrize("kind", ["fleet", "test", "benchmarks"])
def test_what_the_tools_do_not_need_is_in_no_base_lock(kind: str) -> None:
    assert locked(kind)
    assert locked("run").isdisjoint(locked(kind))


@pytest.mark.parametrize("kind", ["run", "fleet", "check", "test"])
def test_locks_hold_what_the_package_asks_for(kind: str) -> None:
    project = SETTINGS["project"]
    asked = names(project["dependencies"] if kind == "run" else project["optional-dependencies"][kind])
    assert asked
    assert asked <= locked(kind)
