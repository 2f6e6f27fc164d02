"""Mode shapes of the nodes of a surface side by side, as a pass over all of them reads them."""

from __future__ import annotations

from typing import Any

import numpy as np

from lcpflex.model.arrays import frozen
from lcpflex.model.spatial import SpatialContacts, SpatialPoints

__all__ = ["node_shapes"]

SEVERAL = 8  # nodes, from which on it is worth while


def node_shapes(contacts: SpatialContacts, points: SpatialPoints) -> dict[str, Any]:
    """Offsets of the surfaces, and the shapes [mode, x y z, node] of those that have modes and several nodes."""
    found, offsets = [np.zeros(0)], [0]
    for s in range(len(contacts.node_start) - 1):
        nodes = contacts.node_point[contacts.node_start[s] : contacts.node_start[s + 1]]
        if len(nodes) >= SEVERAL:
            shapes = np.array([points.phi[points.start[p] : points.start[p + 1]] for p in nodes])
            found.append(shapes.transpose(1, 2, 0).ravel())
        offsets.append(sum(map(len, found)))
    return {"shape_start": frozen(offsets, np.int64), "node_shape": frozen(np.concatenate(found))}
