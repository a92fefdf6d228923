"""Types of arrays, by what is in them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Bools = NDArray[np.bool_]
Reals = NDArray[np.float64]
Complexes = NDArray[np.complex128]
Integers = NDArray[np.int32]
Flags = NDArray[np.bool_]
