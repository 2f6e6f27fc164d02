"""Structs of large contact problems: what they are made of, and the memory of their solver, all linear in contacts."""

from __future__ import annotations

import numpy as np

from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.jit.struct import allocate, array, copy_parts, put_array, struct

__all__ = [
    "FRICTIONAL",
    "HINGE",
    "JOINT_ROW",
    "NORMAL",
    "BodyContacts",
    "LargeMemory",
    "SparseFactor",
    "grown",
    "large_memory",
    "widen",
]

NORMAL, FRICTIONAL, JOINT_ROW, HINGE = 0, 1, 2, 3  # kinds of units: contacts, and one or two joint rows


@struct
class BodyContacts:
    """The contact problem of one island, in rows that are stored for the whole scene.

    v = free + J x, x = J^T p: ``white`` holds the rows of J by body, L^-1 times those of the scene where A = L L^T is
    the matrix of a body; zeros fill them up.
    """

    n_contacts: int
    n_joints: int
    n_bodies: int
    first_contact: int  # row that the first entry of ``terms`` belongs to
    white: FloatArray = array("rows", 2, "width")
    row_body: IntArray = array("rows", 2)  # -1: none; bodies outside of the island count as none
    dof: IntArray = array("offsets")  # first velocity of each body of the scene
    free: FloatArray = array("rows")  # row velocities without constraint impulses, restitution and bias included
    terms: FloatArray = array("rows")  # sum |W^T| |u_free| of contact rows
    p: FloatArray = array("rows")  # in: where to start; out: impulses
    normal_row: IntArray = array("contacts")
    tangent_row: IntArray = array("contacts")  # -1: without friction
    friction: FloatArray = array("contacts")
    joint_row: IntArray = array("joints")
    bodies: IntArray = array("bodies")


@struct
class SparseFactor:
    """LU factor of I + J^T C J by fronts: supernodes of the elimination tree of the graph of bodies.

    The pattern is kept while it holds all pairs of bodies that touch.
    """

    known: int  # 1: the pattern serves the island of ``n_bodies`` bodies ``body``
    n_bodies: int
    n_nodes: int  # supernodes
    pool_end: int  # of ``pool`` in use
    pairs: int  # of bodies that the pattern was made for
    entries: int  # numbers of the factor
    widest: int  # unknowns of the largest front
    highest: int  # numbers on the stack
    work: float  # operations of one factor
    room_pool: int  # how much is wanting, where something is too small
    room_values: int
    room_front: int
    room_stack: int
    body: IntArray = array("bodies")  # bodies of the scene
    size: IntArray = array("bodies")  # unknowns of each
    near: IntArray = array("links")  # neighbours of each body while the order is sought
    start: IntArray = array("offsets")
    length: IntArray = array("bodies")
    state: IntArray = array("bodies")
    degree: IntArray = array("bodies")
    head: IntArray = array("offsets")  # bodies by degree
    following: IntArray = array("bodies")
    before: IntArray = array("bodies")
    mark: IntArray = array("bodies")
    pool: IntArray = array("pool")  # what each body is tied to when it is eliminated
    pool_start: IntArray = array("bodies")
    pool_length: IntArray = array("bodies")
    parent: IntArray = array("bodies")
    order: IntArray = array("bodies")  # the body at each place of the elimination
    place: IntArray = array("bodies")  # the reverse
    node_first: IntArray = array("offsets")  # first place of each supernode
    node_children: IntArray = array("bodies")
    node_entry: IntArray = array("offsets")  # where its numbers begin
    node_pivots: IntArray = array("bodies")  # unknowns it eliminates
    node_width: IntArray = array("bodies")  # unknowns of its front
    unit_start: IntArray = array("offsets")  # units by the place of the first of their bodies
    unit_list: IntArray = array("units")
    offset: IntArray = array("bodies")  # of bodies in the front at hand
    swap: IntArray = array("unknowns")  # rows exchanged
    first_pivot: IntArray = array("bodies")  # of a supernode, in ``swap``
    values: FloatArray = array("values")
    front: FloatArray = array("front")
    stack: FloatArray = array("stack")
    gathered: FloatArray = array("unknowns")


@struct
class LargeMemory:
    """Answer and work memory of the solver of large contact problems.

    Units are the contacts of the problem in their order, then its joint rows, two of a hinge in one.
    """

    # what the user may set
    tolerance: float  # 1e-8: of the residual, see lcpflex.solvers.contact.large.judging
    factor_limit: int  # sparse factors at most
    sweep_limit: int  # sweeps at most
    operation_limit: float  # of all factors, in multiplications
    # what is known of the answer
    residual: float  # relative to the terms
    strict: float  # relative to the free velocity alone
    missed: float  # the largest part of its own load that is left of a contact
    behind: int  # that contact
    factors: int
    allowed: int  # factors that the limits come to
    sweeps: int
    route: int  # how the answer was found, see lcpflex.solvers.contact.large.solving
    # the problem in units
    n_units: int
    n_bodies: int
    n_unknowns: int
    usual: float  # strict residual of the problem before, where that was small and above the tolerance
    load: float  # size of the free velocities
    cost: float  # what F is the slope of under the convex law
    convex: int  # 1: impulses follow the convex law, see convex_start
    worst: float  # absolute residual of the best point
    local: IntArray = array("scene")  # bodies of the scene in the island, -1: others
    pos: IntArray = array("offsets")  # first unknown of each body
    kind: IntArray = array("units")
    body: IntArray = array("units", 2)
    J: FloatArray = array("units", 2, 2, "width")
    W: FloatArray = array("units", 3)  # J_k J_k^T: NN, NT, TT
    scale: FloatArray = array("units")  # 1 / sqrt(D)
    mu: FloatArray = array("units")
    free: FloatArray = array("units", 2)
    own: FloatArray = array("units")  # size of the free velocities of each unit
    rows: IntArray = array("units", 2)  # of the scene
    # points
    q: FloatArray = array("units", 2)
    y: FloatArray = array("units", 2)
    x: FloatArray = array("unknowns")
    best: FloatArray = array("units", 2)
    kept: FloatArray = array("units", 2)
    # of Newton's method
    centre: FloatArray = array("units", 2)
    base: FloatArray = array("units", 2)
    change: FloatArray = array("units", 2)
    slip: FloatArray = array("units", 2)
    lift: FloatArray = array("units", 2)
    slope: FloatArray = array("units", 2)
    trial: FloatArray = array("units", 2)
    state: IntArray = array("units")
    factored: IntArray = array("units")
    C: FloatArray = array("units", 4)
    rest: FloatArray = array("unknowns")
    step: FloatArray = array("unknowns")
    point: FloatArray = array("unknowns")
    good_point: FloatArray = array("unknowns")
    terms: FloatArray = array("unknowns")
    factor: SparseFactor
    apart: SparseFactor  # of what is only recorded: the patterns that steps find must not depend on it


STARTING = {"pool": 8, "values": 200, "front": 400, "stack": 400}  # numbers a body to begin with


def large_memory(scene_bodies: int, contacts: int, joints: int, bodies: int, width: int) -> LargeMemory:
    """Memory for islands of so many contacts, joint rows and bodies of up to ``width`` unknowns."""
    units = contacts + joints
    sizes = {
        "scene": scene_bodies,
        "units": units,
        "bodies": bodies,
        "offsets": bodies + 1,
        "width": width,
        "unknowns": bodies * width,
        "links": 2 * units,
        **{name: each * bodies for name, each in STARTING.items()},
    }
    apart = allocate(SparseFactor, sizes | dict.fromkeys(STARTING, 0))
    memory = allocate(LargeMemory, sizes, factor=allocate(SparseFactor, sizes), apart=apart)
    memory.local[:] = -1
    memory.tolerance, memory.factor_limit, memory.sweep_limit = 1e-8, 600, 1000
    memory.operation_limit = 4e9
    return memory


def grown(memory: LargeMemory, more: dict[str, int]) -> LargeMemory:
    """Another memory, with what this one knows and wants, and room for ``more`` units, bodies and so on."""
    sizes = {
        "scene": len(memory.local),
        "units": len(memory.kind),
        "bodies": len(memory.factor.body),
        "width": memory.J.shape[3],
        "unknowns": len(memory.x),
    }
    sizes = {name: max(size, more.get(name, 0)) for name, size in sizes.items()}
    sizes |= {"offsets": sizes["bodies"] + 1, "links": 2 * sizes["units"]}
    sizes["unknowns"] = max(sizes["unknowns"], sizes["bodies"] * sizes["width"])
    factor, apart = (
        allocate(SparseFactor, sizes | {name: max(size, more.get(name, 0)) for name, size in _wanted(own).items()})
        for own in (memory.factor, memory.apart)
    )
    other = allocate(LargeMemory, sizes, factor=factor, apart=apart)
    other.local[:] = -1
    copy_parts(memory, other)
    return other


def _wanted(factor: SparseFactor) -> dict[str, int]:
    """How many numbers each of its arrays that are too small at times is to hold."""
    return {name: max(len(getattr(factor, name)), getattr(factor, f"room_{name}")) for name in STARTING}


def widen(factor: SparseFactor) -> None:
    """Room in place for what a factor lacks; its numbers, and a pattern that there was no room for, are made anew."""
    for name, size in _wanted(factor).items():
        kept = getattr(factor, name)
        if size > len(kept):
            put_array(factor, name, np.zeros(size, kept.dtype))
