"""Islands of many contacts in space: their rows for :mod:`lcpflex.solvers.contact.large`."""

from __future__ import annotations

from lcpflex.dynamics.large_island import is_large
from lcpflex.dynamics.spatial.inertia import SpatialWork
from lcpflex.dynamics.spatial.mechanics import whiten_rows
from lcpflex.jit.kernel import kernel
from lcpflex.model.spatial import SpatialModel

__all__ = ["prepare_large"]


@kernel
def prepare_large(model: SpatialModel, work: SpatialWork) -> None:
    """Rows by L^-1 where there are large islands."""
    for i in range(work.posed.islands.count):
        if is_large(work, i) and len(work.rows.white) > 0:
            whiten_rows(model, work.rows, 0, work.rows.n_joint + work.rows.n_contacts + work.rows.n_tangents)
            return
