"""The patch of a contact in space: pressure, area and radius, from its touching points.

A force F_k at a touching point is a pressure p_k = F_k / A_k where it is that of an area A_k: of the mean of a face
about a node, weighted by the hat of the node, or of a node of a linear face, A_k then being the integral of that hat.
At nodes of quadratic faces it is none: a uniform pressure gives their corners a twelfth of what it gives the middles of
their sides, no force at all, or a pull. Their forces have a radius alone, by the second moment of their distribution,

    a^2 = 5/2 sum F_k r_k^2 / sum F_k,    r_k from the place sum F_k x_k / sum F_k,

which of Hertz's pressure, p_0 (1 - (r/a)^2)^1/2 with <r^2> = 2 a^2 / 5, is the radius of its circle.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lcpflex.errors import ModelError

if TYPE_CHECKING:
    from lcpflex.jit.kernel import FloatArray, IntArray
    from lcpflex.results.contact_history import ContactPoints

__all__ = ["areas_of", "pressures_of", "radii_of"]

OF_HERTZ = 2.5  # a^2 over the mean square of the distance
WANTED = (
    'expected forces on areas: take scene.contact(..., points="areas") with body.face(name) of a flexible solid, whose '
    'face "surface" is all of it, or nodes of faces of 8-node hexahedra; forces at nodes of quadratic faces, of whole '
    "surfaces and rigid bodies, and at edges are no pressures"
)


def pressures_of(points: ContactPoints, name: str, t: float) -> tuple[FloatArray, FloatArray]:
    """Places (k, 3) and pressures (k,) of the touching points of one instant.

    Those without a force and without an area are left out: of these nothing is known, and nothing asked.

    Raises
    ------
    ModelError
        Where a force acts on no area, and in the plane.
    """
    _check_areas(points, name, f"at t = {t:.6g} s")
    on_areas = points.area > 0.0
    return points.place[on_areas], points.force[on_areas, 0] / points.area[on_areas]


def areas_of(points: ContactPoints, name: str, instants: int) -> FloatArray:
    """(m,) sum of the areas of the touching points that press at each instant. Raises ModelError as above."""
    _check_areas(points, name, "of the contact")
    pressed = points.force[:, 0] > 0.0
    return _sums(points.record[pressed], points.area[pressed], instants)


def radii_of(points: ContactPoints, name: str, instants: int) -> FloatArray:
    """(m,) radius by the distribution of the forces at each instant; 0 where none presses.

    Raises
    ------
    ModelError
        In the plane, where a patch is a line, and in a system of the user's own, whose contacts have no places.
    """
    _check_space(points, name)
    pressed = points.force[:, 0] > 0.0
    record, place, force = points.record[pressed], points.place[pressed], points.force[pressed, 0]
    if not np.isfinite(place).all():
        raise ModelError(f"contact {name!r}: its touching points have no places; expected a contact of a Scene")
    largest = np.zeros(instants)
    np.maximum.at(largest, record, force)
    share = force / largest[record]  # sums of these overflow in no unit
    total = _sums(record, share, instants)
    share /= total[record]
    centre = np.stack([_sums(record, share * x, instants) for x in place.T], axis=1)
    square = np.sum((place - centre[record]) ** 2, axis=1)
    return np.asarray(np.sqrt(OF_HERTZ * _sums(record, share * square, instants)))


def _sums(record: IntArray, values: FloatArray, instants: int) -> FloatArray:
    """(m,) of the values (k,) of each instant."""
    return np.asarray(np.bincount(record, values, minlength=instants), dtype=float)


def _check_space(points: ContactPoints, name: str) -> None:
    if points.place.shape[1] != 3:
        words = "its patch is in the plane, where it is a line; expected a contact of a SpatialScene"
        raise ModelError(f"contact {name!r}: {words}")


def _check_areas(points: ContactPoints, name: str, where: str) -> None:
    _check_space(points, name)
    on_none = np.count_nonzero((points.force[:, 0] != 0.0) & ~(points.area > 0.0))
    if on_none:
        raise ModelError(
            f"contact {name!r}: {on_none} of {len(points.record)} touching points {where} have a force on no area, "
            + WANTED
        )
