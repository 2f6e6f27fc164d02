"""The initial state of a body of space that takes the place of another one.

The new modes Psi have the same mesh as the old ones Phi: eta' = Psi^T M Phi eta, exact where they span these, else the
nearest deformation by the kinetic energy of the difference.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray
from lcpflex.model.spatial import N_PLACE, N_RIGID
from lcpflex.scene.substitution import same_basis

if TYPE_CHECKING:
    from lcpflex.bodies.spatial.body import SpatialBody
    from lcpflex.scene.register import Start

__all__ = ["spatial_start"]

LOST = 1e-6  # of a deformation, that other modes of its mesh may miss: rounding


def spatial_start(name: str, old: SpatialBody, start: Start, body: SpatialBody, lossy: bool = False) -> Start:
    """Configuration (7 + n,) and velocity (6 + n,) of ``body`` in the place of ``old`` with its ``start``.

    name: of the body in the scene, for messages. lossy: whether the deformation may be followed in part.

    Raises
    ------
    ModelError
        For an initial deformation that the new body cannot follow, unless ``lossy``, or of another mesh.
    """
    q, u = start
    if same_basis(old, body):
        return q, u
    modal, rate = (_carried(name, old, body, part, lossy) for part in (q[N_PLACE:], u[N_RIGID:]))
    return np.concatenate([q[:N_PLACE], modal]), np.concatenate([u[:N_RIGID], rate])


def _carried(name: str, old: SpatialBody, new: SpatialBody, modal: FloatArray, lossy: bool) -> FloatArray:
    """(n,) coordinates of the new modes for the deformation by the old ones."""
    if not modal.any():
        return np.zeros(new.modes)
    before, after = old.mesh_modes, new.mesh_modes
    if before is None or after is None or before.shapes.shape[0] != after.shapes.shape[0]:
        raise ModelError(f"body {name!r}: its initial deformation cannot be carried over to a body of another mesh")
    field = before.shapes @ modal
    found: FloatArray = after.shapes.T @ (after.mass @ field)
    left = field - after.shapes @ found
    if not lossy and float(left @ (after.mass @ left)) > LOST**2 * float(modal @ modal):
        raise ModelError(f"body {name!r}: the modes of the new body cannot follow its initial deformation")
    return found
