"""From the objects of a spatial scene to the arrays of a model."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from lcpflex.bodies.spatial.shapes import CapsuleShape, CylinderShape, Shape, SphereShape, SurfaceShape
from lcpflex.compile.compiled_scene import CompiledScene, Layout
from lcpflex.compile.consistency import consistent_start, refuse_overbent, start_apart
from lcpflex.compile.missing_compliance import missing_compliance
from lcpflex.compile.reduced_scene import reduced_scene
from lcpflex.compile.spatial.assembly import SpatialAssembly
from lcpflex.compile.spatial.bodies import compile_spatial_bodies
from lcpflex.compile.spatial.contacts import compile_spatial_contacts
from lcpflex.compile.spatial.joints import compile_spatial_joints
from lcpflex.compile.spatial.loads import compile_spatial_loads
from lcpflex.compile.spatial.sensors import compiled_spatial_sensor
from lcpflex.contact.spatial.node_shapes import node_shapes
from lcpflex.dynamics.spatial.state import SpatialState
from lcpflex.dynamics.time_functions import Materials
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray
from lcpflex.model.arrays import frozen
from lcpflex.model.recovery import MeshShapes
from lcpflex.model.spatial import SpatialModel
from lcpflex.scene.contact_rules import by_rules
from lcpflex.scene.face_contacts import doubtful_node_sides
from lcpflex.scene.left_out import pairs_left_out
from lcpflex.scene.spatial.scene import SpatialParts

if TYPE_CHECKING:
    from lcpflex.scene.spatial.scene import SpatialScene

__all__ = ["compiled_spatial_scene"]


def compiled_spatial_scene(
    scene: SpatialScene,
    project: bool,
    indents: Callable[[str], bool] | None = None,
    gives_way: bool = False,
    push: bool | None = False,
    listed: bool = False,
) -> CompiledScene:
    """The scene with its bodies reduced, as arrays. Raises ModelError for a start that cannot be.

    ``indents``: which contacts may indent each other at the start, by their names. ``push``: the others are pushed out;
    None: all may, as the scene begins elsewhere.
    ``listed``: every pair that a rule is for is a declared contact; so it is where ``indents`` asks for each.
    """
    listed = listed or indents is not None
    reduced, said = reduced_scene(scene, gives_way, listed)
    parts = reduced.parts()
    if not parts.placed:
        raise ModelError("scene: it has no body, expected at least one: scene.add(...)")
    bodies = compile_spatial_bodies(parts.bodies)
    q = frozen(np.concatenate([p.start[0] for p in parts.placed]))
    u = frozen(np.concatenate([p.start[1] for p in parts.placed]))
    materials = Materials(parts.placed)
    assembly = SpatialAssembly(SpatialState(0.0, q, u, bodies, materials))
    named = {
        (p.name, name): assembly.point(p.body, point)
        for p, body in zip(parts.placed, parts.bodies, strict=True)
        for name, point in body.points.items()
    }
    joints = compile_spatial_joints(parts.joints, assembly, project)
    loads = compile_spatial_loads(scene.gravity, parts.loads, assembly)
    jointed = tuple(parts.joints.values())
    by_rule, rule, touchable = by_rules(parts.placed, parts.surfaces, parts.contacts, parts.rules, jointed, listed)
    left_out = pairs_left_out(
        parts.placed, touchable, parts.contacts, parts.rules, jointed, parts.loads, bool(scene.gravity.any())
    )
    declared = {**parts.contacts, **by_rule}
    contacts = compile_spatial_contacts(declared, parts.surfaces, assembly, rule, len(parts.contacts))
    signals, callbacks = assembly.signals.compile()
    points = assembly.points.compile()
    contacts = contacts._replace(**node_shapes(contacts, points))
    model = SpatialModel(bodies, points, signals, joints, loads, contacts)
    layout = Layout(
        bodies=tuple(p.name for p in parts.placed),
        contacts=tuple(declared),
        joints=tuple(parts.joints),
        outlines=(),
        circles=(),
        points=named,
        resolutions=tuple(None for _ in parts.placed),
        residual=tuple((body.residual_modes, body.contact_modes) for body in parts.bodies),
        axes=tuple(None for _ in parts.placed),
        shapes=tuple(body.shape for body in parts.bodies),
        rule_surfaces=tuple(surface.label for surface in rule.surfaces) if rule else (),
    )
    external = np.zeros((assembly.signals.n_external, 3))
    for callback in callbacks:  # a trial: what is wrong with a function is said before time is spent
        callback.fill(0.0, assembly.state, external)
    refuse_overbent(model, q, layout.bodies)  # type: ignore[arg-type]  # of either dimension
    size = spatial_size(parts, model, q)
    misfits: tuple[str, ...] = ()
    if parts.joints:
        q, u, misfits = consistent_start(model, parts.joints, q, u, external, size, project)
    notes: tuple[str, ...] = ()
    if (declared or rule) and push is not None:
        hard = {name for name, one in declared.items() if one.law is None and not (indents and indents(name))}
        q, u, notes = start_apart(model, layout, hard, q, u, external, size, push)
    flexible = {p.body for p, body in zip(parts.placed, parts.bodies, strict=True) if body.modes}
    touched = declared if rule is None else {**declared, **rule.first_contacts(flexible)}
    return CompiledScene(
        model,
        layout,
        frozen(q),
        frozen(u),
        size,
        len(external),
        callbacks,
        tuple(contact.law for contact in declared.values()),
        assembly.signals.functions,
        materials,
        warnings=(*misfits, *left_out.warnings, *doubtful_node_sides(declared), *missing_compliance(parts, touched)),
        notes=(*left_out.notes, *notes, *(f"residual modes for {text}" for text in said)),
        recovery=tuple(body.recovery for body in parts.bodies),
        spread={
            p: (frozen(nodes, np.int64), frozen(weights))
            for p, (nodes, weights) in assembly.spread.items()
            if _meshed(parts, int(model.points.body[p]))
        },
        sensors=tuple(compiled_spatial_sensor(name, one, bodies, layout) for name, one in parts.sensors.items()),
    )


def _meshed(parts: SpatialParts, b: int) -> bool:
    """Whether stresses of the body are recovered from a mesh."""
    return b >= 0 and isinstance(parts.bodies[b].recovery, MeshShapes)


def spatial_size(parts: SpatialParts, model: SpatialModel, q: FloatArray) -> float:
    """Extent of the largest body [m], with the points on it; of the scene where all bodies are points."""
    points = model.points
    extents = [0.0]
    for b, body in enumerate(parts.bodies):
        own = points.place[points.body == b]
        spans = np.ptp(own, axis=0) if len(own) else np.zeros(3)
        extents.append(max(float(spans.max()), _extent(body.shape)))
    largest = max(extents)
    if largest > 0.0:
        return largest
    frames = np.vstack([q[model.bodies.place[:-1, None] + np.arange(3)], points.place[points.body < 0]])
    return float(np.ptp(frames, axis=0).max()) or 1.0


def _extent(shape: Shape | None) -> float:
    """Largest extent of a shape along an axis of its body [m]; 0 where there is none."""
    if isinstance(shape, SphereShape):
        return 2.0 * shape.radius
    if isinstance(shape, CylinderShape):
        return max(2.0 * shape.radius, shape.length)
    if isinstance(shape, CapsuleShape):
        return 2.0 * shape.radius + shape.length
    return float(np.ptp(shape.vertices, axis=0).max()) if isinstance(shape, SurfaceShape) else 0.0
