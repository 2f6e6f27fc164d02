"""The arrays of a scene at one state, from the kernels that steppers call there."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from lcpflex.basics.arguments import array_of
from lcpflex.compile.coordinates import coordinate_names, velocity_names
from lcpflex.compile.state_mechanics import CompliantForces, StateMechanics
from lcpflex.contact.detection import ContactTable, detect
from lcpflex.contact.narrow_phase.feature import contact_bias
from lcpflex.contact.rows import contact_point, contact_rows
from lcpflex.contact.rule_pairs import MORE_LAWS
from lcpflex.dynamics import mechanics
from lcpflex.dynamics.contact_forces import add_contact_forces
from lcpflex.dynamics.mass_matrix import elastic_matrices, mass_matrix, overbent
from lcpflex.errors import ModelError, in_range
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.kinematics.joint_rows import joint_residual
from lcpflex.model.arrays import frozen
from lcpflex.model.coordinates import SPATIAL_KINDS
from lcpflex.model.layout import is_spatial
from lcpflex.steppers.event_driven.thresholds import SLIP_PART
from lcpflex.steppers.law_run import begin_laws, law_trouble
from lcpflex.steppers.scales import scales_of

if TYPE_CHECKING:
    from lcpflex.compile.compiled_scene import CompiledScene
    from lcpflex.dynamics.workspace import Workspace
    from lcpflex.force_laws.layout import UserLaw
    from lcpflex.steppers.system import System

__all__ = ["mechanics_at"]

UNIT = 1e-9  # how far quaternions may be from unit ones
DURATION = 1.0  # [s] of a run whose tolerances are meant where a scene has no speed of its own


def mechanics_at(
    compiled: CompiledScene,
    q: npt.ArrayLike | None,
    u: npt.ArrayLike | None,
    t: float,
    margin: float | None,
    gap_tolerance: float | None,
    velocity_threshold: float | None,
) -> StateMechanics:
    """See :meth:`lcpflex.compile.compiled_scene.CompiledScene.at`."""
    system = compiled.system()
    scales = scales_of(system, DURATION)
    tolerance = _bound("gap_tolerance", gap_tolerance, scales.gap(None, located=True))
    slow = _bound("velocity_threshold", velocity_threshold, 1e-6 * scales.speed)
    reach = max(_bound("margin", margin, system.margin), tolerance)
    t = in_range("t", t, -np.inf, np.inf)
    at_q = np.array(array_of("q", compiled.q if q is None else q, compiled.q.shape))
    at_u = np.array(array_of("u", compiled.u if u is None else u, compiled.u.shape))
    _refuse_no_rotations(compiled, at_q)
    for b in overbent(compiled.model, at_q):
        raise ModelError(
            f"q: body {compiled.layout.bodies[b]!r} is bent too far for its stiffening by spin, expected small "
            "deflections"
        )
    instant = _Instant(replace(system, q=at_q, u=at_u), t)
    arrays = instant.forces() | instant.joints(compiled.layout.joints) | instant.contacts(reach)
    sets = _index_sets(arrays, tolerance, slow)
    parts = {name: _checked(name, value) for name, value in (arrays | sets).items()}
    return StateMechanics(
        t=t,
        q=frozen(at_q),
        u=frozen(at_u),
        coordinates=coordinate_names(compiled.model.bodies, compiled.layout),
        velocities=velocity_names(compiled.model.bodies, compiled.layout),
        gap_tolerance=tolerance,
        velocity_threshold=slow,
        slip_threshold=SLIP_PART * slow,
        compiled=compiled,
        **parts,
    )


def _refuse_no_rotations(compiled: CompiledScene, q: FloatArray) -> None:
    """Raise ModelError for quaternions that are no rotations."""
    if not compiled.spatial:
        return
    for name, k in zip(compiled.layout.bodies, compiled.model.bodies.place.tolist(), strict=False):
        length = float(np.linalg.norm(q[k + 3 : k + 7]))
        if not abs(length - 1.0) <= UNIT:
            raise ModelError(
                f"q: the quaternion of body {name!r} has the length {length:.9g}, expected 1: a rotation, scalar first"
            )


def _bound(name: str, given: float | None, usual: float) -> float:
    return usual if given is None else in_range(name, given, 0.0, np.inf)


def _checked(name: str, value: Any) -> Any:
    """Arrays as read-only ones; raises ModelError where one is not finite."""
    if not isinstance(value, np.ndarray):
        return value
    if not np.isfinite(value).all():
        raise ModelError(f"q, u: {name} is not finite in the given state, expected smaller coordinates and velocities")
    return frozen(value, value.dtype)


def _slip_sizes(slip: FloatArray) -> FloatArray:
    """(m,) how fast contacts slip, of (m,) in the plane, of (m, 2) in space [m/s]."""
    return np.abs(slip) if slip.ndim == 1 else np.asarray(np.linalg.norm(slip, axis=1))


def _index_sets(arrays: dict[str, Any], gap_tolerance: float, slow: float) -> dict[str, IntArray]:
    """A, C, N, H, G of the contacts."""
    every = np.arange(len(arrays["gaps"]))
    closed = every[arrays["gaps"] <= gap_tolerance]
    still = closed[np.abs(arrays["gap_rates"][closed]) <= slow]
    sticking = (arrays["friction"] > 0.0) & (_slip_sizes(arrays["slip_speeds"]) <= SLIP_PART * slow)
    return {"A": every, "C": closed, "N": still, "H": still[sticking[still]], "G": still[~sticking[still]]}


class _Instant:
    """A system at one state, and the memory that its kernels work in."""

    def __init__(self, system: System, t: float) -> None:
        self._system, self._model = system, system.model
        self._t, self._q, self._u = t, system.q, system.u
        self._work: Workspace = system.workspace(1)
        self._own: list[tuple[str, UserLaw]] = [("", function) for function in system.functions]
        for name, law in zip(system.names, system.laws, strict=False):
            own = None if law is None else law.row().own
            self._own += [] if own is None else [(f"contact {name!r}: ", own)]

    def forces(self) -> dict[str, Any]:
        """M, h and what h is made of."""
        model, work = self._model, self._work
        for _, function in self._own:
            function.begin()
        supply = self._system.hooks.get(mechanics.supply)
        if supply is not None:
            supply(model, self._t, self._q, self._u, work)
        mechanics.forces(model, self._t, self._q, self._u, work)
        smooth = work.free.total.copy()
        compliant = self._compliant()
        self._check_functions()
        stiffness, damping = elastic_matrices(model, self._q)
        force = work.free.total - smooth if compliant else np.zeros_like(smooth)
        return {
            "M": mass_matrix(model, self._q),
            "h": work.free.total.copy(),
            "stiffness": stiffness,
            "damping": damping,
            "compliant": CompliantForces(**self._touching(), force=_checked("compliant.force", force)),
        }

    def _check_functions(self) -> None:
        """Raise ModelError for what went wrong in functions of the user's since ``forces`` began."""
        words = "; ".join(prefix + told for prefix, function in self._own if (told := function.complaint()))
        if words:
            raise ModelError(words)

    def _compliant(self) -> bool:
        """Add the forces of contacts with a force law to those in the workspace; whether there may be some."""
        system, work = self._system, self._work
        if not system.is_compliant:
            return False
        begin_laws(system, work)
        if work.compliant.needed == 0 and work.compliant.out_of_range < 0:
            add_contact_forces(self._model, self._q, self._u, work)
        if work.compliant.needed or work.compliant.out_of_range >= 0:
            raise ModelError(f"q: {law_trouble(system.names, work)}")
        return True

    def _touching(self) -> dict[str, Any]:
        """The contacts with a force law that touch."""
        system, contacts = self._system, self._work.compliant
        n = int(contacts.rows.n_contacts)
        slip = np.full(n, np.nan)
        rubbing = contacts.rows.tangent[: contacts.rows.n_tangents]
        slip[rubbing] = contacts.slip[rubbing]
        touch = np.flatnonzero(contacts.rows.table.gap[:n] <= 0.0)
        laws = contacts.rows.table.law[touch].tolist()
        given = [system.laws[law] for law in laws]
        return {
            "names": tuple(system.name_of(law) for law in laws),
            "gaps": frozen(contacts.rows.table.gap[touch]),
            "gap_rates": frozen(contacts.rate[touch]),
            "slip_speeds": frozen(slip[touch]),
            "normal": frozen(contacts.p[touch, 0]),
            "tangential": frozen(contacts.p[touch, 1]),
            "remembers": tuple(law is not None and (law.row().remembers or law.row().bristles) for law in given),
        }

    def joints(self, names: tuple[str, ...]) -> dict[str, Any]:
        """Rows of all joints, after ``forces``."""
        model, work, t = self._model, self._work, self._t
        joints, r = model.joints, self._system.n_joint
        phi = np.zeros(r)
        if r:
            joint_residual(model, t, self._q, work.free.external, phi)
            mechanics.fill_joint_rows(model, t, self._q, self._u, work.free.external, work.rows)
            self._check_functions()
        J = self._dense(work.rows.J[:r], work.rows.body[:r])
        rows = np.repeat(np.arange(len(names)), np.diff(joints.row))
        return {
            "joints": tuple(names[k] for k in rows),
            "joint_kinds": tuple(SPATIAL_KINDS[kind] for kind in joints.kind),
            "J": J,
            "joint_gaps": phi,
            "joint_rates": J @ self._u + work.rows.rate[:r],
            "phi_t": work.rows.rate[:r].copy(),
            "gamma": -work.rows.bias[:r],
        }

    def contacts(self, margin: float) -> dict[str, Any]:
        """Rows of all rigid contacts with gaps up to ``margin`` [m]."""
        model, contacts = self._model, self._model.contacts
        table, m = self._detected(margin)
        laws, body = table.law[:m], table.body[:m]
        in_space = is_spatial(model)
        if in_space:
            from lcpflex.compile.spatial.state_contacts import spatial_contacts

            told = spatial_contacts(self._system, self._q, self._u, table, m)
        else:
            told = self._planar(table, m)
        rows, w = told.pop("rows"), told.pop("w")
        W = [self._dense(rows[:, c], body).T for c in range(rows.shape[1])]
        slip = [along.T @ self._u for along in W[1:]]
        return {
            "contacts": tuple(self._system.name_of(int(law)) for law in laws),
            "keys": table.key[:m].copy(),
            **told,
            "gaps": table.gap[:m].copy(),
            "gap_rates": W[0].T @ self._u,
            "slip_speeds": np.stack(slip, axis=1) if in_space else slip[0],
            "W_N": W[0],
            "W_T": np.stack(W[1:], axis=2) if in_space else W[1],
            "w_N": w[:, 0],
            "w_T": w[:, 1:] if in_space else w[:, 1],
            "friction": contacts.friction[laws],
            "restitution": contacts.restitution[laws],
            "tangential_restitution": contacts.tangential_restitution[laws],
        }

    def _planar(self, table: ContactTable, m: int) -> dict[str, Any]:
        """Geometry, rows (m, 2, 2, width) and biases (m, 2) of the first m entries of a table."""
        rows, w = np.zeros((m, 2, 2, self._work.rows.J.shape[2])), np.zeros((m, 2))
        places, normals = np.zeros((m, 2)), table.normal[:m].copy()
        for k in range(m):
            contact_rows(self._model, self._q, table, k, rows[k, 0], rows[k, 1:])
            w[k] = contact_bias(self._model, self._q, self._u, table, k)
            places[k] = contact_point(self._model, self._q, table, k)
        tangents = np.column_stack([normals[:, 1], -normals[:, 0]])[:, None]
        return {"places": places, "normals": normals, "tangents": tangents, "rows": rows, "w": w}

    def _detected(self, margin: float) -> tuple[ContactTable, int]:
        """A table with room for all rigid contacts, and their number."""
        system, capacity = self._system, 16
        while True:
            table = system.table(capacity)
            found = int(detect(system.model, self._q, margin, table))
            if found <= capacity:
                return table, found
            if found == MORE_LAWS:
                system.more_laws()
            else:
                capacity = found

    def _dense(self, rows: FloatArray, row_body: IntArray) -> FloatArray:
        """(k, ndof) rows of blocks (k, 2, width) of the bodies (k, 2)."""
        dense = np.zeros((len(rows), len(self._u)))
        for r, b, block in self._blocks(row_body):
            dense[r, block] += rows[r, b, : block.stop - block.start]
        return dense

    def _blocks(self, row_body: IntArray) -> Iterator[tuple[int, int, slice]]:
        """Row, which of its two blocks, and the coordinates of that body; none of the ground."""
        dof = self._model.bodies.dof
        for r, b in np.argwhere(row_body >= 0).tolist():
            body = int(row_body[r, b])
            yield r, b, slice(int(dof[body]), int(dof[body + 1]))
