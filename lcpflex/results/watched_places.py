"""Undeformed places of bodies that are watched: between them they see a body translate, turn and bend."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from lcpflex.compile.material import material_points
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray
from lcpflex.model.layout import SPACE, dimension

if TYPE_CHECKING:
    from lcpflex.compile.compiled_scene import CompiledScene

__all__ = ["gyration", "known_places", "two_places"]

NEAR = 1e-9  # of the extent of a body: places that are one


def two_places(
    compiled: CompiledScene, ends: Sequence[str] = (), other: CompiledScene | None = None
) -> list[tuple[str, tuple[float, ...]]]:
    """Undeformed places [m], two for each body (in space three), that between them see it translate, turn and bend.

    Of bodies in ``ends`` they are the ends of what is known of them even if they are rigid. ``other``: a scene of the
    same bodies with other modes, in which the places have to be known, too.

    Raises
    ------
    ModelError
        For a flexible body of which no point is known.
    """
    return [(body, place) for body in compiled.layout.bodies for place in _two_of(compiled, body, body in ends, other)]


def known_places(compiled: CompiledScene, b: int, other: CompiledScene | None = None) -> FloatArray:
    """(k, 2), in space (k, 3): undeformed places of the material points of a body, also known of it in ``other``."""
    own: FloatArray = compiled.model.points.place[material_points(compiled, b)]
    if other is None or not len(own):
        return own
    theirs = known_places(other, b)
    near = NEAR * float(np.ptp(own, axis=0).max())
    return own[[bool(len(theirs)) and float(np.linalg.norm(theirs - place, axis=1).min()) <= near for place in own]]


def gyration(compiled: CompiledScene, b: int) -> float:
    """Radius of gyration of a body about the origin of its frame [m]; in space that of its mass about a point."""
    bodies = compiled.model.bodies
    second = float(np.trace(bodies.second[b])) if dimension(bodies) is SPACE else float(bodies.inertia[b])
    return float(np.sqrt(second / bodies.mass[b]))


def _two_of(compiled: CompiledScene, body: str, ends: bool, other: CompiledScene | None) -> list[tuple[float, ...]]:
    model = compiled.model
    size = dimension(model.bodies)
    b = compiled.layout.bodies.index(body)
    own = known_places(compiled, b, other)
    if model.bodies.dof[b + 1] - model.bodies.dof[b] == size.rigid and not (ends and len(own)):
        arm = gyration(compiled, b)
        if size is SPACE:
            return [(0.0, 0.0, 0.0), (arm, 0.0, 0.0), (0.0, arm, 0.0)]
        return [(0.0, 0.0), (arm, 0.0)]
    if not len(own):
        where = "" if other is None else " in both scenes"
        raise ModelError(
            f"outputs: the flexible body {body!r} has no point whose motion is known{where}, expected a named point, a "
            "contact, joint, load or sensor on it, or outputs of your own"
        )
    first = own[np.linalg.norm(own - own.mean(axis=0), axis=1).argmax()]
    last = own[np.linalg.norm(own - first, axis=1).argmax()]
    chosen = [first, last]
    if size is SPACE:  # what turns about the line between them
        along = (last - first) / max(float(np.linalg.norm(last - first)), np.finfo(float).tiny)
        across = (own - first) - np.outer((own - first) @ along, along)
        chosen.append(own[np.linalg.norm(across, axis=1).argmax()])
    return [tuple(map(float, place)) for place in chosen]
