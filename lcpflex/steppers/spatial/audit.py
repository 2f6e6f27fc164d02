"""What the contacts of a Moreau-Jean step in space did: their work, and their impulses."""

from __future__ import annotations

from lcpflex.contact.spatial.table import side_of
from lcpflex.dynamics.spatial.inertia import SpatialWork
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.solvers.contact.operators.scene import row_velocities
from lcpflex.steppers.recorder import Recorder
from lcpflex.steppers.spatial.records import friction_vector

__all__ = ["audit_contacts"]


@kernel
def audit_contacts(u: FloatArray, work: SpatialWork, recorder: Recorder) -> float:
    """Add the work p . W^T (u + u+)/2 and the impulses p of all contacts to the recorder; what they gained [J].

    u: velocity before; that behind is ``work.free.u``. A contact without a normal impulse has none at all.
    """
    n_joint, n = work.rows.n_joint, work.rows.n_contacts
    p, sums, table = work.impulses.p, recorder.total_impulse, work.rows.table
    both = work.impulses.solver.scene.x  # nobody needs it any more
    for i in range(len(u)):
        both[i] = 0.5 * (u[i] + work.free.u[i])
    lost_n, lost_t = 0.0, 0.0
    for k in range(n):
        r, j = n_joint + k, work.posed.tangent_of[k]
        if p[r] == 0.0:
            continue
        s = n_joint + n + j if j >= 0 else -1
        v, v1, v2 = row_velocities(work.rows.J, work.rows.body, work.rows.dof, r, s, both)
        law = table.law[k]
        lost_n -= p[r] * v
        sums[law, 0] += p[r]
        if s >= 0:
            lost_t -= p[s] * v1 + p[s + 1] * v2
            side = side_of(recorder.table, law, table.body[k, 0])
            x, y, z = friction_vector(table, k, side * p[s], side * p[s + 1])
            sums[law, 1] += x
            sums[law, 2] += y
            sums[law, 3] += z
    recorder.counts.lost_impacts += lost_n
    recorder.counts.lost_friction += lost_t
    return -(lost_n + lost_t)
