"""Records of one machine that fall into two groups: days scatter evenly, and one that is not healthy lies far from the others."""

from __future__ import annotations

import numpy as np
from scipy.sparse.csgraph import minimum_spanning_tree

from ema_tools.base.arrays import Reals

FRICTION_OF_DAYS = (
    0.18  # how far dry friction of one machine may lie apart on two days, relative: beyond, one record is of another state [judgement]
)
_GAP = 2.0  # the widest gap over the next, from which on records are two groups [judgement]


def two_groups(between: Reals, usual: float) -> tuple[tuple[int, ...], float] | None:
    """The smaller of two groups, and the gap, where the distances [records, records] have one that is wider than `usual` and far wider than the next."""
    tree = minimum_spanning_tree(between).toarray()
    edges = np.sort(tree[tree > 0.0])
    if not edges.size or edges[-1] <= max(usual, _GAP * (edges[-2] if edges.size > 1 else 0.0)):
        return None
    joined = (tree > 0.0) & (tree < edges[-1])
    group = {0}
    while more := {k for at in group for k in np.flatnonzero(joined[at] | joined[:, at]).tolist()} - group:
        group |= more
    other = set(range(len(between))) - group
    smaller = min((group, other), key=lambda one: (len(one), 0 in one))
    return tuple(sorted(smaller)), float(edges[-1])
