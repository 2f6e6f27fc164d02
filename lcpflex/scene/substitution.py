"""The same scene with other bodies: everything that was made on a body is made again on the one in its place.

An initial deformation d(x) = Phi_old(x)^T q of a body is split by the new one into motion of its frame and its own
modal coordinates (:meth:`lcpflex.bodies.body.Body.project`); so is its rate. With the split (d0, delta, q') of the
deformation and (v0, nu, q'') of its rate, in body axes,

    R' = R + A d0,  angle' = angle + delta,   Rdot' = Rdot + A (v0 + omega J d0),  omega' = omega + nu
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.basics.arguments import listed
from lcpflex.bodies.body import Body, named
from lcpflex.bodies.placed_point import PlacedPoint
from lcpflex.errors import ModelError, shown
from lcpflex.jit.kernel import FloatArray
from lcpflex.model.planar import N_RIGID
from lcpflex.scene.handles import Placed
from lcpflex.scene.placed_surface import PlacedSurface
from lcpflex.scene.sensors.sensor import body_name

if TYPE_CHECKING:
    from lcpflex.scene.compiling import ReductionOrder
    from lcpflex.scene.declared import Parts
    from lcpflex.scene.scene import Scene

__all__ = ["exchanged", "remade", "settled"]


def exchanged(scene: Scene, bodies: Mapping[str, Body]) -> Scene:
    """A new scene with ``bodies`` in the place of those of the same names; ``scene`` is not changed."""
    parts = scene.parts()
    known = [placed.name for placed in parts.placed]
    for name, body in named("bodies", bodies).items():
        if name not in known:
            raise ModelError(f"bodies: no body {name!r}, expected one of {listed(known)}")
        if not isinstance(body, Body):
            raise ModelError(f"bodies[{name!r}]: {shown(body)} was given, expected a Body")
    made: list[tuple[Body | ReductionOrder, FloatArray, FloatArray]] = []
    for placed in parts.placed:
        if placed.name not in bodies and placed.order is not None:
            made.append((placed.order, *placed.start))
        elif (body := bodies.get(placed.name, placed.source)) is not None:
            made.append((body, *_start(placed, body)))
    return remade(scene, made)


def settled(scene: Scene) -> Scene:
    """The scene with its initial state projected onto its joints; itself where that fulfils them, or nothing can."""
    scene = scene.reduced()
    try:
        scene.compiled()
    except ModelError:
        try:
            compiled = scene.compiled(project=True)
        except ModelError:
            return scene  # which says itself what is wrong, when it is run
        placed = scene.parts().placed
        ends = np.cumsum([len(one.start[0]) for one in placed])[:-1]
        starts = zip(placed, np.split(compiled.q, ends), np.split(compiled.u, ends), strict=True)
        return remade(scene, [(one.source, q, u) for one, q, u in starts if one.source is not None])
    return scene


def remade(scene: Scene, bodies: Sequence[tuple[Body | ReductionOrder, FloatArray, FloatArray]]) -> Scene:
    """The scene with these bodies and initial states in the order of its own; some may be reduced later."""
    parts = scene.parts()
    new = type(scene)(scene.gravity)
    for placed, (body, q, u) in zip(parts.placed, bodies, strict=True):
        if isinstance(body, Body):
            new.add(body, placed.name, q[:2], float(q[2]), u[:2], float(u[2]), q[N_RIGID:], u[N_RIGID:])
        else:
            new._put(placed, body)
    _Again(scene, new).declare(parts)
    return new


class _Again:
    """Makes the parts of one scene on the bodies of another."""

    def __init__(self, old: Scene, new: Scene) -> None:
        self._old = old
        self._new = new
        self._bodies = {-1: new.ground} | {placed.body: placed for placed in new.parts().placed}
        self._surfaces: dict[int, PlacedSurface] = {}

    def declare(self, parts: Parts) -> None:
        """All of them, in their order: what is numbered gets the same number."""
        for surface in parts.surfaces:
            self._surface(surface)
        for name, joint in parts.joints.items():
            self._new.join(replace(joint, name=name, **self._points(joint)))
        for load in parts.loads:
            self._new.load(replace(load, **self._points(load)))
        for name, contact in parts.contacts.items():
            a, b = (self._surface(surface) for surface in contact.pair)
            numbers = (contact.friction, contact.restitution, contact.tangential_restitution)
            node_side = None if contact.node_side is None else self._surface(contact.node_side)
            self._new.contact(a, b, *numbers, name=name, node_side=node_side, law=contact.law)
        for rule in parts.rules:
            self._new.contact_all(
                rule.friction, rule.restitution, rule.tangential_restitution,
                [(self._side(x), self._side(y)) for x, y in rule.exclude], law=rule.law,
            )  # fmt: skip

        for name, sensor in parts.sensors.items():
            body = {"body": body_name(sensor)} if hasattr(sensor, "body") else {}
            self._new.sensor(replace(sensor, name=name, **body, **self._points(sensor)))

    def _points(self, part: Any) -> dict[str, Any]:
        points: dict[str, PlacedPoint | None] = {name: getattr(part, name, None) for name in ("P", "Q")}
        return {name: P.again(self._bodies[P.body]) for name, P in points.items() if P is not None}

    def _surface(self, surface: PlacedSurface) -> PlacedSurface:
        key = id(surface)  # the old scene keeps it alive
        if key not in self._surfaces:
            self._surfaces[key] = surface.again(self._bodies[surface.body])
        return self._surfaces[key]

    def _side(self, side: Placed | PlacedSurface) -> Placed | PlacedSurface:
        return self._bodies[side.body] if isinstance(side, Placed) else self._surface(side)


def _start(placed: Placed, body: Body) -> tuple[FloatArray, FloatArray]:
    """Initial configuration and velocity (3 + n,) of ``body`` in the place of the one that is there."""
    q, u = placed.start
    old = placed.source
    assert old is not None
    if placed.order is not None:
        old = placed.order.body(())
        q, u = placed.order.start(placed.start, old)
    if _same_basis(old, body):
        return q, u
    if not (q[N_RIGID:].any() or u[N_RIGID:].any()):
        still = np.zeros(body.modes)
        return np.concatenate([q[:N_RIGID], still]), np.concatenate([u[:N_RIGID], still])
    d0, delta, modal = _split(old, body, q[N_RIGID:])
    v0, nu, rate = _split(old, body, u[N_RIGID:])
    cos, sin = np.cos(q[2]), np.sin(q[2])
    turn = np.array([[cos, -sin], [sin, cos]])
    carried = v0 + u[2] * np.array([-d0[1], d0[0]])
    return (
        np.concatenate([q[:2] + turn @ d0, [q[2] + delta], modal]),
        np.concatenate([u[:2] + turn @ carried, [u[2] + nu], rate]),
    )


def _split(old: Body, new: Body, modal: FloatArray) -> tuple[FloatArray, float, FloatArray]:
    """The displacement field of modal coordinates of ``old`` as motion of the frame and coordinates of ``new``."""

    def displacement(x: float, y: float) -> tuple[float, float]:
        dx, dy = modal @ old.locate(x, y).phi
        return float(dx), float(dy)

    dx, dy, angle, found = new.project(displacement)
    return np.array([dx, dy]), angle, found


def _same_basis(old: Body, new: Body) -> bool:
    """Whether the coordinates of both mean the same: made alike, or the same body."""
    if old is new:
        return True
    arrays = ("moment", "S", "a", "c", "stiffness", "damping")
    return (old.mass, old.inertia) == (new.mass, new.inertia) and all(
        np.array_equal(getattr(old, name), getattr(new, name)) for name in arrays
    )
