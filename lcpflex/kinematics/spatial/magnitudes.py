"""How large the coordinates of a spatial configuration are, for relative tolerances."""

from __future__ import annotations

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.model.spatial import N_PLACE, N_RIGID, SpatialModel

__all__ = ["magnitudes"]

RADIAN = 1.0  # of rotations, which have no size of their own


@kernel
def magnitudes(model: SpatialModel, q: FloatArray, out: FloatArray) -> None:
    """out (nu,): what changes of q are small against: |R|, 1 rad, |eta|."""
    bodies = model.bodies
    for b in range(len(bodies.mass)):
        p, d = bodies.place[b], bodies.dof[b]
        for i in range(3):
            out[d + i] = abs(q[p + i])
            out[d + 3 + i] = RADIAN
        for k in range(bodies.dof[b + 1] - d - N_RIGID):
            out[d + N_RIGID + k] = abs(q[p + N_PLACE + k])
