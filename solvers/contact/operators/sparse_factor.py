"""Rows by body, and memory of a sparse factor of I + J^T C J over them: its pattern, kept while it serves, and numbers.

The order of elimination is that of :mod:`.ordering`, the factor itself of :mod:`.fronts`.
"""

from __future__ import annotations

import numpy as np

from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.jit.struct import allocate, array, put_array, struct

__all__ = ["STARTING", "Bodies", "SparseFactor", "factor_room", "sparse_factor", "widen"]

STARTING = {"pool": 8, "values": 200, "front": 400, "stack": 400}  # numbers a body to begin with


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
class Bodies:
    """Rows by body: the operator of :mod:`.bodies`."""

    n_bodies: int
    n_unknowns: int
    pos: IntArray = array("offsets")  # first unknown of each body
    body: IntArray = array("units", 2)  # -1: none, or one that nothing moves
    J: FloatArray = array("units", 2, "rows", "width")
    x: FloatArray = array("unknowns")
    factor: SparseFactor  # of Newton's method


def sparse_factor(sizes: dict[str, int], before: SparseFactor | None = None, begun: bool = True) -> SparseFactor:
    """Room for so many ``bodies``, ``units`` and ``unknowns``; what a smaller one wants is granted.

    begun: with numbers to begin with; else it has to be widened before its first use.
    """
    own = {"offsets": sizes["bodies"] + 1, "links": 2 * sizes["units"], **sizes}
    own |= {name: each * sizes["bodies"] if begun else 0 for name, each in STARTING.items()}
    if before is not None:
        own |= {name: max(own[name], size) for name, size in factor_room(before).items()}
    return allocate(SparseFactor, own)


def factor_room(factor: SparseFactor) -> dict[str, int]:
    """How many numbers each of its arrays that are too small at times is to hold."""
    return {name: max(len(getattr(factor, name)), getattr(factor, f"room_{name}")) for name in STARTING}


def widen(factor: SparseFactor) -> None:
    """Room in place for what a factor lacks; its numbers, and a pattern that there was no room for, are made anew."""
    for name, size in factor_room(factor).items():
        kept = getattr(factor, name)
        if size > len(kept):
            put_array(factor, name, np.zeros(size, kept.dtype))
