"""The place of rest at the end of a path, looked at closely: forces, states, stability."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lcpflex.compile.compiled_scene import CompiledScene
from lcpflex.contact.rows import contact_point
from lcpflex.dynamics.reaction_memory import reaction
from lcpflex.jit.kernel import FloatArray
from lcpflex.statics.balance import Balance, Configuration
from lcpflex.statics.path import Path
from lcpflex.statics.refinement import CLOSED, refined
from lcpflex.statics.rest import ContactAtRest, JointAtRest, Rest, Trace
from lcpflex.statics.scales import Scales, acting_on
from lcpflex.statics.shared_forces import SharedForces
from lcpflex.statics.slid_forces import forces_after_slip
from lcpflex.statics.stability import stability_of
from lcpflex.statics.tangent import tangent_stiffness
from lcpflex.statics.words import what_moves

__all__ = ["rest_at"]

BALANCED = 1e-9  # residual of a place of rest
OWN = 1e-6  # of the largest force on a body: what is not balanced of a light one beside heavy ones
LIGHTEST = 1e-13  # of the largest force: what is rounding on any body


def rest_at(compiled: CompiledScene, balance: Balance, scales: Scales, path: Path, steps: int) -> Rest | None:
    """The place of rest next to the last station of the path; None where there is none so near."""
    q = refined(balance, scales, path)
    if q is None:
        return None
    at = balance.look(q, 2.0 * path.longest)
    if (at.gap < -CLOSED * scales.size).any():
        return None
    closed = at.gap <= CLOSED * scales.size
    scale = path.station.scale
    unit = np.ones(len(at.rows))
    unit[: at.n_joint][at.turns] = compiled.size
    bodies = np.diff(balance.model.bodies.dof)
    forces = forces_after_slip(
        at, path.slip(at), scales, closed, unit, scale, lambda p: np.repeat(acting_on(balance, scales, at, p), bodies)
    )
    if forces is None:
        return None
    scale = path.scale(at, forces.p)
    left = np.abs(at.force + at.rows.T @ forces.p) / scales.arm
    residual = float(left.max(initial=0.0)) / scale if scale > 0.0 else 0.0
    on = np.maximum(acting_on(balance, scales, at, forces.p), LIGHTEST * scale)
    each = np.maximum.reduceat(left, balance.model.bodies.dof[:-1])
    if not residual <= BALANCED or (each > OWN * on + LIGHTEST * scale).any():
        return None
    K = tangent_stiffness(balance, scales, q, forces.p)
    found = stability_of(at, K, forces, scales, on, balance.model.bodies.dof)
    balance.again(q)

    def ways(directions: FloatArray) -> tuple[str, ...]:
        return tuple(what_moves(compiled.layout.bodies, compiled.model, scales, q, way) for way in directions)

    shut = frozenset(balance.work.rows.table.key[: at.n_contacts][closed].tolist())
    trace = Trace(path.multipliers(at, forces.p), shut, found.family)
    q.setflags(write=False)
    return Rest(
        q=q,
        contacts=_contacts(compiled, balance, at, closed, forces),
        joints=_joints(compiled, balance, forces),
        stable=found.stable,
        unstable=ways(found.unstable),
        neutral=ways(found.neutral),
        neighbours=found.neighbours,
        unique=bool(forces.unique.all()),
        residual=residual,
        travelled=path.station.travelled,
        steps=steps,
        time=balance.time,
        warnings=compiled.warnings,
        compiled=compiled,
        trace=trace,
    )


def _contacts(
    compiled: CompiledScene,
    balance: Balance,
    at: Configuration,
    closed: NDArray[np.bool_],
    forces: SharedForces,
) -> tuple[ContactAtRest, ...]:
    """Each declared contact with its closed places."""
    table, r, n = balance.work.rows.table, at.n_joint, at.n_contacts
    sticks, own = np.zeros(n, bool), forces.unique[r : r + n].copy()
    sticks[at.tangent] = forces.sticks
    np.logical_and.at(own, at.tangent, forces.unique[r + n :])
    friction = _friction(balance, at, forces.p[r + n :])
    names = ("ground", *compiled.layout.bodies)
    told = []
    for law, name in enumerate(compiled.layout.contacts):
        chosen = np.flatnonzero(closed & (table.law[:n] == law))
        states = ["stick" if sticks[k] else "slip" if forces.pressed[k] else "touch" for k in chosen]
        places = [contact_point(balance.model, at.q, table, int(k)) for k in chosen]
        told.append(
            ContactAtRest(
                name,
                tuple(states),
                tuple((names[table.body[k, 0] + 1], names[table.body[k, 1] + 1]) for k in chosen),
                np.array(places).reshape(-1, table.normal.shape[1]),
                table.normal[chosen].copy(),
                forces.p[r + chosen],
                friction[chosen],
                own[chosen],
            )
        )
    return tuple(told)


def _friction(balance: Balance, at: Configuration, multipliers: FloatArray) -> FloatArray:
    """(n,) lambda_T of each contact found last by the multipliers (m,) of tangents; in space (n, 3) vectors."""
    found = np.zeros((at.n_contacts, 1 if at.d == 1 else 3))
    for j in range(0, len(multipliers), at.d):
        k = int(at.tangent[j])
        found[k] = multipliers[j : j + at.d] @ balance.tangents(k)
    return found[:, 0] if at.d == 1 else found


def _joints(compiled: CompiledScene, balance: Balance, forces: SharedForces) -> tuple[JointAtRest, ...]:
    """Each joint with its force and moment."""
    row = balance.model.joints.row
    told = []
    for joint, name in enumerate(compiled.layout.joints):
        wrench = np.array(reaction(balance.model, balance.work, joint, forces.p))
        unique = bool(forces.unique[row[joint] : row[joint + 1]].all())
        force, moment = (wrench[:3], wrench[3:]) if len(wrench) == 6 else (wrench[:2], float(wrench[2]))
        told.append(JointAtRest(name, force, moment, unique))
    return tuple(told)
