"""Settings of all tests."""

from __future__ import annotations

import math
import os
import time
from pathlib import Path

from ema_tools.base.one_thread import one_thread_unless_told

# As the commands do it, and as early.
one_thread_unless_told()

import pytest
from hypothesis import settings

# An example that takes long is a busy machine, not a defect.
# the same examples everywhere: what fails for one fails for all
settings.register_profile("ema", deadline=None, derandomize=True)
settings.load_profile("ema")


BEGAN_S = time.monotonic()
# `.ci/run` begins no long test after this time; every other run has no such limit.
BEGIN_WITHIN_S = float(os.environ.get("EMA_TESTS_BEGIN_WITHIN_S", "inf"))

# Files that take longest begin, so that no worker waits for the last of them. What shares a compiled model or a run of the demo stands together: a worker's own part is in one piece.
FIRST = (
    *("test_reference", "test_vectors", "test_forms"),
    *("test_walk_through", "test_demo", "test_readme"),
    *("test_add_an_effect", "test_own_effect"),
    *("test_late_drive", "test_value_changes", "test_cli_diagnose", "test_any_machine", "test_fleet", "test_hidden", "test_cross_check"),
    *("test_guard", "test_without_controller", "test_diagnosis", "test_shared_noise", "test_strategies", "test_faults", "test_wear"),
)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """The order of the files; within one it stays. With a limit of time it is that of the command line."""
    if not math.isinf(BEGIN_WITHIN_S):
        return
    place = {name: number for number, name in enumerate(FIRST)}
    items.sort(key=lambda item: place.get(Path(item.path).stem, len(FIRST)))


def pytest_runtest_setup() -> None:
    """Skips a test that would begin too late."""
    if time.monotonic() - BEGAN_S > BEGIN_WITHIN_S:
        pytest.skip("the time for long tests is used up: `.ci/run --all` runs all of them")
