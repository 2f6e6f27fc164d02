"""Memory for the sparse factor of S = J A^-1 J^T, whose pattern is that of the mechanism.

Two joints share entries of S where they share a moving body: a chain or a tree has no more than that in its factor, and
all costs grow with the number of its links. See :mod:`lcpflex.dynamics.joint_response` for what is asked of it.
"""

from __future__ import annotations

import numpy as np

from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.jit.struct import allocate, array, struct
from lcpflex.model.arrays import GROUND, Model
from lcpflex.solvers.elimination import Pattern, sparse_pattern
from lcpflex.solvers.sparse_cholesky import SparseFactor, sparse_factor

__all__ = ["JointFactor", "JointPattern", "joint_factor", "joint_pattern", "joints_between", "no_joints"]


class JointPattern:
    """Pattern of S, and the joint rows that act on each body, made once for a model."""

    def __init__(self, pattern: Pattern, on_body: list[list[int]], first: list[int], loops: int) -> None:
        self.factor = pattern
        self.loops = loops
        place = np.empty(len(pattern.order), dtype=np.int64)
        place[pattern.order] = np.arange(len(place))
        self.block = np.append(np.sort(place[first[:-1]]), len(place))
        self.first = np.cumsum([0, *map(len, on_body)])
        self.place = np.array([i for rows in on_body for i in sorted(place[rows].tolist())], dtype=np.int64)


@struct
class JointFactor:
    """The factor of S, and scratch for what is asked of it."""

    factor: SparseFactor
    loops: int  # joints that close a loop; without any, none is redundant
    block: IntArray  # (joints + 1,) offsets of the rows of each in the factor
    schur: FloatArray = array("largest", "largest")  # of the rows of one joint; scratch
    first: IntArray  # (bodies + 1,) offsets into ``place``
    place: IntArray  # places in the factor of the joint rows on each body, ascending
    answer: FloatArray = array("joints")  # S^-1 b of the last contact problem, b: rates that the joints are to cancel
    rates: FloatArray = array("joints")  # scratch
    impulses: FloatArray = array("joints")  # scratch; that beneath is in the order of the factor
    x: FloatArray = array("joints")  # scratch, 0 between calls
    left: FloatArray = array("joints")
    better: FloatArray = array("joints")
    change: FloatArray = array("ndof")  # scratch
    # of each contact row of the last problem, G_JW where it is not 0: on joints that act on its bodies
    coupling: FloatArray = array("pairs", "acting")
    acting: IntArray = array("pairs", "acting")  # place in the factor; a joint between both bodies is there twice
    n_acting: IntArray = array("pairs")


def joint_pattern(model: Model) -> JointPattern:
    """Of the joints of a model; where it does not say which bodies they hold, all rows are on body 0."""
    first = [int(row) for row in model.joints.row]
    n_bodies = len(model.bodies.dof) - 1
    if len(model.joints.point):
        sizes = np.diff(first).tolist()
        held = [{int(model.points.body[p]) for p in pair} - {GROUND} for pair in model.joints.point]
    else:
        sizes = [first[-1]] if first[-1] else []
        held = [{0} for _ in sizes]
    return joints_between(sizes, held, n_bodies)


def no_joints(n_bodies: int) -> JointPattern:
    """Of no joints between so many bodies."""
    return joints_between([], [], n_bodies)


def joints_between(sizes: list[int], held: list[set[int]], n_bodies: int) -> JointPattern:
    """Of joints with so many rows, each on the bodies that it holds."""
    first = np.cumsum([0, *sizes]).tolist()
    on_body: list[list[int]] = [[] for _ in range(n_bodies)]
    for joint, bodies in enumerate(held):
        for b in bodies:
            on_body[b].append(joint)
    neighbours = [{other for b in bodies for other in on_body[b]} - {joint} for joint, bodies in enumerate(held)]
    rows = [[r for joint in joints for r in range(first[joint], first[joint + 1])] for joints in on_body]
    return JointPattern(sparse_pattern(neighbours, first), rows, first, _loops(held))


def _loops(held: list[set[int]]) -> int:
    """How many joints connect what those before them have connected: bodies, each or with the ground."""
    parent: dict[int, int] = {}

    def root(b: int) -> int:
        while parent.setdefault(b, b) != b:
            parent[b] = b = parent[parent[b]]
        return b

    closing = 0
    for bodies in held:
        a, b = (root(one) for one in (*bodies, GROUND, GROUND)[:2])
        closing += a == b
        parent[a] = b
    return closing


def joint_factor(pattern: JointPattern, ndof: int, pairs: int) -> JointFactor:
    """Memory for the factor, and for ``pairs`` contact rows."""
    return allocate(
        JointFactor,
        {
            "joints": len(pattern.factor.order),
            "ndof": ndof,
            "largest": int(np.diff(pattern.block).max(initial=0)),
            "pairs": pairs,
            "acting": 2 * int(np.diff(pattern.first).max(initial=0)),
        },
        factor=sparse_factor(pattern.factor),
        loops=pattern.loops,
        block=pattern.block,
        first=pattern.first,
        place=pattern.place,
    )
