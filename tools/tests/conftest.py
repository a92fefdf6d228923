"""Settings of all tests."""

from __future__ import annotations

from hypothesis import settings

# An example that takes long is a busy machine, not a defect.
# the same examples everywhere: what fails for one fails for all
settings.register_profile("ema", deadline=None, derandomize=True)
settings.load_profile("ema")
