"""Memory of the solver of large contact problems in space; all of it is linear in contacts but for the sparse factor.

What such a problem is made of is a :class:`~lcpflex.solvers.contact.large.memory.BodyContacts` as in the plane, with
two tangential rows a contact, one behind the other.
"""

from __future__ import annotations

from typing import Any, TypeAlias

from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.jit.struct import allocate, array, copy_parts, struct
from lcpflex.solvers.contact.large.memory import STARTING, SparseFactor

__all__ = ["FRICTIONAL", "JOINT_ROWS", "NORMAL", "LargeCones", "SpatialLargeMemory", "large_cones"]

NORMAL, FRICTIONAL, JOINT_ROWS = 0, 1, 2  # kinds of units: contacts, and up to three joint rows of the same bodies


@struct
class SpatialLargeMemory:
    """Answer and work memory; units are the contacts of the problem in their order, then its joint rows."""

    # what the user may set
    tolerance: float  # of the residual
    factor_limit: int  # sparse factors at most
    operation_limit: float  # of all factors, in multiplications
    # what is known of the answer
    residual: float  # relative to the terms
    strict: float  # relative to the free velocity alone
    factors: int
    allowed: int  # factors that the limits come to
    sweeps: int
    route: int  # how the answer was found, see lcpflex.solvers.contact.cones.large.solving
    # the problem in units
    n_units: int
    n_bodies: int
    n_unknowns: int
    load: float  # size of the free velocities
    terms: float  # size of what cancels in velocities
    worst: float  # absolute residual of the best point
    convex: int  # 1: forces follow the convex law, see convex_start
    floor: float  # eps goes no lower
    cost: float  # what F is the slope of under it
    local: IntArray = array("scene")  # bodies of the scene in the island, -1: others
    pos: IntArray = array("offsets")  # first unknown of each body
    kind: IntArray = array("units")
    body: IntArray = array("units", 2)
    J: FloatArray = array("units", 2, 3, "width")  # rows (n, t1, t2) by body
    W: FloatArray = array("units", 6)  # J_k J_k^T: nn, n1, n2, 11, 12, 22
    scale: FloatArray = array("units")  # 1 / sqrt(D)
    mu: FloatArray = array("units")
    rows: IntArray = array("units", 3)  # of the scene, -1: none
    free: FloatArray = array("units", 3)
    # points
    q: FloatArray = array("units", 3)
    y: FloatArray = array("units", 3)
    x: FloatArray = array("unknowns")
    best: FloatArray = array("units", 3)
    slip: FloatArray = array("units")  # |u_T| / |r_T| in the last sweep
    # of Newton's method
    centre: FloatArray = array("units", 3)
    base: FloatArray = array("units", 3)
    change: FloatArray = array("units", 3)
    speed: FloatArray = array("units", 3)
    trial: FloatArray = array("units", 3)
    state: IntArray = array("units")
    factored: IntArray = array("units")
    C: FloatArray = array("units", 9)
    rest: FloatArray = array("unknowns")
    step: FloatArray = array("unknowns")
    point: FloatArray = array("unknowns")
    factor: SparseFactor


LargeCones: TypeAlias = Any  # a SpatialLargeMemory, for kernels that are shared with the plane

FACTORS, OPERATIONS = 600, 2e9


def large_cones(
    sizes: dict[str, int], units: int, bodies: int, before: SpatialLargeMemory | None = None
) -> SpatialLargeMemory:
    """Memory for islands of so many contacts with joint rows, and bodies; what one before it knows and wants goes on.

    sizes: bodies of the scene, and the ``width`` of their widest one.
    """
    own = {"scene": sizes["bodies"], "units": units, "bodies": bodies, "offsets": bodies + 1, "links": 2 * units}
    own |= {"width": sizes["width"], "unknowns": bodies * sizes["width"]}
    own |= {name: 2 * each * bodies for name, each in STARTING.items()}
    if before is not None:
        for name in STARTING:
            kept = len(getattr(before.factor, name))
            own[name] = max(own[name], kept, getattr(before.factor, f"room_{name}"))
    memory = allocate(SpatialLargeMemory, own, factor=allocate(SparseFactor, own))
    memory.tolerance, memory.factor_limit, memory.operation_limit = 1e-9, FACTORS, OPERATIONS
    if before is not None:
        copy_parts(before, memory)
    memory.local[:] = -1
    return memory
