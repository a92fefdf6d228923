"""Settings of all tests."""

from __future__ import annotations

import os

# As the commands do it: two workers on two cores, each with threads inside its small matrix products, wait for each other. Read when NumPy is imported.
for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

import pytest
from hypothesis import settings

from demo_run import forget_demo_run

# An example that takes long is a busy machine, not a defect.
# the same examples everywhere: what fails for one fails for all
settings.register_profile("ema", deadline=None, derandomize=True)
settings.load_profile("ema")


def pytest_unconfigure(config: pytest.Config) -> None:
    """The run of the demo that all tests share goes with the process that leads them."""
    if "PYTEST_XDIST_WORKER" not in os.environ:
        forget_demo_run()
