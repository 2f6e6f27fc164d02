"""From the objects of a scene to the arrays of a model, and the checks that need the whole scene."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from lcpflex.bodies.body import Body, Chain, MaterialPoint, Shortening
from lcpflex.bodies.placed_point import PlacedPoint
from lcpflex.compile.compiled_scene import Compiled, Layout
from lcpflex.compile.contact_surfaces import compile_contacts
from lcpflex.compile.missing_compliance import missing_compliance
from lcpflex.compile.reduced_scene import reduced_scene
from lcpflex.dynamics.time_functions import Materials, SignalTable, State
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.jit.struct import pack
from lcpflex.model.arrays import Bodies, Contacts, Joints, Loads, Model, PointTable, frozen
from lcpflex.scene.contact_rules import by_rules
from lcpflex.scene.declared import DeclaredContact, Parts
from lcpflex.scene.handles import Placed, PlacedSurface
from lcpflex.scene.joints import Joint, Prismatic, Weld
from lcpflex.scene.loads import Force, Load, Spring, Torque, TorsionSpring

if TYPE_CHECKING:
    from lcpflex.dynamics.start import Violation
    from lcpflex.scene.scene import Scene

__all__ = ["compiled_scene"]

JOINT_TOLERANCE = 1e-9  # [rad], or times the size of the scene [m]; the same for velocities
PROJECTION_TOLERANCE = 1e-12
AXIS_TOLERANCE = 1e-6  # [rad] between a solid of revolution and what guides it
PENETRATION = 1e-6  # times the size of the largest body: an initial penetration beyond it is an error


@dataclass(slots=True)
class Assembly:
    """Material points and functions of time, collected while a scene is compiled."""

    state: State  # at the start
    points: PointTable = field(default_factory=PointTable)
    signals: SignalTable = field(default_factory=SignalTable)
    _known: dict[tuple[int, int], tuple[int, MaterialPoint]] = field(default_factory=dict)

    def point(self, body: int, material: MaterialPoint) -> int:
        """Index of a material point; one object is registered once."""
        key = (body, id(material))
        if key not in self._known:
            index = self.points.add(body, material.place, material.phi, material.psi)
            self._known[key] = (index, material)  # holds the object, so that its id stays its own
        return self._known[key][0]

    def of(self, point: PlacedPoint) -> int:
        """Index of a point of the scene."""
        return self.point(point.body, point.material)

    def angle(self, P: PlacedPoint, Q: PlacedPoint) -> float:
        """Relative angle of P and Q at the start [rad]."""
        return self.state.angle(P) - self.state.angle(Q)

    def distance(self, P: PlacedPoint, Q: PlacedPoint) -> float:
        """Distance of P and Q at the start [m]."""
        return math.hypot(*(self.state.position(P) - self.state.position(Q)))


def compiled_scene(scene: Scene, project: bool, indents: Callable[[str], bool] | None, gives_way: bool) -> Compiled:
    """The scene with its bodies reduced, as arrays. Raises ModelError for a start that cannot be."""
    reduced, said = reduced_scene(scene, gives_way)
    parts = reduced.parts()
    modes = [one.source.modes if one.source is not None else 0 for one in parts.placed]
    materials = Materials(parts.placed, modes)
    compiled = compiled_parts(reduced.gravity, parts, materials, project, indents)
    return replace(compiled, notes=tuple(f"residual modes for {text}" for text in said))


def compiled_parts(
    gravity: FloatArray,
    parts: Parts,
    materials: Materials | None,
    project: bool,
    indents: Callable[[str], bool] | None,
) -> Compiled:
    """A scene of reduced bodies as arrays; ``materials``: what points of the scene as it was declared mean in it."""
    placed, joints, loads, contacts, rules, surfaces = parts
    if not placed:
        raise ModelError("scene: it has no body, expected at least one: scene.add(...)")
    sources = [p.source for p in placed if p.source is not None]
    bodies = _bodies(sources)
    q = frozen(np.concatenate([p.start[0] for p in placed]))
    u = frozen(np.concatenate([p.start[1] for p in placed]))
    assembly = Assembly(State(0.0, q, u, bodies.dof, materials))
    _refuse_unguided(placed, tuple(joints.values()), assembly.state)
    named = {
        (p.name, name): assembly.point(p.body, p.source.points[name])
        for p in placed
        if p.source
        for name in p.source.points
    }
    outlines, circles = _drawn(placed, surfaces, assembly)
    declared = {**contacts, **by_rules(placed, surfaces, contacts, rules, tuple(joints.values()))}
    arrays = (
        _joints(joints, assembly, project),
        _loads(gravity, loads, assembly),
        _contacts(declared, surfaces, assembly),
    )
    signals, callbacks = assembly.signals.compile()
    model = Model(bodies, assembly.points.compile(), signals, *arrays)
    meshes = [p.source.resolution if p.source else None for p in placed]
    resolutions = tuple((mesh.wave_speed, mesh.element_size) if mesh else None for mesh in meshes)
    names = tuple(p.name for p in placed)
    residual = tuple((p.source.residual_modes, p.source.contact_modes) if p.source else (0, 0) for p in placed)
    axes = tuple(p.source.axis if p.source else None for p in placed)
    layout = Layout(names, tuple(declared), tuple(joints), outlines, circles, named, resolutions, residual, axes)
    external = np.zeros((assembly.signals.n_external, 3))
    for callback in callbacks:  # a trial: what is wrong with a function is said before time is spent
        callback.fill(0.0, assembly.state, external)
    _refuse_overbent(model, q, layout.bodies)
    size = _size(model, circles, q)
    if joints:
        q, u = _consistent(model, joints, q, u, external, size, project)
    if declared:
        hard = {name for name, contact in declared.items() if contact.law is None and not (indents and indents(name))}
        _refuse_penetration(model, q.copy(), tuple(declared), hard, size)
    laws = tuple(c.law for c in declared.values())
    return Compiled(
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
        missing_compliance(parts, declared),
    )


def _refuse_unguided(placed: Sequence[Placed], joints: Sequence[Joint], state: State) -> None:
    """Solids of revolution move along their axis: joints must hold it, or moments that do not exist would turn them."""
    solids = {p.body for p in placed if p.source and p.source.axisymmetric}
    if not solids:
        return
    held = {-1}  # the ground, and what Prismatic joints and welds keep from turning
    for _ in placed:
        for joint in joints:
            pair = {joint.P.body, joint.Q.body}
            if len(pair & held) == 1 and all(_guides(joint, body, state) for body in pair & solids):
                held |= pair if isinstance(joint, Prismatic | Weld) else set()
    for p in placed:
        if p.body in solids - held:
            raise ModelError(
                f"body {p.name!r}: a solid of revolution moves along its axis only, expected a joint along it that "
                f"holds it, as scene.join(Prismatic(body.point('axis'), scene.ground.at(X, Y), axis=(x, y))), or a Weld"
            )


def _guides(joint: Joint, body: int, state: State) -> bool:
    """Whether the joint holds a solid of revolution on its axis, and lets it move along it at most."""
    own = joint.P if joint.P.body == body else joint.Q
    on_axis = not own.material.phi[:, 1].any() and own.material.place[1] == 0.0
    if not (on_axis and isinstance(joint, Prismatic)):
        return on_axis
    x, y = joint.form().axis
    axis = state.angle(joint.Q) + math.atan2(y, x)
    return abs(math.sin(axis - float(state.q[state.dof[body] + 2]))) <= AXIS_TOLERANCE


def _bodies(sources: Sequence[Body]) -> Bodies:
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
        dof=frozen(np.cumsum([0, *(3 + body.modes for body in sources)]), np.int64),
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


def _drawn(
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


def _joints(joints: Mapping[str, Joint], assembly: Assembly, project: bool) -> Joints:
    from lcpflex.dynamics import start

    kind, point, value, signal, row = [], [], [], [], [0]
    for name, joint in joints.items():
        form = joint.form()
        angle = assembly.angle(joint.P, joint.Q) if form.angle is None else form.angle
        length = assembly.distance(joint.P, joint.Q) if form.length is None else form.length
        if form.length is None and not length > 0.0:
            raise ModelError(f"joint {name!r}: its points coincide at the start, expected a distance > 0 or a length")
        kind.append(form.kind)
        point.append((assembly.of(joint.P), assembly.of(joint.Q)))
        value.append((angle, *form.axis, length))
        number = -1
        if form.motion is not None:
            rate = None if project else start.drive_rate(joint, form, assembly.state)
            number = assembly.signals.motion(f"joint {name!r}: motion", form.motion, rate)
        signal.append(number)
        row.append(row[-1] + len(form.rows))
    return Joints(
        kind=frozen(kind, np.int64),
        point=frozen(point, np.int64, columns=2),
        row=frozen(row, np.int64),
        value=frozen(value, columns=4),
        signal=frozen(signal, np.int64),
    )


def _loads(gravity: FloatArray, loads: Sequence[Load], assembly: Assembly) -> Loads:
    springs: list[tuple[int, tuple[int, int], tuple[float, float, float]]] = []
    forces: list[tuple[int, int, tuple[int, int]]] = []
    signals = assembly.signals
    for load in loads:
        P = assembly.of(load.P)
        if isinstance(load, Spring | TorsionSpring):
            given = load.length if isinstance(load, Spring) else load.angle
            start = assembly.distance if isinstance(load, Spring) else assembly.angle
            rest = start(load.P, load.Q) if given is None else given
            kind = 0 if isinstance(load, Spring) else 1
            springs.append((kind, (P, assembly.of(load.Q)), (load.stiffness, load.damping, rest)))
        elif isinstance(load, Torque):
            index = signals.force(f"{load.name or 'torque'} at {load.P.label}", load.value)
            forces.append((2, P, (index, index)))
        else:
            forces.append((int(load.follower), P, _components(load, signals)))
    return Loads(
        gravity=frozen(gravity),
        spring_kind=frozen([s[0] for s in springs], np.int64),
        spring_point=frozen([s[1] for s in springs], np.int64, columns=2),
        spring_value=frozen([s[2] for s in springs], columns=3),
        force_kind=frozen([f[0] for f in forces], np.int64),
        force_point=frozen([f[1] for f in forces], np.int64),
        force_signal=frozen([f[2] for f in forces], np.int64, columns=2),
    )


def _components(force: Force, signals: SignalTable) -> tuple[int, int]:
    name = f"{force.name or 'force'} at {force.P.label}"
    if callable(force.value):
        return signals.force_pair(name, force.value)
    x, y = force.value
    return signals.force(f"{name}, x", x), signals.force(f"{name}, y", y)


def _contacts(
    declared: Mapping[str, DeclaredContact], surfaces: Sequence[PlacedSurface], assembly: Assembly
) -> Contacts:
    used = {s.label: s for s in surfaces}  # surfaces without a contact are drawn, too
    for contact in declared.values():
        used.update((s.label, s) for s in contact.pair)
    number = {label: k for k, label in enumerate(used)}
    return compile_contacts(
        [(s.body, s.shape) for s in used.values()],
        [
            (number[c.pair[0].label], number[c.pair[1].label], c.friction, c.restitution, c.tangential_restitution)
            for c in declared.values()
        ],
        assembly.points,
        {law: number[c.slave.label] for law, c in enumerate(declared.values()) if c.slave is not None},
    )


def _size(model: Model, circles: Sequence[tuple[int, float]], q: FloatArray) -> float:
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


def _refuse_overbent(model: Model, q: FloatArray, names: Sequence[str]) -> None:
    from lcpflex.dynamics.mass_matrix import overbent

    for b in overbent(model, q):
        raise ModelError(
            f"body {names[b]!r}: modal: it is bent too far for its stiffening by spin, expected small deflections"
        )


def _consistent(
    model: Model,
    joints: Mapping[str, Joint],
    q: FloatArray,
    u: FloatArray,
    external: FloatArray,
    size: float,
    project: bool,
) -> tuple[FloatArray, FloatArray]:
    """A start that fulfils the joints: the given one, or its projection."""
    from lcpflex.dynamics import start

    units = [unit for joint in joints.values() for unit in joint.form().rows]
    reach = max(size, float(np.abs(q[model.bodies.dof[:-1, None] + np.arange(2)]).max()))
    scale = np.array([reach if unit == "m" else 1.0 for unit in units])
    q, u = q.copy(), u.copy()  # writable, as the kernels are compiled for
    if project:
        q, u = start.project(model, q, u, external, PROJECTION_TOLERANCE * scale)
    _refuse_violation(start.violation(model, q, u, external), model, joints, units, scale, project)
    return q, u


def _refuse_violation(
    found: Violation,
    model: Model,
    joints: Mapping[str, Joint],
    units: Sequence[str],
    scale: FloatArray,
    project: bool,
) -> None:
    """Raise ModelError for the joint that is violated most, relative to what is tolerated."""
    hint = "the joints contradict each other" if project else "place the bodies accordingly, or use project=True"
    owner = np.searchsorted(model.joints.row, np.arange(len(units)), side="right") - 1
    names = list(joints)
    for violated, allowed, rate in (
        (found.position, JOINT_TOLERANCE * scale, ""),
        (found.velocity, JOINT_TOLERANCE * (scale + found.speed), "/s"),
    ):
        worst = int(np.argmax(np.abs(violated) / allowed))
        if not abs(violated[worst]) <= allowed[worst]:
            name = names[owner[worst]]
            joint = joints[name]
            rows = model.joints.row[owner[worst] : owner[worst] + 2]
            of_unit = [violated[r] for r in range(*rows) if units[r] == units[worst]]
            what = "velocity" if rate else "position"
            size = math.hypot(*of_unit)
            raise ModelError(
                f"joint {name!r} ({type(joint).__name__} of {joint.P.label} and {joint.Q.label}): the initial {what} "
                f"violates it by {size:.6g} {units[worst]}{rate}, expected at most {allowed[worst]:.1g}: {hint}"
            )


def _refuse_penetration(model: Model, q: FloatArray, names: Sequence[str], hard: set[str], size: float) -> None:
    """Raise ModelError for the deepest initial penetration beyond tolerance of a contact that is ``hard``."""
    from lcpflex.contact.detection import contact_table, detect

    model = pack(model)
    capacity = 64
    while True:
        table = contact_table(capacity, len(model.contacts.surface_body))
        found = detect(model, q, 0.0, table)
        if found <= capacity:
            break
        capacity = 2 * found
    depths = {k: -float(table.gap[k]) for k in range(found) if names[table.law[k]] in hard}
    deepest = max(depths, key=depths.__getitem__, default=-1)
    if deepest >= 0 and not (depth := depths[deepest]) <= PENETRATION * size:
        raise ModelError(
            f"contact {names[table.law[deepest]]!r}: its surfaces penetrate by {depth:.6g} m at the start, "
            f"expected at most {PENETRATION * size:.1g} m: move the bodies apart"
        )
