"""What a healthy answer may not hide is the same at the desk and on the target: two sources, one number each."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from ema_tools.tasks import identify

VERDICT = Path(__file__).parents[2] / "src" / "session" / "ema_verdict.c"


@pytest.mark.parametrize(("onboard", "desk"), [("EMA_HIDES_NONE", "_HIDES_NONE"), ("EMA_SURELY_LESS", "_SURELY_LESS")])
def test_the_same_numbers_decide(onboard: str, desk: str) -> None:
    found = re.search(rf"#define {onboard} EMA_R\(([0-9.]+)\)", VERDICT.read_text(encoding="utf-8"))
    assert found is not None, f"{onboard} is no longer in {VERDICT.name}: say here where the flight code has it"
    assert float(found[1]) == getattr(identify, desk)
