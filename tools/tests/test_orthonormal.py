"""The basis of long columns: orthonormal to rounding and makes the columns again, however alike or unequal they are."""

from __future__ import annotations

import numpy as np
import pytest

from ema_tools.base.orthonormal import orthonormal


@pytest.mark.parametrize("count", [0, 1, 12])
@pytest.mark.parametrize("alike", [1.0, 1e-6, 1e-12, 0.0])
def test_basis_is_orthonormal_and_makes_the_columns(count: int, alike: float) -> None:
    random = np.random.default_rng(count)
    columns = random.normal(size=(4000, count)) * 10.0 ** random.uniform(-3, 3, count)
    if count > 2:
        columns[:, 2] = columns[:, 1] + alike * columns[:, 2]
        columns[:, 5] *= alike
    basis, square = orthonormal(columns)
    assert basis.flags.f_contiguous or count < 2
    # both ways are good to some units in the last place of the largest product
    assert basis.T @ basis == pytest.approx(np.eye(count), abs=1e-13)
    assert np.all(np.abs(basis @ square - columns) <= 1e-12 * np.max(np.abs(columns), initial=0.0))
