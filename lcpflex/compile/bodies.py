"""The bodies of a scene as arrays, what they are drawn as, and how large they are."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from lcpflex.bodies.body import Body, Chain, Shortening
from lcpflex.compile.assembly import Assembly
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.model.arrays import Bodies, Model, frozen
from lcpflex.model.planar import N_RIGID
from lcpflex.scene.handles import Placed
from lcpflex.scene.placed_surface import PlacedSurface

__all__ = ["compile_bodies", "drawn_shapes", "scene_size"]

NOT_SHORTENING = Shortening(np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros((0, 0, 0)))


def compile_bodies(sources: Sequence[Body]) -> Bodies:
    """Inertia, stiffness and damping of all bodies, one after the other."""

    def joined(name: str, columns: int = 0) -> FloatArray:
        shape = (-1, columns) if columns else -1
        parts = [np.asarray(getattr(body, name), dtype=float).reshape(shape) for body in sources]
        return frozen(np.concatenate(parts), columns=columns)

    arrays: dict[str, Any] = {name: joined(name) for name in ("mass", "inertia", "a", "c", "stiffness", "damping")}
    arrays |= {name: joined(name, 2) for name in ("moment", "S")}
    own = [body.shortening or NOT_SHORTENING for body in sources]
    for name, parts, dtype in (
        ("coupling", [body.coupling for body in sources], float),
        ("cross_damping", [body.cross_damping for body in sources], float),
        ("geometric", [body.geometric for body in sources], float),
        ("shortening", [part.matrices for part in own], float),
        ("axial_mode", [part.axial for part in own], np.int64),
        ("bending_mode", [part.bending for part in own], np.int64),
    ):
        flat = [np.zeros(0) if part is None else np.ravel(part) for part in parts]
        arrays[name.removesuffix("_mode") + "_start"] = frozen(np.cumsum([0, *map(len, flat)]), np.int64)
        arrays[name] = frozen(np.concatenate(flat), dtype)
    return Bodies(dof=frozen(np.cumsum([0, *(N_RIGID + body.modes for body in sources)]), np.int64), **arrays)


def drawn_shapes(
    placed: Sequence[Placed], surfaces: Sequence[PlacedSurface], assembly: Assembly
) -> tuple[tuple[tuple[int, IntArray, bool], ...], tuple[tuple[int, float], ...]]:
    """Outlines and holes (body, points, closed) and circles (point, radius) of the bodies."""
    outlines, circles = [], []
    for p in placed:
        outline = p.source.surfaces.get("outline") if p.source else None
        if isinstance(outline, Chain):
            for chain in (outline, *(p.source.holes() if p.source else ())):
                ids = frozen([assembly.point(p.body, node) for node in chain.points], np.int64)
                outlines.append((p.body, ids, chain.closed))
        elif outline is not None and not outline.hole:
            circles.append((assembly.point(p.body, outline.center), float(outline.radius)))
    circles += [(assembly.point(of.body, of.disc[0]), of.disc[1]) for of in surfaces if of.disc and of.body >= 0]
    return tuple(outlines), tuple(circles)


def scene_size(model: Model, circles: Sequence[tuple[int, float]], q: FloatArray) -> float:
    """Extent of the largest body [m]; of the scene where all bodies are points."""
    points = model.points
    moving = points.body >= 0
    low, high = np.full((2, len(model.bodies.mass), 2), [[[np.inf]], [[-np.inf]]])
    np.minimum.at(low, points.body[moving], points.place[moving])
    np.maximum.at(high, points.body[moving], points.place[moving])
    spans = high - low
    extents = [float(spans.max(initial=0.0))]  # without points, a body spans minus infinity
    extents += [2.0 * radius for point, radius in circles if points.body[point] >= 0]
    nodes = model.contacts.node_point
    extents += [2.0 * float(radius) for radius in model.contacts.node_radius[points.body[nodes] >= 0]]
    largest = max(extents, default=0.0)
    if largest > 0.0:
        return largest
    frames = np.vstack([q[model.bodies.dof[:-1, None] + np.arange(2)], points.place[points.body < 0]])
    return float(np.ptp(frames, axis=0).max()) or 1.0
