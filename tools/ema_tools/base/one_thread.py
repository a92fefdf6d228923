"""One thread inside each matrix product: the cores work on simulations, and threads of a small product would only wait for each other."""

from __future__ import annotations

import os

# What numerical libraries read when they are loaded: to be set before NumPy is imported, and in what a process is given that it starts.
ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}


def one_thread_unless_told() -> None:
    """For this process and those that it starts, where its user has not said otherwise."""
    for name, count in ONE_THREAD.items():
        os.environ.setdefault(name, count)
