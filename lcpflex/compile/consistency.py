"""Every refusal of a scene as a whole: what only its compiled form, or all of its parts together, can tell."""

from __future__ import annotations

import math
import warnings
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.compile.compiled_scene import Layout
from lcpflex.contact.near import near, surfaces_of
from lcpflex.dynamics import start
from lcpflex.dynamics.mass_matrix import mass_matrix, overbent
from lcpflex.dynamics.time_functions import State
from lcpflex.errors import ModelError, ModelWarning
from lcpflex.jit.kernel import FloatArray
from lcpflex.jit.struct import pack
from lcpflex.model.arrays import Model
from lcpflex.model.coordinates import UNITS, is_angular
from lcpflex.model.layout import dimension, is_spatial, place_offsets
from lcpflex.scene.handles import Placed
from lcpflex.scene.joints.joint import Joint

if TYPE_CHECKING:
    from lcpflex.scene.spatial.relative import SpatialJoint

__all__ = [
    "consistent_start",
    "refuse_no_body",
    "refuse_overbent",
    "refuse_unguided",
    "start_apart",
]

JOINT_TOLERANCE = 1e-9  # [rad], or times the size of the scene [m]; the same for velocities
PROJECTION_TOLERANCE = 1e-12
MISFIT = 1e-5  # what redundant joints of space may contradict each other by, in the same units; it is said
AXIS_TOLERANCE = 1e-6  # [rad] between a solid of revolution and what guides it
CORNERS = 6  # of two triangles, the least closed outlines that may be inside each other
PENETRATION = 1e-6  # times the size of the largest body: an initial penetration beyond it is an error


def refuse_no_body(placed: Sequence[Placed]) -> None:
    """Raise ModelError for a scene without a body."""
    if not placed:
        raise ModelError("scene: it has no body, expected at least one: scene.add(...)")


def refuse_unguided(placed: Sequence[Placed], joints: Sequence[Joint], state: State) -> None:
    """Solids of revolution move along their axis: joints must hold it, or moments that do not exist would turn them."""
    solids = {p.body for p in placed if p.source and p.source.axisymmetric}
    if not solids:
        return
    held = {-1}  # the ground, and what Prismatic joints and welds keep from turning
    for _ in placed:
        for joint in joints:
            pair = {joint.P.body, joint.Q.body}
            if len(pair & held) == 1 and all(_guides(joint, body, state) for body in pair & solids):
                held |= pair if _holds(joint) else set()
    for p in placed:
        if p.body in solids - held:
            raise ModelError(
                f"body {p.name!r}: a solid of revolution moves along its axis only, expected a joint along it that "
                f"holds it, as scene.join(Prismatic(body.point('axis'), scene.ground.at(X, Y), axis=(x, y))), or a Weld"
            )


def _holds(joint: Joint) -> bool:
    """Whether the joint keeps its points on a line at least, and from turning, as Prismatic and Weld do."""
    kinds = {row.kind for row in joint.rows()}
    return any(map(is_angular, kinds)) and len(kinds) > 1


def _guides(joint: Joint, body: int, state: State) -> bool:
    """Whether the joint holds a solid of revolution on its axis, and lets it move along it at most."""
    own = joint.P if joint.P.body == body else joint.Q
    on_axis = not own.material.phi[:, 1].any() and own.material.place[1] == 0.0
    across = [row.axis for row in joint.rows() if row.kind == "along"]
    if not (on_axis and across and _holds(joint)):
        return on_axis
    x, y = across[0]  # normal to the line
    axis = state.angle(joint.Q) + math.atan2(-x, y)
    return abs(math.sin(axis - float(state.q[state.dof[body] + 2]))) <= AXIS_TOLERANCE


def refuse_overbent(model: Model, q: FloatArray, names: Sequence[str]) -> None:
    """Raise ModelError for a body whose spin would stiffen it below nothing."""
    for b in overbent(model, q):
        raise ModelError(
            f"body {names[b]!r}: modal: it is bent too far for its stiffening by spin, expected small deflections"
        )


def consistent_start(
    model: Any,
    joints: Mapping[str, Joint | SpatialJoint],
    q: FloatArray,
    u: FloatArray,
    external: FloatArray,
    size: float,
    project: bool,
) -> tuple[FloatArray, FloatArray, tuple[str, ...]]:
    """A start that fulfils the joints: the given one, or its projection; and warnings, which are given, too.

    Mechanisms of space are redundant as a rule, and never fit exactly: of their projection the least misfit is left.
    """
    units = [UNITS[kind] for kind in model.joints.kind]
    frames = place_offsets(model.bodies)[:-1, None] + np.arange(dimension(model.bodies).components)
    reach = max(size, float(np.abs(q[frames]).max()))
    scale = np.array([reach if unit == "m" else 1.0 for unit in units])
    q, u = q.copy(), u.copy()  # writable, as the kernels are compiled for
    if project:
        q, u = start.project(model, q, u, external, PROJECTION_TOLERANCE * scale)
    found = start.violation(model, q, u, external)
    misfit = project and is_spatial(model) and _is_misfit(model, q, found, scale)
    worst = _refuse_violation(found, model, joints, units, scale, project, MISFIT if misfit else JOINT_TOLERANCE)
    texts = []
    if misfit:
        texts.append(
            f"redundant joints contradict each other, most at {worst}: this is the least that there can be, and the "
            "mechanism moves with it; expected joints that fit, or none that are redundant"
        )
    if is_spatial(model) and len(joints) > len(model.bodies.mass):  # not in trees
        texts += _locked(model, q, found)
    for text in texts:
        warnings.warn(text, ModelWarning, stacklevel=3)
    return q, u, tuple(texts)


def _locked(model: Any, q: FloatArray, found: start.Violation) -> list[str]:
    """What to say where joints leave no motion, but would if they fitted a little better."""
    from lcpflex.dynamics.spatial.start import locking_error

    error = locking_error(model, mass_matrix(model, q), found.jacobian)
    if not error > 0.0:
        return []
    return [
        "the joints leave the bodies no motion, but would if places and axes did not differ by some "
        f"{error:.1g} of their arms or rad: expected joints that fit to 1e-5, if this is to be a mechanism"
    ]


def _is_misfit(model: Any, q: FloatArray, found: start.Violation, scale: FloatArray) -> bool:
    """Whether joints are violated and no motion would mend that."""
    violated = (np.abs(found.position) > JOINT_TOLERANCE * scale).any()
    violated |= (np.abs(found.velocity) > JOINT_TOLERANCE * (scale + found.speed)).any()
    return bool(violated and (start.correctable(model, q, found) <= JOINT_TOLERANCE * scale).all())


def _refuse_violation(
    found: start.Violation,
    model: Model,
    joints: Mapping[str, Joint | SpatialJoint],
    units: Sequence[str],
    scale: FloatArray,
    project: bool,
    tolerance: float,
) -> str:
    """Raise ModelError for the joint that is violated most, relative to what is tolerated; else tell of that one."""
    hint = "the joints contradict each other" if project else "place the bodies accordingly, or use project=True"
    owner = np.searchsorted(model.joints.row, np.arange(len(units)), side="right") - 1
    names, told = list(joints), ""
    for violated, allowed, rate in (
        (found.position, tolerance * scale, ""),
        (found.velocity, tolerance * (scale + found.speed), "/s"),
    ):
        worst = int(np.argmax(np.abs(violated) / allowed))
        name = names[owner[worst]]
        joint = joints[name]
        rows = model.joints.row[owner[worst] : owner[worst] + 2]
        size = math.hypot(*(violated[r] for r in range(*rows) if units[r] == units[worst]))
        what = "velocity" if rate else "position"
        told = told or f"joint {name!r}, by {size:.3g} {units[worst]}{rate}"
        if not abs(violated[worst]) <= allowed[worst]:
            raise ModelError(
                f"joint {name!r} ({type(joint).__name__} of {joint.P.label} and {joint.Q.label}): the initial {what} "
                f"violates it by {size:.6g} {units[worst]}{rate}, expected at most {allowed[worst]:.1g}: {hint}"
            )
    return told


def start_apart(
    model: Any,
    layout: Layout,
    hard: set[str],
    q: FloatArray,
    u: FloatArray,
    external: FloatArray,
    size: float,
    push: bool,
) -> tuple[FloatArray, FloatArray, tuple[str, ...]]:
    """A start without penetration of contacts that are ``hard``, or by rule, and notes: the given one, or pushed out.

    A rule that is not listed is hard. Raises ModelError for the deepest penetration beyond tolerance.
    """
    names = layout.contacts

    def name(table: Any, k: int) -> str:
        law = int(table.law[k])
        return names[law] if law < len(names) else layout.pair_name(*surfaces_of(model.contacts, int(table.key[k])))

    def is_hard(table: Any, k: int) -> bool:
        return bool(table.law[k] >= len(names)) or name(table, k) in hard

    notes: tuple[str, ...] = ()
    if push:
        from lcpflex.compile.pushed_start import pushed_start  # with solvers that few starts need

        pushed = pushed_start(model, q, u, external, size, name, is_hard, layout.bodies)
        if pushed is not None:
            q, u, notes = pushed.q, pushed.u, (pushed.note,)
    table, found = near(pack(model), q.copy(), 0.0)
    depths = {k: -float(table.gap[k]) for k in range(found) if is_hard(table, k)}
    deepest = max(depths, key=depths.__getitem__, default=-1)
    if deepest >= 0 and not (depth := depths[deepest]) <= PENETRATION * size:
        raise ModelError(
            f"contact {name(table, deepest)!r}: its surfaces penetrate by {depth:.6g} m at the start, expected at most "
            f"{PENETRATION * size:.1g} m: move the bodies apart, or use project=True, which pushes them out"
        )
    if not is_spatial(model) and len(model.contacts.feature_kind) >= CORNERS:
        from lcpflex.compile.sunk_start import sunk_pairs  # which scenes of discs do without

        hollow = [body for body, count in Counter(body for body, _, _ in layout.outlines).items() if count > 1]
        for a, b, law in sunk_pairs(model, q, PENETRATION * size, hollow):
            label = names[law] if law >= 0 else layout.pair_name(a, b)
            if law < 0 or label in hard:
                raise ModelError(
                    f"contact {label!r}: its surfaces overlap at the start by more than half the thickness of one, so "
                    "that no side is nearer than the other, expected bodies beside each other: move them apart"
                )
    return q, u, notes
