"""Steps that came to what is no finite number: which contacts and bodies it is at, in words."""

from __future__ import annotations

import numpy as np

from lcpflex.dynamics.workspace import Workspace
from lcpflex.steppers.named import listed
from lcpflex.steppers.system import System

__all__ = ["not_finite"]


def not_finite(system: System, work: Workspace) -> str:
    """Contacts and bodies of the last step with a velocity or force that is no finite number; empty where all are.

    A free velocity that is none comes from a body's velocity or load, or a force of the step before: all contacts of
    the body have it then. A force that is none where all free velocities are sound comes from what solved the problem.
    """
    n_joint, n = int(work.rows.n_joint), int(work.rows.n_contacts)
    rows = n_joint + n + int(work.rows.n_tangents)
    sound = np.isfinite(work.free.v[:rows]) & np.isfinite(work.impulses.p[:rows])
    wrong = np.flatnonzero(~sound)
    contact = np.concatenate([np.full(n_joint, -1), np.arange(n), work.rows.tangent[: rows - n_joint - n]])[wrong]
    laws = sorted({int(work.rows.table.law[k]) for k in contact if k >= 0})
    bodies = {int(b) for b in np.ravel(work.rows.body[wrong]) if b >= 0}
    lost = np.flatnonzero(~np.isfinite(work.free.u))
    bodies |= {int(b) for b in np.searchsorted(work.rows.dof, lost, side="right") - 1}
    parts = [listed(laws, system.contact_name)] if laws else []
    if bodies and system.bodies:
        parts.append(listed(sorted(bodies), system.body_name, "body", "bodies"))
    return " of ".join(parts)
