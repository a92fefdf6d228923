"""An orthonormal basis of a few long columns, several times as fast as Householder's way through them.

Cholesky's factors of the products, twice: the first leaves what the condition of the columns spoils, the second mends it to rounding (T. Fukaya, Y. Nakatsukasa, Y. Yanagisawa,
Y. Yamamoto, "CholeskyQR2", Workshop on Latest Advances in Scalable Algorithms for Large-Scale Systems, 2014). Columns too much alike for that go Householder's way.
"""

from __future__ import annotations

import numpy as np

from ema_tools.base.arrays import Reals


def orthonormal(columns: Reals) -> tuple[Reals, Reals]:
    """A basis [n, k], each column contiguous, and the square [k, k] with which it makes the `columns` [n, k]; fastest where these are contiguous, too."""
    rows = columns.T
    products = rows @ rows.T
    lengths = np.sqrt(np.diag(products))
    if not np.all(lengths > 0.0):
        return _householder(columns)
    try:
        # the factor of columns of length one is the better conditioned
        first = np.linalg.cholesky(products / lengths / lengths[:, None]).T * lengths
        basis = np.linalg.inv(first).T @ rows
        second = np.linalg.cholesky(basis @ basis.T).T
    except np.linalg.LinAlgError:
        return _householder(columns)
    return (np.linalg.inv(second).T @ basis).T, second @ first


def _householder(columns: Reals) -> tuple[Reals, Reals]:
    basis, square = np.linalg.qr(columns)
    return np.asfortranarray(basis), square
