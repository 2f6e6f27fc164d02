"""Spatial bodies as points and cells that move with them, for other programs: their surfaces as triangles.

A body of unknown shape is its named points, or its origin where it has none.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.kinematics.places import material_shapes, modal_sum
from lcpflex.kinematics.spatial.frames import rotated
from lcpflex.model.recovery import MeshShapes
from lcpflex.model.spatial import N_PLACE, N_RIGID
from lcpflex.results.shapes_of_scenes import ELEMENTS, VERTEX, Motion, Shape
from lcpflex.results.spatial.facets import facets_of

if TYPE_CHECKING:
    from lcpflex.compile.compiled_scene import CompiledScene
    from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["spatial_motion", "spatial_shapes"]


def spatial_shapes(compiled: CompiledScene) -> list[Shape]:
    """One of each body, in their order."""
    return [_shape(compiled, b) for b in range(len(compiled.layout.bodies))]


def _shape(compiled: CompiledScene, b: int) -> Shape:
    model, known = compiled.model, compiled.layout.shapes[b]
    n = int(model.bodies.dof[b + 1] - model.bodies.dof[b]) - N_RIGID
    facets = None if known is None else facets_of(known)
    if facets is not None:
        triangles = tuple((ELEMENTS["triangle"], tuple(ids)) for ids in facets.triangles.tolist())
        phi = facets.phi if facets.phi.shape[1] else np.zeros((len(facets.vertices), n, 3))
        meshed = bool(compiled.recovery) and isinstance(compiled.recovery[b], MeshShapes)
        at = np.arange(len(facets.vertices)) if meshed else None  # its vertices are the nodes
        return Shape(np.full(len(facets.vertices), b), facets.vertices, phi, triangles, at)
    own: IntArray = np.array(
        [p for (name, _), p in compiled.layout.points.items() if name == compiled.layout.bodies[b]]
    )
    places, phi = np.zeros((1, 3)), np.zeros((1, n, 3))
    if len(own) and not n:
        places, phi = model.points.place[own], np.zeros((len(own), 0, 3))
    elif len(own):
        places, phi = model.points.place[own], material_shapes(model, own)
    vertices = tuple((VERTEX, (k,)) for k in range(len(places)))
    return Shape(np.full(len(places), b), places, phi, vertices)


def spatial_motion(model: Any, shape: Shape, q: FloatArray, u: FloatArray) -> Motion:
    """r = R + A (x + Phi eta), its rate v + A (omega x s + Phi etadot) and A Phi eta over q (m, nq), u (m, nu)."""
    b, n = int(shape.owner[0]), shape.phi.shape[1]
    k, d = int(model.bodies.place[b]), int(model.bodies.dof[b])
    p = q[:, None, k + 3 : k + N_PLACE]
    bent = modal_sum(q[:, None, k + N_PLACE : k + N_PLACE + n], shape.phi)
    rate = modal_sum(u[:, None, d + N_RIGID : d + N_RIGID + n], shape.phi)
    s = shape.places + bent
    swept = np.cross(u[:, None, d + 3 : d + N_RIGID], s) + rate
    places = q[:, None, k : k + 3] + rotated(p, s)
    return Motion(places, u[:, None, d : d + 3] + rotated(p, swept), rotated(p, np.broadcast_to(bent, places.shape)))
