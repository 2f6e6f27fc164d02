"""What a displacement moves, in words."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from lcpflex.jit.kernel import FloatArray
from lcpflex.model.planar import N_RIGID
from lcpflex.statics.scales import Scales

__all__ = ["what_moves"]

NAMED = 3  # bodies
LESS = 0.1  # of the largest displacement: bodies that move less are not named, parts of a motion neither


def what_moves(bodies: Sequence[str], dof: Sequence[int], scales: Scales, q: FloatArray, dq: FloatArray) -> str:
    """The bodies that dq (ndof,) moves most at q, each with its way: along a direction, about a point, bending."""
    moved = np.abs(scales.arm * dq)
    parts = [moved[dof[b] : dof[b + 1]] for b in range(len(bodies))]
    most = np.array([part.max() for part in parts])
    order = [int(b) for b in np.argsort(-most, kind="stable") if most[b] > LESS * most.max(initial=0.0)]
    said = []
    for b in order[:NAMED]:
        own = slice(int(dof[b]), int(dof[b + 1]))
        said.append(f"{bodies[b]!r} {_way(q[own], dq[own], parts[b])}")
    if len(order) > NAMED:
        said.append(f"{len(order) - NAMED} more")
    return " and ".join(said)


def _way(q: FloatArray, dq: FloatArray, moved: FloatArray) -> str:
    """How one body moves."""
    x, y, turn = (float(value) for value in dq[:N_RIGID])
    along, turned = math.hypot(x, y), float(moved[2])
    bent = float(moved[N_RIGID:].max(initial=0.0))
    if bent > max(along, turned):
        return "bends"
    if turned <= LESS * along:
        return f"moves along ({_rounded(x / along)}, {_rounded(y / along)})"
    sense = "counter-clockwise" if turn > 0.0 else "clockwise"
    center = q[0] - y / turn, q[1] + x / turn
    return f"turns {sense} about ({center[0]:.3g}, {center[1]:.3g}) m"


def _rounded(value: float) -> str:
    """Two digits, without a minus before 0."""
    return f"{round(value, 2) + 0.0:g}"
