"""Contact forces in the picture of a spatial scene: an arrow each, one scale for a whole run."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from lcpflex.compile.touched_pairs import pair_of
from lcpflex.results.drawn_forces import CUT, SEEN, arrow_length, usual_force

if TYPE_CHECKING:
    from collections.abc import Mapping

    from lcpflex.compile.compiled_scene import CompiledScene
    from lcpflex.jit.kernel import FloatArray, IntArray
    from lcpflex.results.result import Result

__all__ = ["Arrow", "ContactArrows"]


class Arrow(NamedTuple):
    """One contact force."""

    foot: FloatArray  # (3,) [m], where the bodies touch
    tip: FloatArray  # (3,) [m]
    force: float  # [N]
    cut: bool  # whether it is shorter than the force asks for


class ContactArrows:
    """Arrows of the contact forces of a run.

    An arrow is the force on the body where that touches the ground; where two bodies touch, on the one added later.
    extents: of the bodies that are drawn [m]. bare: without those of forces on areas.
    """

    def __init__(
        self, result: Result, compiled: CompiledScene, extents: Mapping[int, float], bare: bool = False
    ) -> None:
        every = result.contact_points
        self._points = every.take(np.flatnonzero(every.area <= 0.0)) if bare else every
        self._extents = extents
        self.usual = usual_force(self._points)  # [N] its arrow has the usual length
        self._bodies = _bodies_of_contacts(result, compiled)
        self.length = 0.0  # [m] of that arrow

    def measure(self, side: float) -> None:
        """Choose the length of arrows for a picture whose longer side is ``side`` [m]."""
        touching = np.unique(self._bodies[np.unique(self._points.contact)])
        sizes = [size for body in touching.tolist() if (size := self._extents.get(body, 0.0)) > 0.0]
        self.length = arrow_length(side, sizes)

    def at(self, record: int) -> list[Arrow]:
        """Those of a stored instant."""
        if self.usual <= 0.0:
            return []
        points = self._points.at(record)
        first, second = self._bodies[points.contact].T
        vectors = np.where(first > second, 1.0, -1.0)[:, None] * points.vector
        found = []
        for place, vector in zip(points.place, vectors, strict=True):
            size = float(np.linalg.norm(vector))
            if size > SEEN * self.usual:
                along = vector / size * self.length * min(size / self.usual, CUT)
                found.append(Arrow(place, place + along, size, size > CUT * self.usual))
        return found


def _bodies_of_contacts(result: Result, compiled: CompiledScene) -> IntArray:
    """(contacts, 2) bodies of the surfaces of each, as they were declared or in its name; -1: ground."""
    contacts = compiled.model.contacts
    declared = contacts.law_surface
    surfaces = [
        declared[k] if k < len(declared) else pair_of(compiled, name) for k, name in enumerate(result.contact_names)
    ]
    return np.asarray(contacts.surface_body[np.array(surfaces, np.int64).reshape(-1, 2)])
