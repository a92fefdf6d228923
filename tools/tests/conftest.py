"""Settings of all tests."""

from __future__ import annotations

from hypothesis import settings

# An example that takes long is a busy machine, not a defect.
settings.register_profile("ema", deadline=None)
settings.load_profile("ema")
