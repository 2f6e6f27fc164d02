"""The bodies of a scene as arrays, what they are drawn as, and how large they are."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from lcpflex.bodies.body import Body, Chain, Shortening
from lcpflex.compile.assembly import Assembly
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.model.arrays import Bodies, Model, frozen
from lcpflex.model.planar import N_RIGID
from lcpflex.scene.handles import Placed
from lcpflex.scene.placed_surface import PlacedSurface

__all__ = ["compile_bodies", "drawn_shapes", "scene_size"]


def compile_bodies(sources: Sequence[Body]) -> Bodies:
    """Inertia, stiffness and damping of all bodies, one after the other."""

    def joined(pick: Callable[[Body], object], columns: int = 0) -> FloatArray:
        parts = [np.asarray(pick(body), dtype=float).reshape((-1, columns) if columns else -1) for body in sources]
        return frozen(np.concatenate(parts), columns=columns)

    def square(pick: Callable[[Body], FloatArray | None]) -> tuple[IntArray, FloatArray]:
        flat = [np.zeros(0) if pick(body) is None else np.ravel(np.asarray(pick(body))) for body in sources]
        return frozen(np.cumsum([0, *(part.size for part in flat)]), np.int64), frozen(np.concatenate(flat))

    def listed(pick: Callable[[Shortening], IntArray]) -> tuple[IntArray, IntArray]:
        parts = [np.zeros(0) if body.shortening is None else pick(body.shortening) for body in sources]
        return frozen(np.cumsum([0, *map(len, parts)]), np.int64), frozen(np.concatenate(parts), np.int64)

    coupling_start, coupling = square(lambda body: body.coupling)
    cross_start, cross = square(lambda body: body.cross_damping)
    geometric_start, geometric = square(lambda body: body.geometric)
    shortening_start, shortening = square(lambda body: body.shortening.matrices if body.shortening else None)
    axial_start, axial = listed(lambda of: of.axial)
    bending_start, bending = listed(lambda of: of.bending)
    return Bodies(
        dof=frozen(np.cumsum([0, *(N_RIGID + body.modes for body in sources)]), np.int64),
        mass=joined(lambda body: body.mass),
        inertia=joined(lambda body: body.inertia),
        moment=joined(lambda body: body.moment, 2),
        S=joined(lambda body: body.S, 2),
        a=joined(lambda body: body.a),
        c=joined(lambda body: body.c),
        stiffness=joined(lambda body: body.stiffness),
        damping=joined(lambda body: body.damping),
        coupling_start=coupling_start,
        coupling=coupling,
        cross_damping_start=cross_start,
        cross_damping=cross,
        geometric_start=geometric_start,
        geometric=geometric,
        axial_start=axial_start,
        axial_mode=axial,
        bending_start=bending_start,
        bending_mode=bending,
        shortening_start=shortening_start,
        shortening=shortening,
    )


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
    places = [points.place[points.body == b] for b in range(len(model.bodies.mass))]
    extents = [float(np.ptp(p, axis=0).max()) for p in places if len(p)]
    extents += [2.0 * radius for point, radius in circles if points.body[point] >= 0]
    slaves = model.contacts.slave_point
    moving = points.body[slaves] >= 0
    extents += [2.0 * float(radius) for radius in model.contacts.slave_radius[moving]]
    largest = max(extents, default=0.0)
    if largest > 0.0:
        return largest
    frames = np.vstack([q[model.bodies.dof[:-1, None] + np.arange(2)], points.place[points.body < 0]])
    return float(np.ptp(frames, axis=0).max()) or 1.0
