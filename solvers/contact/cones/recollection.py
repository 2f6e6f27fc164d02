"""What spatial contacts of the last step tell the problems of the next one: their forces as vectors of the world.

A force that was found on other tangents is projected on the present ones and into the cone. Contacts are found by key
as in the plane (:mod:`lcpflex.solvers.contact.recollection`). Answers within a tolerance have normal forces of -1e-25,
too: such a contact is open, and its cone a point, not one of negative width.
"""

from __future__ import annotations

import math

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.solvers.contact.cones.memory import SpatialRemembered

__all__ = ["keep_force", "known_force"]


@kernel
def known_force(
    known: SpatialRemembered, place: int, normal: FloatArray, tangent: FloatArray, k: int, mu: float
) -> tuple[float, float, float, float]:
    """Normal force, two tangential ones in the cone, and the slip of contact k, which was at ``place`` (-1: is new).

    normal, tangent (contacts, 3): n and t1 of it, t2 = n x t1.
    """
    if place < 0:
        return 0.0, 0.0, 0.0, 0.0
    kept = known.force[known.now, place]
    f, x, y, z, slip = max(kept[0], 0.0), kept[1], kept[2], kept[3], kept[4]
    if not mu > 0.0:
        return f, 0.0, 0.0, 0.0
    a, b, c = tangent[k, 0], tangent[k, 1], tangent[k, 2]
    n_x, n_y, n_z = normal[k, 0], normal[k, 1], normal[k, 2]
    first = x * a + y * b + z * c
    second = x * (n_y * c - n_z * b) + y * (n_z * a - n_x * c) + z * (n_x * b - n_y * a)
    size, bound = math.sqrt(first * first + second * second), mu * f
    if size > bound:
        first, second = first * (bound / size), second * (bound / size)
    return f, first, second, slip


@kernel
def keep_force(
    known: SpatialRemembered,
    at: int,
    key: int,
    normal: FloatArray,
    tangent: FloatArray,
    k: int,
    force: float,
    first: float,
    second: float,
    slip: float,
) -> None:
    """Contact k becomes entry ``at`` of the present step; arrays as of :func:`known_force`."""
    row = 1 - known.now
    a, b, c = tangent[k, 0], tangent[k, 1], tangent[k, 2]
    n_x, n_y, n_z = normal[k, 0], normal[k, 1], normal[k, 2]
    known.key[row, at] = key
    kept = known.force[row, at]
    kept[0], kept[4] = max(force, 0.0), slip
    kept[1] = first * a + second * (n_y * c - n_z * b)
    kept[2] = first * b + second * (n_z * a - n_x * c)
    kept[3] = first * c + second * (n_x * b - n_y * a)
