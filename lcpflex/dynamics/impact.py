"""Stronge's law of impact, integrated over the normal impulse.

Sources: Pfeiffer & Glocker 1996; Stronge 1990.
"""

from __future__ import annotations

import math

from lcpflex.dynamics.delassus import joint_impulses
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import FloatArray, kernel

__all__ = ["SEGMENTS", "energetic_segments", "lay_impulse"]

SEGMENTS = 8  # slip, stick or slip back; compression, restitution: at most four in all


@kernel
def energetic_segments(
    gnn: float, gnt: float, gtt: float, v_n: float, v_t: float, mu: float, e: float, segments: FloatArray
) -> int:
    """Impulses of one contact by Stronge's law, phase by phase.

    gnn, gnt, gtt: Delassus operator of the contact; v_n <= 0 and v_t: its velocities [m/s]. Out: segments (SEGMENTS, 2)
    normal and tangential impulse [N s] of each phase of constant rates. Returns their number; -1 if compression does
    not end (G is not positive definite).
    """
    taken = 0.0  # work of the normal impulse since the present of its two phases began
    due = 0.0  # what restitution has to give back
    restitution = False
    slip = 0.0
    if mu > 0.0 and v_t != 0.0:
        slip = 1.0 if v_t > 0.0 else -1.0
    for count in range(SEGMENTS):
        ratio = -mu * slip
        if slip == 0.0 and mu > 0.0:
            if abs(gnt) <= mu * gtt:
                ratio = -gnt / gtt
            else:
                slip = 1.0 if gnt > 0.0 else -1.0
                ratio = -mu * slip
        rate_n = gnn + ratio * gnt
        rate_t = gnt + ratio * gtt
        stop = math.inf
        if slip * rate_t < 0.0:
            stop = max(-v_t / rate_t, 0.0)
        end = math.inf
        if restitution:
            rest = max(due - taken, 0.0)
            end = 2.0 * rest / (v_n + math.sqrt(v_n * v_n + 2.0 * rate_n * rest)) if rest > 0.0 else 0.0
        elif rate_n > 0.0:
            end = -v_n / rate_n
        p = min(stop, end)
        if not p < math.inf:
            return -1
        segments[count, 0] = p
        segments[count, 1] = ratio * p
        taken += (v_n + 0.5 * rate_n * p) * p
        v_n += rate_n * p
        v_t += rate_t * p
        if stop <= end:
            v_t = 0.0
            slip = 0.0
        if end <= stop:
            if restitution:
                return count + 1
            restitution = True
            v_n = 0.0
            due = -e * e * taken
            taken = 0.0
    return -1


@kernel
def lay_impulse(work: Workspace, normal: float, tangential: float) -> None:
    """Impulses ``work.p`` of all rows, of which those of a single contact are given; joints answer them."""
    n_joint = work.n_joint
    total = n_joint + 1 + work.n_tangents
    work.p[n_joint] = normal
    if work.n_tangents > 0:
        work.p[n_joint + 1] = tangential
    joint_impulses(work.free, n_joint, total, work.lower, work.share, work.p)
    for r in range(n_joint):
        work.free[r] = 0.0  # met by the first of several phases
