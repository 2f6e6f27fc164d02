"""What each kind of pair tells of an entry that moves, and what all kinds set in one that is renewed."""

from __future__ import annotations

from typing import NamedTuple

from lcpflex.contact.spatial.table import SpatialContactTable
from lcpflex.jit.kernel import kernel
from lcpflex.kinematics.spatial.rotations import Vector
from lcpflex.kinematics.spatial.vectors import NOTHING

__all__ = ["COINCIDENT", "NO_TURN", "Turning", "set_entry"]

COINCIDENT = 1e-12  # [m] two points so close have no direction from one to the other


class Turning(NamedTuple):
    """How the normal and t1 turn, and how the place of contact slides through the material of both sides."""

    ndot: Vector  # [1/s]
    spin: float  # t1dot.t2 [rad/s]
    slip: Vector  # what the sliding adds to the rate of v_i - v_j [m/s^2]
    slide_i: float  # rate of the second weight of side i [1/s], of an edge
    slide_j: float  # of side j


NO_TURN = Turning(NOTHING, 0.0, NOTHING, 0.0, 0.0)


@kernel
def set_entry(table: SpatialContactTable, k: int, gap: float, n: Vector, t: Vector) -> None:
    """Gap, normal and first tangent, world axes, of entry k."""
    table.gap[k] = gap
    for c in range(3):
        table.normal[k, c] = n[c]
        table.tangent[k, c] = t[c]
