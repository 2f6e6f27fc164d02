"""Where spatial mechanics ends and solvers begin: the contact problems of the rows laid, one for each island."""

from __future__ import annotations

from lcpflex.dynamics.contact_problem import factor_joints
from lcpflex.dynamics.islands import one_island
from lcpflex.dynamics.spatial.inertia import SpatialWork
from lcpflex.jit.kernel import kernel

__all__ = ["lay_contacts"]


@kernel
def lay_contacts(work: SpatialWork) -> None:
    """Begin with the contacts of the rows laid: which islands they make, under Coulomb's law."""
    work.on_sets = 0
    work.shifted = 0
    work.lifted = 0
    for k in range(work.n_contacts):
        work.tangent_of[k] = -1
    for j in range(0, work.n_tangents, 2):
        work.tangent_of[work.tangent[j]] = j
    factor_joints(work)
    one_island(work.islands, work.n_contacts)
