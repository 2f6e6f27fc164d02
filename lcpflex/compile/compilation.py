"""From the objects of a scene to the arrays of a model: the order in which the parts are compiled and checked."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from lcpflex.compile.assembly import Assembly
from lcpflex.compile.bodies import compile_bodies, drawn_shapes, scene_size
from lcpflex.compile.compiled_scene import CompiledScene, Layout
from lcpflex.compile.consistency import (
    consistent_start,
    refuse_no_body,
    refuse_overbent,
    refuse_unguided,
    start_apart,
)
from lcpflex.compile.contacts import compile_contacts
from lcpflex.compile.joints import compile_joints
from lcpflex.compile.loads import compile_loads
from lcpflex.compile.missing_compliance import missing_compliance
from lcpflex.compile.reduced_scene import reduced_scene
from lcpflex.compile.sensors import compiled_sensor
from lcpflex.dynamics.time_functions import Materials, State
from lcpflex.jit.kernel import FloatArray
from lcpflex.model.arrays import Model, frozen
from lcpflex.scene.contact_rules import by_rules
from lcpflex.scene.declared import Parts
from lcpflex.scene.left_out import pairs_left_out

if TYPE_CHECKING:
    from lcpflex.scene.scene import Scene

__all__ = ["compiled_scene"]


def compiled_scene(
    scene: Scene,
    project: bool,
    indents: Callable[[str], bool] | None,
    gives_way: bool,
    listed: bool = False,
    push: bool | None = False,
) -> CompiledScene:
    """The scene with its bodies reduced, as arrays. Raises ModelError for a start that cannot be.

    ``listed``: every pair that a rule is for is a declared contact, be they ever so many; so it is where ``indents``
    asks for each. ``push``: contacts that penetrate are pushed out; None: they may, as the
    scene begins elsewhere.
    """
    listed = listed or indents is not None
    reduced, said = reduced_scene(scene, gives_way, listed)
    parts = reduced.parts()
    materials = Materials(parts.placed)
    compiled = compiled_parts(reduced.gravity, parts, materials, project, indents, listed, push)
    return replace(compiled, notes=(*compiled.notes, *(f"residual modes for {text}" for text in said)))


def compiled_parts(
    gravity: FloatArray,
    parts: Parts,
    materials: Materials | None,
    project: bool,
    indents: Callable[[str], bool] | None,
    listed: bool = False,
    push: bool | None = False,
) -> CompiledScene:
    """A scene of reduced bodies as arrays; ``materials``: what points of the scene as it was declared mean in it."""
    placed, joints, loads, contacts, rules, surfaces, sensors = parts
    refuse_no_body(placed)
    bodies = compile_bodies(parts.bodies)
    q = frozen(np.concatenate([p.start[0] for p in placed]))
    u = frozen(np.concatenate([p.start[1] for p in placed]))
    assembly = Assembly(State(0.0, q, u, bodies.dof, materials))
    refuse_unguided(placed, tuple(joints.values()), assembly.state)
    named = {
        (p.name, name): assembly.point(p.body, point)
        for p, body in zip(placed, parts.bodies, strict=True)
        for name, point in body.points.items()
    }
    outlines, circles = drawn_shapes(placed, surfaces, assembly)
    by_rule, rule, touchable = by_rules(placed, surfaces, contacts, rules, tuple(joints.values()), listed)
    left_out = pairs_left_out(placed, touchable, contacts, rules, tuple(joints.values()), loads, bool(gravity.any()))
    declared = {**contacts, **by_rule}
    arrays = (
        compile_joints(joints, assembly, project),
        compile_loads(gravity, loads, assembly),
        compile_contacts(declared, surfaces, assembly, rule, len(contacts)),
    )
    signals, callbacks = assembly.signals.compile()
    model = Model(bodies, assembly.points.compile(), signals, *arrays)
    meshes = [body.resolution for body in parts.bodies]
    layout = Layout(
        bodies=tuple(p.name for p in placed),
        contacts=tuple(declared),
        joints=tuple(joints),
        outlines=outlines,
        circles=circles,
        points=named,
        resolutions=tuple((mesh.wave_speed, mesh.element_size) if mesh else None for mesh in meshes),
        residual=tuple((body.residual_modes, body.contact_modes) for body in parts.bodies),
        axes=tuple(body.axis for body in parts.bodies),
        rule_surfaces=tuple(surface.label for surface in rule.surfaces) if rule else (),
    )
    external = np.zeros((assembly.signals.n_external, 3))
    for callback in callbacks:  # a trial: what is wrong with a function is said before time is spent
        callback.fill(0.0, assembly.state, external)
    refuse_overbent(model, q, layout.bodies)
    size = scene_size(model, circles, q)
    misfits: tuple[str, ...] = ()
    if joints:
        q, u, misfits = consistent_start(model, joints, q, u, external, size, project)
    notes: tuple[str, ...] = ()
    if (declared or rule) and push is not None:
        hard = {name for name, contact in declared.items() if contact.law is None and not (indents and indents(name))}
        q, u, notes = start_apart(model, layout, hard, q, u, external, size, push)
    laws = tuple(c.law for c in declared.values())
    flexible = {p.body for p, body in zip(placed, parts.bodies, strict=True) if body.modes}
    touched = declared if rule is None else {**declared, **rule.first_contacts(flexible)}
    return CompiledScene(
        model,
        layout,
        frozen(q),
        frozen(u),
        size,
        len(external),
        callbacks,
        laws,
        assembly.signals.functions,
        materials,
        (*misfits, *left_out.warnings, *missing_compliance(parts, touched)),
        (*left_out.notes, *notes),
        recovery=tuple(body.recovery for body in parts.bodies),
        sensors=tuple(compiled_sensor(name, sensor) for name, sensor in sensors.items()),
    )
