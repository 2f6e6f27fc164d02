"""How fine two faces are where they are near each other: what tells which of them touches the other.

Sizes of sub-faces are means of their areas. A face that is graded is finest where it shall touch, and coarse elsewhere,
so that its mean says little: of such, and of what they meet, those sub-faces count that are nearest at the start.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, cast

import numpy as np

from lcpflex.basics import libs

if TYPE_CHECKING:
    from lcpflex.jit.kernel import FloatArray
    from lcpflex.scene.placed_surface import PlacedSurface

__all__ = ["face_area", "sizes_where_near"]

GRADED = 4.0  # of areas of sub-faces: meshes of one size have parts that differ by two or three
NEAR = 2.0  # widths of the nearest sub-faces: as much farther than these from the other face are those that count


def face_area(shape: Any) -> float:
    """Of a face [m^2]."""
    places = np.array([point.place for point in shape.points])
    corners = places[shape.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return float(0.5 * np.linalg.norm(normals, axis=1).sum())


def sizes_where_near(a: PlacedSurface, b: PlacedSurface) -> tuple[float, float]:
    """Mean areas of the sub-faces of two faces [m^2]; where one is graded, of those that are near at the start."""
    (middle, own), (other, theirs) = _sub_faces(a), _sub_faces(b)
    if all(sizes.max() <= GRADED * sizes.min() for sizes in (own, theirs)):
        return face_area(a.shape) / len(own), face_area(b.shape) / len(theirs)
    away, nearest = (np.asarray(column) for column in libs.cKDTree(other).query(middle))
    back = np.asarray(libs.cKDTree(middle).query(other)[0])
    first = int(away.argmin())
    reach = away[first] + NEAR * float(np.sqrt(own[first]) + np.sqrt(theirs[nearest[first]]))
    return float(own[away <= reach].mean()), float(theirs[back <= reach].mean())


def _sub_faces(surface: PlacedSurface) -> tuple[FloatArray, FloatArray]:
    """(k, 3) middles of the sub-faces of a face in the world, as its body is at the start, undeformed; (k,) areas."""
    from lcpflex.bodies.fem.faces import HAT_PARTS, areas_of  # which scenes without faces do without

    shape, bodies = surface.shape, cast(Any, surface.scene).parts()
    places = np.array([point.place for point in shape.points])
    middles, areas = [], []
    for cell in shape.cells:
        parts = np.asarray(cell)[np.asarray(HAT_PARTS[len(cell)])]
        middles.append(places[parts].mean(axis=1))
        areas.append(areas_of(places, parts))
    place = bodies.placed[surface.body].start[0][:3] if surface.body >= 0 else np.zeros(3)
    return place + np.concatenate(middles) @ bodies.rotation(surface.body).T, np.concatenate(areas)
