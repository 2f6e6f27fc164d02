"""What forces at material points of flexible bodies do to each other through the modes: blocks of three by three.

    E_ab = Phi_a diag(w) Phi_b^T,   points a and b of one body, body axes

With w = 1/(1 + alpha_c c_k + alpha_k omega_k^2) it is what the modes have of the inverse matrix of a step, with
w = 1/omega_k^2 their static compliance. Both are constant, the first one while steps are equally long. A block is
computed when it is first asked for: points that never touch cost nothing, and what touches costs nine products a block,
however many modes there are.
"""

from __future__ import annotations

import numpy as np

from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.jit.struct import allocate, array, struct
from lcpflex.kinematics.spatial.rotations import Matrix
from lcpflex.model.spatial import (
    N_RIGID,
    SpatialBodies,
    SpatialContacts,
    SpatialPoints,
    SpatialPointTable,
    bodiless_spatial_model,
)

__all__ = [
    "PointBlocks",
    "add_block",
    "block_of",
    "has_blocks",
    "no_blocks",
    "point_blocks",
    "touching_points",
    "weigh_modes",
]

ROOM = 500_000  # blocks of all bodies: 36 MB, which 1000 points of one body need


@struct
class PointBlocks:
    """Blocks of the points listed, of each body those of each pair once. Where the diagonal is 0, one is not known."""

    number: IntArray = array("points")  # of each material point among those listed of its body; -1: none
    first: IntArray = array("bodies")  # of each body in ``block``
    last: IntArray = array("bodies")
    dof: IntArray  # these seven are those of the model
    centred: IntArray
    mass: FloatArray
    S: FloatArray
    body: IntArray
    start: IntArray
    phi: FloatArray
    changed: IntArray = array("bodies")  # 1: ``block`` belongs to other weights than these
    weight: FloatArray = array("modes")  # w of the modes of all bodies
    block: FloatArray = array("blocks", 9)  # E_ab, number of a >= that of b, row by row


def point_blocks(bodies: SpatialBodies, points: SpatialPoints, listed: IntArray, room: int = ROOM) -> PointBlocks:
    """Memory for the blocks of the material points ``listed``, which may be repeated.

    Those of bodies without modes have none, nor have those of a body that needs more blocks than are left of ``room``.
    """
    n = len(bodies.mass)
    number = np.full(len(points.body), -1, dtype=np.int64)
    first, last, end = np.zeros(n, dtype=np.int64), np.zeros(n, dtype=np.int64), 0
    listed = np.unique(np.asarray(listed, dtype=np.int64))
    for b in range(n):
        own = listed[points.body[listed] == b]
        count = len(own) * (len(own) + 1) // 2
        flexible = bodies.dof[b + 1] - bodies.dof[b] > N_RIGID
        first[b] = last[b] = end
        if flexible and end + count <= room:
            number[own] = np.arange(len(own))
            end += count
            last[b] = end
    return allocate(
        PointBlocks,
        {"modes": len(bodies.stiffness), "bodies": n},
        dof=bodies.dof,
        centred=bodies.centred,
        mass=bodies.mass,
        S=bodies.S,
        body=points.body,
        start=points.start,
        phi=points.phi,
        number=number,
        first=first,
        last=last,
        block=np.zeros((end, 9)),  # memory that is not touched costs nothing
    )


def no_blocks() -> PointBlocks:
    """Of no points at all."""
    points = SpatialPointTable().compile()
    model = bodiless_spatial_model(0, 0, 0, [], [], [])
    return point_blocks(model.bodies, points, np.zeros(0, dtype=np.int64))


def touching_points(contacts: SpatialContacts) -> IntArray:
    """Material points of the surfaces that may touch: their nodes, and what their features are made of."""
    ruled = range(len(contacts.rule_rank))
    used = {*contacts.pass_node.tolist(), *contacts.pass_feature.tolist(), *ruled}
    found = [np.zeros(0, dtype=np.int64)]
    for s in sorted(used):
        found.append(contacts.node_point[contacts.node_start[s] : contacts.node_start[s + 1]])
        found.append(contacts.feature_point[contacts.feature_start[s] : contacts.feature_start[s + 1]].ravel())
    return np.unique(np.concatenate(found))


@kernel
def has_blocks(of: PointBlocks, p: int) -> bool:
    """Whether there are blocks of the material point p."""
    return bool(of.number[p] >= 0)


@kernel
def weigh_modes(of: PointBlocks, b: int, weight: FloatArray, at: int) -> bool:
    """The modes of body b have the weights from place ``at`` on; whether its blocks may be asked for.

    Not where the weights are others than the last time: where each step has another length, blocks would be computed to
    be used once. They are forgotten when the same weights come twice.
    """
    same, kept, first = True, of.weight, of.dof[b] - N_RIGID * b
    for k in range(of.dof[b + 1] - of.dof[b] - N_RIGID):
        same = same and kept[first + k] == weight[at + k]
        kept[first + k] = weight[at + k]
    if not same:
        of.changed[b] = 1
    elif of.changed[b] == 1:
        of.changed[b] = 0
        for i in range(of.first[b], of.last[b]):
            of.block[i, 0], of.block[i, 4], of.block[i, 8] = 0.0, 0.0, 0.0
    return bool(same)


@kernel
def fill_block(of: PointBlocks, at: int, p: int, r: int) -> None:
    """Compute block ``at``, of the points p and r."""
    xx, xy, xz, yx, yy, yz, zx, zy, zz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    b, phi, weight = of.body[p], of.phi, of.weight
    mode, i, j = of.dof[b] - N_RIGID * b, of.start[p], of.start[r]
    for k in range(of.start[p + 1] - i):
        w = weight[mode + k]
        x, y, z = w * phi[i + k, 0], w * phi[i + k, 1], w * phi[i + k, 2]
        u, v, s = phi[j + k, 0], phi[j + k, 1], phi[j + k, 2]
        xx += x * u
        xy += x * v
        xz += x * s
        yx += y * u
        yy += y * v
        yz += y * s
        zx += z * u
        zy += z * v
        zz += z * s
    block = of.block[at]
    block[0], block[1], block[2] = xx, xy, xz
    block[3], block[4], block[5] = yx, yy, yz
    block[6], block[7], block[8] = zx, zy, zz


@kernel
def block_of(of: PointBlocks, p: int, r: int) -> Matrix:
    """E of the points p and r of one body, which have blocks; row by row."""
    i, j = of.number[p], of.number[r]
    first, second = (p, r) if i >= j else (r, p)
    i, j = max(i, j), min(i, j)
    at = of.first[of.body[p]] + i * (i + 1) // 2 + j
    block = of.block
    if block[at, 0] == 0.0 and block[at, 4] == 0.0 and block[at, 8] == 0.0:
        fill_block(of, at, first, second)
    if first == p:
        return (
            block[at, 0], block[at, 1], block[at, 2], block[at, 3], block[at, 4], block[at, 5], block[at, 6],
            block[at, 7], block[at, 8],
        )  # fmt: skip
    return (
        block[at, 0], block[at, 3], block[at, 6], block[at, 1], block[at, 4], block[at, 7], block[at, 2],
        block[at, 5], block[at, 8],
    )  # fmt: skip


@kernel
def add_block(total: Matrix, weight: float, block: Matrix) -> Matrix:
    """total + weight block."""
    a, b, c, d, e, f, g, h, i = block
    return (
        total[0] + weight * a, total[1] + weight * b, total[2] + weight * c, total[3] + weight * d,
        total[4] + weight * e, total[5] + weight * f, total[6] + weight * g, total[7] + weight * h,
        total[8] + weight * i,
    )  # fmt: skip
