"""What motions are measured in: metres of the places of each body, over the size of a scene."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.basics.lengths import lengths
from lcpflex.jit.kernel import FloatArray
from lcpflex.model.layout import PLANE, dimension, is_spatial, place_offsets

if TYPE_CHECKING:
    from lcpflex.model.arrays import Model
    from lcpflex.results.result import Result

__all__ = ["Units", "has_moved", "scene_size"]

MOVED = 1e-3  # of the size of the scene: what has moved by less has not, by any point of a body


class Units:
    """What motions are measured in: metres of the places of each body, or each coordinate of a user's own system."""

    def __init__(self, model: Any, ndof: int) -> None:
        self._bodies: list[tuple[int, int, float, FloatArray]] = []
        self.own = len(model.bodies.mass) == 0
        self.count = ndof if self.own else len(model.bodies.mass)
        points, contacts, dof = model.points, model.contacts, model.bodies.dof
        self._size = dimension(model.bodies)
        for b in range(len(model.bodies.mass)):
            ids = np.flatnonzero(points.body == b)
            extent = float(np.max(lengths(points.place[ids]), initial=0.0))
            if self._size is not PLANE:  # a body that turns is no point, whatever is known of it
                extent = max(extent, math.sqrt(float(np.trace(model.bodies.second[b])) / float(model.bodies.mass[b])))
            for s in np.flatnonzero(contacts.surface_body == b):
                reach = float(lengths(contacts.surface_center[s]) + contacts.surface_extent[s])
                extent = max(extent, reach if math.isfinite(reach) else 0.0)
            shapes = [points.phi[points.start[p] : points.start[p + 1]].T for p in ids]
            modes = int(dof[b + 1] - dof[b]) - self._size.rigid
            phi = np.concatenate(shapes) if shapes else np.zeros((0, modes))
            self._bodies.append((int(dof[b]), int(dof[b + 1]), extent, phi))

    def extent(self, body: int) -> float:
        """Farthest point of a body from its origin [m]."""
        return self._bodies[body][2]

    def of(self, change: FloatArray) -> FloatArray:
        """By how much changes (..., ndof) of the coordinates move places, at most: (..., count)."""
        if self.own:
            return np.asarray(np.abs(change))
        moved = np.zeros((*change.shape[:-1], self.count))
        for b in range(self.count):
            moved[..., b] = self._as_rigid(b, change)
            if self._bodies[b][3].size:
                moved[..., b] += self._bent(b, change)
        return moved

    def parts(self, change: FloatArray) -> tuple[FloatArray, FloatArray]:
        """By how much small changes move the point of a body that they move farthest, (..., count) each.

        Without the rotation of the body, and that times its extent. Modes count with their signs.
        """
        components, rigid = self._size.components, self._size.rigid
        moved, turned = np.zeros((2, *change.shape[:-1], self.count))
        for b, (first, last, extent, phi) in enumerate(self._bodies):
            moved[..., b] = lengths(change[..., first : first + components])
            turned[..., b] = extent * lengths(change[..., first + components : first + rigid])
            if phi.size:
                bent = change[..., first + rigid : last] @ phi.T
                places = bent.reshape(*bent.shape[:-1], phi.shape[0] // components, components)
                moved[..., b] += lengths(places).max(axis=-1)
        return moved, turned

    def _as_rigid(self, b: int, change: FloatArray) -> FloatArray:
        """Of body b, without its modes."""
        _, rigid, components = self._size
        first, _, extent, _ = self._bodies[b]
        moved = lengths(change[..., first : first + components])
        return np.asarray(moved + extent * lengths(change[..., first + components : first + rigid]))

    def _bent(self, b: int, change: FloatArray) -> FloatArray:
        """What the modes of body b add at the point that they move farthest, all taken as of one sign."""
        first, last, _, phi = self._bodies[b]
        components = self._size.components
        bent = np.abs(change[..., first + self._size.rigid : last]) @ np.abs(phi.T)
        places = bent.reshape(*bent.shape[:-1], phi.shape[0] // components, components)
        return np.asarray(lengths(places).max(axis=-1))


def scene_size(result: Result) -> float | None:
    """Largest extent of a body [m]; None for a system of the user's own or for bodies without outlines."""
    if result.compiled is None:
        return None
    if result.compiled.spatial:
        return result.compiled.size
    points = result.compiled.model.points
    extents = [np.ptp(points.place[points.body == b], axis=0).max() for b in np.unique(points.body) if b >= 0]
    extents += [2.0 * radius for _, radius in result.compiled.layout.circles]
    largest = float(max(extents, default=0.0))
    return largest if largest > 0.0 else None


def has_moved(model: Model, q: FloatArray, u: FloatArray, size: float) -> bool:
    """Whether any point of a body was MOVED ``size`` [m] away from where it began, by q and u (m, ndof)."""
    numbers = dimension(model.bodies)
    units = Units(model, u.shape[1])
    with np.errstate(all="ignore"):  # what is not finite has moved
        moved = units.of(_modal(model, q - q[:1]))
        for b, place in enumerate(place_offsets(model.bodies)[:-1].tolist()):
            away = q[:, place : place + numbers.places] - q[0, place : place + numbers.places]
            # an angle, or twice the change of four numbers, which is no less for one
            turned = lengths(away[:, numbers.components :]) * (2.0 if is_spatial(model) else 1.0)
            moved[:, b] += lengths(away[:, : numbers.components]) + 0.5 * size * turned
    return not float(moved.max(initial=0.0)) <= MOVED * size


def _modal(model: Model, q: FloatArray) -> FloatArray:
    """Modal coordinates of q (m, nq) in the places of their rates (m, ndof); what is there else has no stiffness."""
    bodies = model.bodies
    place, size = place_offsets(bodies), dimension(bodies)
    found = np.zeros((len(q), int(bodies.dof[-1])))
    for b, (d, end) in enumerate(pairwise(bodies.dof.tolist())):
        found[:, d + size.rigid : end] = q[:, int(place[b]) + size.places : int(place[b + 1])]
    return found
