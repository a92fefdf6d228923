"""The stored records of the truth plant are those of their list, small, and what the plant gives today."""

from __future__ import annotations

import json

import numpy as np
import pytest

from ema_tools.base.compiled import HAS_NUMBA
from stored_records import FOLDER, MADE, MANIFEST, columns_of, digests


def test_files_are_those_of_the_list_and_small() -> None:
    assert json.loads(MANIFEST.read_text(encoding="utf-8")) == digests()
    assert set(digests()) == {f"{name}.npz" for name in MADE}
    assert max(path.stat().st_size for path in FOLDER.iterdir()) < 1 << 20


@pytest.mark.slow
@pytest.mark.skipif(not HAS_NUMBA, reason="the truth plant takes minutes a record without Numba")
@pytest.mark.parametrize("name", MADE)
def test_the_truth_plant_gives_them_today(name: str) -> None:
    """Bit by bit; stored_records.py says how they are written anew."""
    made, kept = MADE[name](), columns_of(name)
    assert list(made) == list(kept) and all(np.array_equal(made[column], kept[column]) for column in made)
