"""Memory for the reactions of joints, and the reaction of one by the virtual work of its rows.

See :mod:`lcpflex.dynamics.joint_reactions`.
"""

from __future__ import annotations

import numpy as np

from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.jit.struct import allocate, array, struct
from lcpflex.kinematics.relative import ANGLE
from lcpflex.model.arrays import Joints, Model

__all__ = ["Reactions", "reaction", "reactions"]


@struct
class Reactions:
    """Reactions of the joints: (F_x, F_y, M) of each [N], [N], [N m].

    With the dimension "rates": since the last stored instant of each rate (:mod:`lcpflex.steppers.rates`).
    """

    size: float  # L [m]
    known: int  # 1: ``now`` is known
    time: FloatArray = array("rates", "joints")  # [s] of the steps in ``sum``
    sum: FloatArray = array("rates", "joints", 3)  # their integral over time
    peak: FloatArray = array("rates", "joints", 2)  # largest |F|^2 and |M|
    impulse: FloatArray = array("joints", 3)  # of impacts, since the start [N s], [N m s]
    now: FloatArray = array("joints", 3)  # at the end of the last step, of schemes that know them there
    ahead: FloatArray = array("joints", 3)  # and of the present one
    mean: FloatArray = array("joints", 3)  # scratch
    change: FloatArray = array("joints", 3)  # scratch
    unique: IntArray = array("joints")  # scratch: 1 where the motion determines the reaction
    shared: IntArray = array(
        "rates", "joints"
    )  # 1: contacts may take a part of the reaction; until the instant is stored
    reached: IntArray = array("bodies")  # scratch: 1 where impulses of an impact of the present step pass
    owner: IntArray  # (rows,) joint that each row belongs to
    rows: FloatArray = array("rows")  # scratch
    least: FloatArray = array("rows")
    load: FloatArray = array("rows")


def reactions(joints: Joints, bodies: int, size: float, rates: int) -> Reactions:
    """Memory for the reactions of joints between so many bodies, the largest of them of that ``size`` [m].

    Of a user's own system, whose joints have no points, for none.
    """
    owner = np.repeat(np.arange(len(joints.point)), np.diff(joints.row)[: len(joints.point)])
    sizes = {"joints": len(joints.point), "rows": len(owner), "bodies": bodies, "rates": rates}
    return allocate(Reactions, sizes, size=size if size > 0.0 else 1.0, owner=owner)


@kernel
def reaction(model: Model, work: Workspace, joint: int, p: FloatArray) -> tuple[float, float, float]:
    """(F_x, F_y, M) of one joint with the multipliers p of all rows, by the rows laid."""
    rows, row_body, joints = work.rows, work.row_body, model.joints
    x, y, moment = 0.0, 0.0, 0.0
    for r in range(joints.row[joint], joints.row[joint + 1]):
        if joints.kind[r] == ANGLE:
            moment += p[r]
        elif row_body[r, 0] >= 0:
            x += p[r] * rows[r, 0, 0]
            y += p[r] * rows[r, 0, 1]
        else:
            x -= p[r] * rows[r, 1, 0]
            y -= p[r] * rows[r, 1, 1]
    return x, y, moment
