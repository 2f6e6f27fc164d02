"""Memory for the reactions of joints, and the reaction of one by the virtual work of its rows.

A reaction is a force and a moment: (F_x, F_y, M) in the plane, (F_x, F_y, F_z, M_x, M_y, M_z) in space, world axes.

See :mod:`lcpflex.dynamics.joint_reactions`.
"""

from __future__ import annotations

import numpy as np

from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.jit.leaf import in_space
from lcpflex.jit.struct import allocate, array, struct
from lcpflex.model.arrays import Joints, Model
from lcpflex.model.spatial import SpatialJoints

__all__ = ["Reactions", "peaks", "reaction", "reactions"]


@struct
class Reactions:
    """Reactions of the joints: the components of the force [N] and of the moment [N m] of each.

    With the dimension "rates": since the last stored instant of each rate (:mod:`lcpflex.steppers.rates`).
    """

    size: float  # L [m]
    known: int  # 1: ``now`` is known
    time: FloatArray = array("rates", "joints")  # [s] of the steps in ``sum``
    sum: FloatArray = array("rates", "joints", "reaction")  # their integral over time
    peak: FloatArray = array("rates", "joints", 2)  # largest |F|^2 and |M|
    impulse: FloatArray = array("joints", "reaction")  # of impacts, since the start [N s], [N m s]
    now: FloatArray = array("joints", "reaction")  # at the end of the last step, of schemes that know them there
    ahead: FloatArray = array("joints", "reaction")  # and of the present one
    mean: FloatArray = array("joints", "reaction")  # scratch
    change: FloatArray = array("joints", "reaction")  # scratch
    unique: IntArray = array("joints")  # scratch: 1 where the motion determines the reaction
    shared: IntArray = array(
        "rates", "joints"
    )  # 1: contacts may take a part of the reaction; until the instant is stored
    reached: IntArray = array("bodies")  # scratch: 1 where impulses of an impact of the present step pass
    owner: IntArray  # (rows,) joint that each row belongs to
    rows: FloatArray = array("rows")  # scratch
    least: FloatArray = array("rows")
    load: FloatArray = array("rows")


def reactions(joints: Joints | SpatialJoints, bodies: int, size: float, rates: int) -> Reactions:
    """Memory for the reactions of joints between so many bodies, the largest of them of that ``size`` [m].

    Of a user's own system, whose joints have no points, for none.
    """
    owner = np.repeat(np.arange(len(joints.point)), np.diff(joints.row)[: len(joints.point)])
    d = joints.axis.shape[1]
    sizes = {
        "joints": len(joints.point),
        "rows": len(owner),
        "bodies": bodies,
        "rates": rates,
        "reaction": d * (d + 1) // 2,  # directions and planes of rotation: 3 in the plane, 6 in space
    }
    return allocate(Reactions, sizes, size=size if size > 0.0 else 1.0, owner=owner)


@in_space("lcpflex.dynamics.spatial.reactions")
@kernel
def reaction(model: Model, work: Workspace, joint: int, p: FloatArray) -> tuple[float, float, float]:
    """(F_x, F_y, M) of one joint with the multipliers p of all rows, by the rows laid."""
    x, y, moment = 0.0, 0.0, 0.0
    for r in range(model.joints.row[joint], model.joints.row[joint + 1]):
        x += p[r] * work.rows.wrench[r, 0]
        y += p[r] * work.rows.wrench[r, 1]
        moment += p[r] * work.rows.wrench[r, 2]
    return x, y, moment


@in_space("lcpflex.dynamics.spatial.reactions")
@kernel
def peaks(model: Model, impulse: FloatArray | tuple[float, ...], h: float) -> tuple[float, float]:
    """|F|^2 and |M| of the reaction ``impulse`` / h."""
    x, y = impulse[0] / h, impulse[1] / h
    return x * x + y * y, abs(impulse[2] / h)
