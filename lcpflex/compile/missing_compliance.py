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
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from lcpflex.basics.blas import one_thread
from lcpflex.compile.surface_interfaces import Acting, acting_on
from lcpflex.errors import ModelError

if TYPE_CHECKING:
    from lcpflex.bodies.body import Body, Statics
    from lcpflex.jit.kernel import FloatArray
    from lcpflex.scene.declared import DeclaredContact, Parts
    from lcpflex.scene.handles import Placed

__all__ = ["MISSING", "deficits", "missing_compliance"]

MISSING = 0.01  # of the compliance of the mesh
NOTHING = 1e-9  # of the largest compliance: none, as along an axis that does not stretch


class Deficit(NamedTuple):
    """What is missing of the compliance in some rows."""

    share: float
    acting: Acting
    rows: FloatArray
    way: FloatArray  # (k,) that misses most, in the rows

    @property
    def place(self) -> tuple[float, float]:
        """Where [m]."""
        return _place(self.acting)


def missing_compliance(parts: Parts, contacts: Mapping[str, DeclaredContact]) -> tuple[str, ...]:
    """A warning for each body that misses more than a hundredth of the compliance of its mesh somewhere."""
    found = []
    for one, body in zip(parts.placed, parts.bodies, strict=True):
        if body.statics is not None and body.modes:
            short = [deficit for acting in _acting(one, body, parts, contacts) for deficit in deficits(body, acting)]
            found += [_said(one.name, body, body.statics, short)] if short else []
    return tuple(found)


def _acting(one: Placed, body: Body, parts: Parts, contacts: Mapping[str, DeclaredContact]) -> list[Acting]:
    """What acts on a body, at places where it has material."""
    from lcpflex.bodies.reduction.line_interfaces import LineStatics  # which rigid scenes do without

    def snap(x: float, y: float) -> tuple[tuple[float, float], bool]:
        return (x, y), False

    everything = (parts.joints, parts.loads, contacts)
    found = acting_on(
        one.body, *everything, None, snap, isinstance(body.statics, LineStatics), parts.angle, frame=one.frame_point
    )
    return [acting for acting in found if _has(body, acting)]


def _place(acting: Acting) -> tuple[float, float]:
    """Where something acts [m]: what acts in a scene has coordinates."""
    place = acting.interface.place
    assert isinstance(place, tuple)
    x, y = place
    return x, y


def _has(body: Body, acting: Acting) -> bool:
    """Whether a place is on the body: a track beside it or a centre in a hole is carried by it, and not of it."""
    try:
        body.locate(*_place(acting))
    except ModelError:
        return False
    return True


def deficits(body: Body, acting: Acting) -> tuple[Deficit, ...]:
    """Those above 1 % of something that acts; kept with the mesh, as a scene is compiled for every run."""
    assert body.statics is not None
    modes, known = body.statics.known.get(acting, (None, ()))
    if modes is not body.stiffness:
        with one_thread(len(body.stiffness)):
            known = tuple(deficit for deficit in _compared(body, body.statics, acting) if deficit.share > MISSING)
        body.statics.known[acting] = (body.stiffness, known)
    return tuple(known)


def _compared(body: Body, statics: Statics, acting: Acting) -> Iterator[Deficit]:
    place = _place(acting)
    point = body.locate(*place)
    whole = statics.compliance(*place)
    shapes = np.column_stack([point.phi, point.psi])
    missing = whole - shapes.T @ (shapes / body.stiffness[:, None])
    for rows in _rows(acting):
        soft, ways = np.linalg.eigh(rows.T @ whole @ rows)
        known = soft > NOTHING * soft.max(initial=0.0)
        scaled = ways[:, known] / np.sqrt(soft[known])
        if scaled.size:
            shares, worst = np.linalg.eigh(scaled.T @ rows.T @ missing @ rows @ scaled)
            yield Deficit(float(shares[-1]), acting, rows, scaled @ worst[:, -1])


def _rows(acting: Acting) -> Iterator[FloatArray]:
    """(3, k) of the forces that act, with the moment that they make on their arm, and of a moment of its own."""
    interface, own = acting.interface, math.isinf(acting.arm)
    if interface.forces:
        along = interface.along
        forces = np.eye(3)[:, :2] if along is None else np.array([[along[0]], [along[1]], [0.0]])
        arm = np.array([[0.0], [0.0], [acting.arm]])
        yield np.hstack([forces, arm]) if interface.moment and not own else forces
    if interface.moment and own:
        yield np.eye(3)[:, 2:]


def _said(name: str, body: Body, statics: Statics, short: Sequence[Deficit]) -> str:
    worst = max(short, key=lambda deficit: deficit.share)
    free = body.modes - body.residual_modes
    more = sum(deficit.rows.shape[1] for deficit in short)
    enough = max(statics.enough(*one.place, (one.rows @ one.way)[:, None], MISSING) for one in short)
    x, y = worst.place
    kept = f"{free} free and {body.residual_modes} residual modes" if body.residual_modes else f"{free} modes"
    remedy = (
        f"scene.add(unreduced, modes={free}), or interfaces= of its reduce(), adds what is missing, at most {more} "
        f"residual mode{'' if more == 1 else 's'}"
    )
    if body.residual_modes and worst.acting.interface.contact:
        remedy = "more contact_nodes= of scene.add, a smaller surface or more free modes would do"
    return (
        f"body {name!r}: its {kept} give way {100.0 * worst.share:.3g} % less than its mesh to {_way(worst)} of "
        f"{worst.acting.name} at ({x:.4g}, {y:.4g}): {remedy}" + (f"; so would {enough} free modes" if enough else "")
    )


def _way(deficit: Deficit) -> str:
    """The force or moment that misses most, in words."""
    x, y, _ = deficit.rows @ deficit.way
    size = math.hypot(x, y)
    if size == 0.0:
        return "the moment"
    x, y = (round(float(value), 2) + 0.0 for value in (x / size, y / size))
    return f"a force along ({abs(x):g}, {y if x >= 0.0 else -y:g})" if x else "a force along (0, 1)"
