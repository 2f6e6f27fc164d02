"""The rows of joints and contacts at a configuration, and the factors of the matrix of a step: one struct of both."""

from __future__ import annotations

from lcpflex.contact.detection import ContactTable
from lcpflex.dynamics.inertia import Arrow
from lcpflex.dynamics.joint_factor import JointFactor
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.jit.struct import array, spatial, struct

__all__ = ["Rows", "SpatialRows"]


@struct
class Rows:
    """Rows J of g' = J u + ...: of joints first, then of normals, then of tangents where mu > 0.

    Behind these there are rows of scratch, one for each tangent of a contact. Both the rigid contacts of a workspace
    and the compliant ones beside them have such rows; dof, arrow and dense are the same arrays in both.
    """

    dof: IntArray  # (nb + 1,) first velocity of each body
    table: ContactTable
    arrow: Arrow  # factors of the matrix A of a step
    dense: FloatArray  # Cholesky factor of A; user-defined systems only
    joints: JointFactor
    J: FloatArray = array("rows", 2, "width")  # by body: of the two that a row acts on
    solved: FloatArray = array("rows", 2, "width")  # A^-1 J^T
    white: FloatArray = array("white", 2, "width")  # L^-1 J^T, A = L L^T; where there may be large islands
    body: IntArray  # (rows, 2), -1: none
    wrench: FloatArray = array("joints", "reaction")  # of a multiplier 1 of each joint row: force, moment on P's body
    rate: FloatArray = array("rows")  # partial time derivatives of the joint constraints
    bias: FloatArray = array("rows")  # w of g'' = J u' + w
    mu: FloatArray = array("contacts")
    tangent: IntArray = array("tangents")  # the contact that each tangential row belongs to
    n_joint: int  # joint rows at hand
    n_contacts: int
    n_tangents: int  # tangential rows
    across: int  # of a contact with friction: 1 in the plane, 2 in space


SpatialRows = spatial(Rows)
