"""The same scene with other bodies: everything that was made on a body is made again on the one in its place.

An initial deformation d(x) = Phi_old(x)^T q of a body is split by the new one into motion of its frame and its own
modal coordinates (:meth:`lcpflex.bodies.body.Body.project`); so is its rate. In space the new body follows it by its
modes alone (:mod:`lcpflex.scene.spatial.carried`). With the split (d0, delta, q') of the
deformation and (v0, nu, q'') of its rate, in body axes,

    R' = R + A d0,  angle' = angle + delta,   Rdot' = Rdot + A (v0 + omega J d0),  omega' = omega + nu
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from lcpflex.basics.arguments import listed
from lcpflex.bodies.body import Body, named
from lcpflex.bodies.placed_point import PlacedPoint
from lcpflex.errors import ModelError, shown
from lcpflex.jit.kernel import FloatArray
from lcpflex.model.planar import N_RIGID
from lcpflex.scene.handles import Placed
from lcpflex.scene.placed_body import PlacedBody
from lcpflex.scene.placed_surface import PlacedSurface
from lcpflex.scene.sensors.sensor import body_name

if TYPE_CHECKING:
    from lcpflex.scene.declared import Parts
    from lcpflex.scene.register import Start
    from lcpflex.scene.scene import Scene
    from lcpflex.scene.spatial.handles import SpatialPlaced
    from lcpflex.scene.spatial.scene import SpatialParts, SpatialScene

__all__ = ["exchanged", "one_with", "remade", "same_basis", "settled"]

AnyScene = TypeVar("AnyScene", bound="Scene | SpatialScene")


def exchanged(scene: AnyScene, bodies: Mapping[str, Any]) -> AnyScene:
    """A new scene with ``bodies`` in the place of those of the same names; ``scene`` is not changed.

    Of an initial deformation is carried over what the new bodies can follow.
    """
    parts = scene.parts()
    known = [placed.name for placed in parts.placed]
    for name, body in named("bodies", bodies).items():
        if name not in known:
            raise ModelError(f"bodies: no body {name!r}, expected one of {listed(known)}")
        if not isinstance(body, scene._kind):
            raise ModelError(f"bodies[{name!r}]: {shown(body)} was given, expected a {scene._kind.__name__}")
    return remade(scene, [one_with(placed, bodies.get(placed.name), lossy=True) for placed in parts.placed])


def one_with(placed: Placed | SpatialPlaced, body: Any | None, lossy: bool = False) -> tuple[Any, Start]:
    """A body, or the order of one, for the place of another with its motion; ``body`` None: the same as before.

    lossy: whether a body of space may follow a deformation in part.
    """
    if body is None:
        return placed.order or placed.source, placed.start
    return body, _start(placed, body, lossy)


def settled(scene: AnyScene) -> AnyScene:
    """The scene with its initial state projected onto its joints; itself where that fulfils them, or nothing can."""
    scene = scene.reduced()  # type: ignore[assignment]
    try:
        scene.compiled()
    except ModelError:
        try:
            compiled = scene.compiled(project=True)
        except ModelError:
            return scene  # which says itself what is wrong, when it is run
        placed: tuple[Any, ...] = scene.parts().placed
        ends = [np.cumsum([len(one.start[k]) for one in placed])[:-1] for k in range(2)]
        starts = zip(placed, np.split(compiled.q, ends[0]), np.split(compiled.u, ends[1]), strict=True)
        return remade(scene, [(one.source, (q, u)) for one, q, u in starts])
    return scene


def remade(scene: AnyScene, bodies: Sequence[tuple[Any, Start]], joints: Mapping[str, Any] | None = None) -> AnyScene:
    """The scene with these bodies and initial states in the order of its own; for orders, bodies are reduced later.

    joints: by their names, in the place of those of the scene, with its points.

    The state of an order is that of the body before it is reduced, without modal coordinates.
    """
    parts = scene.parts()
    new: Any = type(scene)(scene.gravity)
    placed: Any
    for placed, (body, start) in zip(parts.placed, bodies, strict=True):
        if isinstance(body, scene._kind):
            new._put(placed.name, body, start, None)
        else:
            new._put(placed.name, placed.source, start, body)
    every: dict[str, Any] = {**parts.joints, **(joints or {})}
    _Again(new).declare(parts._replace(joints=every))
    made: AnyScene = new
    return made


class _Again:
    """Makes the parts of one scene on the bodies of another."""

    def __init__(self, new: Any) -> None:
        self._new = new
        self._bodies: dict[int, Any] = {-1: new.ground} | {placed.body: placed for placed in new.parts().placed}
        self._surfaces: dict[int, PlacedSurface] = {}

    def declare(self, parts: Parts | SpatialParts) -> None:
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
            more = {"points": contact.points} if contact.points else {}  # which planar scenes do without
            self._new.contact(a, b, *numbers, name=name, node_side=node_side, law=contact.law, **more)
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

    def _side(self, side: PlacedBody | PlacedSurface) -> Any:
        return self._bodies[side.body] if isinstance(side, PlacedBody) else self._surface(side)


def _start(placed: Placed | SpatialPlaced, body: Any, lossy: bool) -> Start:
    """Initial configuration and velocity of ``body`` in the place of the one that is there."""
    q, u = placed.start
    old: Any = placed.source
    if placed.order is not None:
        old = placed.order.body(())
        q, u = placed.order.start(placed.start, old)
    if not isinstance(placed, Placed):
        from lcpflex.scene.spatial.carried import spatial_start

        return spatial_start(placed.name, old, (q, u), body, lossy)
    if same_basis(old, body):
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


def same_basis(old: Any, new: Any) -> bool:
    """Whether the coordinates of both mean the same: made alike, or the same body; of bodies of one dimension."""
    if old is new:
        return True
    arrays = ("a", "c") if isinstance(old, Body) else ("first", "products")
    return all(
        np.array_equal(getattr(old, name), getattr(new, name))
        for name in ("mass", "inertia", "moment", "S", "stiffness", "damping", *arrays)
    )
