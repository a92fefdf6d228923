"""Numbers and sentences of the page."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ema_tools.plant.native import REASONS
from ema_tools.words.advice import advice_for_reason
from ema_tools.words.page import text as words


@pytest.mark.parametrize(
    ("value", "digits", "text"),
    [
        (0.0, 3, "0"),
        (0.674, 3, "0.674"),
        (9.999, 3, "10.0"),
        (0.0009996, 3, "0.00100"),
        (0.0009994, 3, "9.99×10⁻⁴"),
        (-2.5e-13, 2, "−2.5×10⁻¹³"),
        (999999.0, 3, "1.00×10⁶"),
        (123456.0, 3, "123456"),
        (float("nan"), 3, "not finite"),
    ],
)
def test_number(value: float, digits: int, text: str) -> None:
    assert words.number(value, digits) == text


def _read(text: str) -> float:
    """The number that a text of `words.number` stands for."""
    plain = text.translate(str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹−", "-0123456789-"))
    return float(plain.replace("×10", "e"))


@given(st.floats(min_value=1e-30, max_value=1e30), st.integers(2, 6), st.sampled_from((-1.0, 1.0)))
def test_number_keeps_its_digits(size: float, digits: int, sign: float) -> None:
    assert _read(words.number(sign * size, digits)) == pytest.approx(sign * size, rel=0.51 * 10.0 ** (1 - digits))


@pytest.mark.parametrize(
    ("before", "after", "text"),
    [
        (0.674, 0.0, "−100 %"),
        (1.0, 1e-9, "−99.9999 %"),
        (1.0, 0.00036, "−99.964 %"),
        (1.0, 0.035, "−96.5 %"),
        (1.0, 1.5, "+50.0 %"),
        (0.0, 0.0, "no error to reduce"),
    ],
)
def test_reduction(before: float, after: float, text: str) -> None:
    assert words.reduction(before, after) == text


@given(st.floats(min_value=1e-12, max_value=0.99))
def test_reduction_never_claims_too_much(left: float) -> None:
    claimed = float(words.reduction(1.0, left).removesuffix(" %").replace("−", ""))
    assert claimed <= 100.0 * (1.0 - left) + 1e-9


def test_shift_has_no_negative_zero() -> None:
    assert words.shift(-0.01) == "0.0 %"
    assert words.shift(-3.25, 2) == "−3.25 %"
    assert words.shift(117.39) == "+117.4 %"


def test_signed() -> None:
    assert words.signed(-2.174) == "−2.2"
    assert words.signed(0.00021) == "+2.1×10⁻⁴"
    assert words.signed(0.0) == "0"


def test_every_reason_has_advice() -> None:
    assert all(advice_for_reason(text) for text in REASONS.values())
    assert advice_for_reason("something else") == ""
