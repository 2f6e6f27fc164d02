"""Where the modes of a body give way less than its mesh does: at joints, loads and contacts, when a scene is compiled.

With C the static compliance (3, 3) of the whole mesh at a place, in unit forces and a unit moment, and C_k = Phi^T
Omega^-2 Phi that of the modes kept, the deficit in the rows D that act there is

    the largest mu of D^T (C - C_k) D f = mu D^T C D f

one row for a force whose direction is known, two for one in any direction, a third for the moment that it makes on the
radius of a disc; and apart from these one for a moment of its own: a beam that is held by its angle converges like
1/modes, in frequencies and deflections alike. So it is the way f that misses most of its own compliance: along a
slender beam that is a ten-thousandth of what it gives way across, and all there is where it is struck at its end. Rigid
bodies are rigid by intention. Nothing is known of bodies that tell no compliance of their mesh, such as those that a
user wrote.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from lcpflex.basics.blas import one_thread
from lcpflex.bodies.body import Body
from lcpflex.compile.surface_interfaces import Acting, acting_on
from lcpflex.errors import ModelError

if TYPE_CHECKING:
    from lcpflex.bodies.body import Statics
    from lcpflex.bodies.spatial.body import SpatialBody, SpatialPoint
    from lcpflex.jit.kernel import FloatArray
    from lcpflex.scene.declared import DeclaredContact, Parts
    from lcpflex.scene.spatial.scene import SpatialParts

__all__ = ["LOOKED_AT_ON_FACES", "MISSING", "deficits", "missing_compliance"]

MISSING = 0.01  # of the compliance of the mesh
LOOKED_AT_ON_FACES = 9  # patches of named faces: each costs six solutions of the mesh
ROUNDING = 1e-12  # of the largest coordinate of a place, that is told as 0
NOTHING = 1e-9  # of the largest compliance: none, as along an axis that does not stretch


class Deficit(NamedTuple):
    """What is missing of the compliance in some rows."""

    share: float
    acting: Acting
    rows: FloatArray
    way: FloatArray  # (k,) that misses most, in the rows

    @property
    def place(self) -> tuple[float, ...]:
        """Where [m]."""
        return self.acting.at or _place(self.acting)


def missing_compliance(parts: Parts | SpatialParts, contacts: Mapping[str, DeclaredContact]) -> tuple[str, ...]:
    """A warning for each body that misses more than a hundredth of the compliance of its mesh somewhere."""
    found = []
    body: Any
    for one, body in zip(parts.placed, parts.bodies, strict=True):
        if body.statics is not None and body.modes:
            short = [deficit for acting in _acting(one, body, parts, contacts) for deficit in deficits(body, acting)]
            found += [_said(one.name, body, body.statics, short)] if short else []
    return tuple(found)


def _acting(one: Any, body: Any, parts: Any, contacts: Mapping[str, DeclaredContact]) -> list[Acting]:
    """What acts on a body, at places where it has material."""
    if not isinstance(body, Body):
        from lcpflex.compile.spatial.interfaces import spatial_acting_on  # which planar scenes do without

        every = spatial_acting_on(
            one.body, body, parts.joints, parts.loads, contacts, None, parts.rotation, LOOKED_AT_ON_FACES
        )
        whole = getattr(body.statics, "of_surfaces", False)
        return [acting for acting in every if whole or acting.named or not acting.surface]
    from lcpflex.bodies.reduction.line_interfaces import LineStatics  # which rigid scenes do without

    def snap(x: float, y: float) -> tuple[tuple[float, float], bool]:
        return (x, y), False

    everything = (parts.joints, parts.loads, contacts)
    found = acting_on(
        one.body, *everything, None, snap, isinstance(body.statics, LineStatics), parts.angle, frame=one.frame_point
    )
    return [acting for acting in found if _has(body, acting)]


def _place(acting: Acting) -> tuple[Any, ...]:
    """Where something acts: in the plane coordinates [m], in space what tells the point of the mesh."""
    place = acting.interface.place
    return place if isinstance(place, tuple) and len(place) == 2 else (place,)


def _has(body: Body, acting: Acting) -> bool:
    """Whether a place is on the body: a track beside it or a centre in a hole is carried by it, and not of it."""
    try:
        body.locate(*_place(acting))
    except ModelError:
        return False
    return True


def deficits(body: Body | SpatialBody, acting: Acting) -> tuple[Deficit, ...]:
    """Those above 1 % of something that acts; kept with the mesh, as a scene is compiled for every run."""
    assert body.statics is not None
    modes, known = body.statics.known.get(acting, (None, ()))
    if modes is not body.stiffness:
        with one_thread(len(body.stiffness)):
            known = tuple(deficit for deficit in _compared(body, body.statics, acting) if deficit.share > MISSING)
        body.statics.known[acting] = (body.stiffness, known)
    return tuple(known)


def _compared(body: Body | SpatialBody, statics: Statics, acting: Acting) -> Iterator[Deficit]:
    place = _place(acting)
    point: Any = body.locate(*place) if isinstance(body, Body) else _in_space(body, *place)
    whole = statics.compliance(*place)
    shapes = np.column_stack([point.phi, point.psi])
    missing = whole - shapes.T @ (shapes / body.stiffness[:, None])
    for rows in _rows(acting, len(whole) // 3 + 1):
        soft, ways = np.linalg.eigh(rows.T @ whole @ rows)
        known = soft > NOTHING * soft.max(initial=0.0)
        scaled = ways[:, known] / np.sqrt(soft[known])
        if scaled.size:
            shares, worst = np.linalg.eigh(scaled.T @ rows.T @ missing @ rows @ scaled)
            yield Deficit(float(shares[-1]), acting, rows, scaled @ worst[:, -1])


def _rows(acting: Acting, d: int) -> Iterator[FloatArray]:
    """(3, k), in space (6, k) of the forces that act, with the moments on their arm, and of moments of their own."""
    interface, own = acting.interface, math.isinf(acting.arm)
    unit = np.eye(3 * (d - 1))
    if interface.forces:
        forces = unit[:, :d] if interface.along is None else unit[:, :d] @ np.array(interface.along)[:, None]
        yield np.hstack([forces, acting.arm * unit[:, d:]]) if interface.moment and not own else forces
    if interface.moment and own:
        yield unit[:, d:]


def _in_space(body: SpatialBody, place: Any) -> SpatialPoint:
    from lcpflex.bodies.spatial.interfaces import point_at

    return point_at(body, place)


def _said(name: str, body: Body | SpatialBody, statics: Statics, short: Sequence[Deficit]) -> str:
    worst = max(short, key=lambda deficit: deficit.share)
    free = body.modes - body.residual_modes
    more = sum(deficit.rows.shape[1] for deficit in short)
    enough = max(statics.enough(_place(one.acting), (one.rows @ one.way)[:, None], MISSING) for one in short)
    least = ROUNDING * max(map(abs, worst.place))
    at = ", ".join(f"{value if abs(value) > least else 0.0:.4g}" for value in worst.place)
    kept = f"{free} free and {body.residual_modes} residual modes" if body.residual_modes else f"{free} modes"
    remedy = (
        f"scene.add(unreduced, modes={free}), or interfaces= of its reduce(), adds what is missing, at most {more} "
        f"residual mode{'' if more == 1 else 's'}"
    )
    if body.residual_modes and worst.acting.interface.contact:
        remedy = "more contact_nodes= of scene.add, a smaller surface or more free modes would do"
    if worst.acting.surface and not isinstance(body, Body):
        remedy = "its reduce(contact=...) with the nodes that touch has it, contact_nodes= of scene.add some of it"
        if worst.acting.named:
            count = free if body.reduction is None else body.reduction.modes
            remedy = f"scene.add(unreduced, modes={count}), or contact= of its reduce() with that face, has it"
    return (
        f"body {name!r}: its {kept} give way {100.0 * worst.share:.3g} % less than its mesh to {_way(worst)} of "
        f"{worst.acting.name} at ({at}): {remedy}" + (f"; so would {enough} free modes" if enough else "")
    )


def _way(deficit: Deficit) -> str:
    """The force or moment that misses most, in words."""
    way = deficit.rows @ deficit.way
    d = len(way) // 3 + 1
    if d == 3:
        return _spatial_way(*np.split(way, 2))
    x, y, _ = way
    size = math.hypot(x, y)
    if size == 0.0:
        return "the moment"
    x, y = (round(float(value), 2) + 0.0 for value in (x / size, y / size))
    return f"a force along ({abs(x):g}, {y if x >= 0.0 else -y:g})" if x else "a force along (0, 1)"


def _spatial_way(force: FloatArray, moment: FloatArray) -> str:
    """The same in space: the direction of the force, or of the moment where there is none."""
    kind, found = ("a force", force) if force.any() else ("a moment", moment)
    rounded = np.round(found / np.linalg.norm(found), 2) + 0.0
    first = rounded[np.flatnonzero(rounded)[0]]
    return f"{kind} along ({', '.join(f'{value:g}' for value in (rounded if first > 0.0 else 0.0 - rounded))})"
