"""The mechanics of a scene at one state, as arrays with names: for methods that users write themselves.

    M udot = h + W_N lambda_N + W_T lambda_T + J^T lambda_J,    gddot_N = W_N^T udot + w_N,    J udot = gamma

Sources: Ebrahimi & Eberhard 2005, equations 3 to 9; Pfeiffer & Glocker 1996 (index sets).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from lcpflex.basics.arguments import one_of
from lcpflex.compile.material import material_of
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.kinematics.places import velocity_rows
from lcpflex.model.arrays import frozen
from lcpflex.solvers.contact.problem import ContactProblem

if TYPE_CHECKING:
    from lcpflex.compile.compiled_scene import CompiledScene
    from lcpflex.solvers.contact.spatial import SpatialContactProblem

__all__ = ["CompliantForces", "StateMechanics"]

LEVELS = ("acceleration", "impulse")
INDEPENDENT = 1e-12  # singular values of the scaled J M^-1 J^T below this part of the largest: redundant joint rows


@dataclass(frozen=True, slots=True, eq=False)
class CompliantForces:
    """The contacts with a force law that touch in a state, c of them: their forces are a part of ``h``, not unknowns.

    They are those of a run that starts in this state. A law that remembers begins here: as if the contact had come from
    its touch without loss, is now at its largest indentation, and its bristles are not deflected.

    Attributes
    ----------
    names
        (c,) declared contact of each; a contact has as many entries as points that touch.
    gaps
        (c,) g_N < 0 [m].
    gap_rates, slip_speeds
        (c,) gdot_N and gdot_T [m/s]; without friction gdot_T is NaN.
    normal, tangential
        (c,) forces [N].
    force
        (n,) the generalised force of all of them, which ``StateMechanics.h`` contains.
    remembers
        (c,) whether the law depends on what was before this state.
    """

    names: tuple[str, ...]
    gaps: FloatArray
    gap_rates: FloatArray
    slip_speeds: FloatArray
    normal: FloatArray
    tangential: FloatArray
    force: FloatArray
    remembers: tuple[bool, ...]


@dataclass(frozen=True, slots=True, eq=False)
class StateMechanics:
    """Equations of motion, contacts and joints of a scene at one state; all arrays are read-only.

        M udot = h + W_N lambda_N + W_T lambda_T + J^T lambda_J
        gdot_N = W_N^T u,    gddot_N = W_N^T udot + w_N        (likewise T)
        phidot = J u + phi_t,    phiddot = J udot - gamma        of the joints phi(q, t) = 0

    n velocities, and nq coordinates, in the plane as many; m rigid contacts (a declared contact has an entry for each
    pair of a node and a surface part that is near), r joint rows. The normal points from the second body to the first,
    whose force lambda_N pushes it along the normal; the tangent is the normal turned clockwise by a right angle. In
    space the first body is that of the surface that was declared first, and there are two tangents, t1 and t2 = n x t1.

    Attributes
    ----------
    t, q, u
        The state: time [s], configuration (nq,) and velocity (n,).
    coordinates, velocities
        Names of q and of u: ``body.x``, ``body.y``, ``body.angle``, ``body.mode 1``, ...; in space q has ``body.x`` to
        ``body.z`` and ``body.p0`` to ``body.p3``, u ``body.v_x`` to ``body.v_z`` and ``body.omega_x`` to
        ``body.omega_z``, the angular velocity in body axes.
    M
        (n, n) mass matrix, of units that make u^T M u / 2 an energy [J].
    h
        (n,) all generalised forces but those of joints and rigid contacts: weight, loads, springs, gyroscopic and
        elastic forces, damping, and contacts with a force law (``compliant``).
    stiffness, damping
        (n, n) of the bodies alone: h contains -stiffness @ q - damping @ u (with axial forces on bending, ``stiffness``
        is the derivative there; in space of the modal coordinates, in the places of their rates). Time stepping needs
        them for an implicit step; springs are not in them.
    contacts
        (m,) name of the declared contact.
    keys
        (m,) number of the pair of node and surface part, the same in other states of the scene.
    places, normals, tangents
        (m, 2), in space (m, 3), point of contact [m] and unit normal, world axes; tangents (m, 1, 2), in space
        (m, 2, 3).
    gaps, gap_rates, slip_speeds
        (m,) g_N [m], gdot_N and gdot_T [m/s]; in space gdot_T (m, 2).
    W_N, W_T
        (n, m) directions of the contact forces, frictionless contacts too; in space W_T (n, m, 2).
    w_N, w_T
        (m,) parts of gddot_N and gddot_T without udot [m/s^2]; in space w_T (m, 2).
    friction, restitution, tangential_restitution
        (m,) mu, e_N, e_T [-].
    joints, joint_kinds
        (r,) name of the joint of each row, and what it prescribes: component, along, angle, distance.
    J
        (r, n).
    joint_gaps, joint_rates
        (r,) phi and phidot, 0 where the state fulfils the joints [m], [m/s] or [rad], [rad/s].
    phi_t
        (r,) partial derivative of phi by time, -f' of a drive f(t).
    gamma
        (r,) what J udot has to be [m/s^2] or [rad/s^2]: the right-hand side of Ebrahimi & Eberhard, equation 6.
    A, C, N, H, G
        Index sets, ascending: all m contacts; closed, g_N <= gap_tolerance; closed with
        |gdot_N| <= velocity_threshold; of N those that may stick, mu > 0 and |gdot_T| <= slip_threshold; N without H.
    compliant
        Contacts with a force law that touch: in no index set, they are a part of h.
    gap_tolerance, velocity_threshold, slip_threshold
        What counted as closed [m], as no approach and as no slip [m/s].
    compiled
        The scene that this is a state of.
    """

    t: float
    q: FloatArray
    u: FloatArray
    coordinates: tuple[str, ...]
    velocities: tuple[str, ...]
    M: FloatArray
    h: FloatArray
    stiffness: FloatArray
    damping: FloatArray
    contacts: tuple[str, ...]
    keys: IntArray
    places: FloatArray
    normals: FloatArray
    tangents: FloatArray
    gaps: FloatArray
    gap_rates: FloatArray
    slip_speeds: FloatArray
    W_N: FloatArray
    W_T: FloatArray
    w_N: FloatArray
    w_T: FloatArray
    friction: FloatArray
    restitution: FloatArray
    tangential_restitution: FloatArray
    joints: tuple[str, ...]
    joint_kinds: tuple[str, ...]
    J: FloatArray
    joint_gaps: FloatArray
    joint_rates: FloatArray
    phi_t: FloatArray
    gamma: FloatArray
    A: IntArray
    C: IntArray
    N: IntArray
    H: IntArray
    G: IntArray
    compliant: CompliantForces
    gap_tolerance: float
    velocity_threshold: float
    slip_threshold: float
    compiled: CompiledScene = field(repr=False)

    def velocity_rows(self, body: str, point: str | tuple[float, ...] = "center") -> FloatArray:
        """L (2, n) of a material point, in space (3, n): its velocity is rdot_P = L u, world axes.

        Equation 1 of Ebrahimi & Eberhard. A force F at the point adds L^T F to ``h``, and for two points that touch,
        the first on the first body, W_N = (L_i - L_j)^T n and likewise W_T with the tangents.

        Parameters
        ----------
        body
            Its name.
        point
            The name of a point of the body, or its undeformed place (x, y) or (x, y, z) [m] in the frame of the body:
            anywhere on a rigid body, on the outline or at a named point of a flexible one.

        Raises
        ------
        ModelError
            For a body or point that is none.
        """
        model, b, place, phi = material_of(self.compiled, body, point)
        return frozen(velocity_rows(model, self.q, b, place, phi))

    def contact_problem(self, level: str = "acceleration") -> ContactProblem | SpatialContactProblem:
        """The contact problem with the joints condensed: contact accelerations or velocities are G lambda + free.

        With P = M^-1 - M^-1 J^T (J M^-1 J^T)^-1 J M^-1, what forces accelerate while the joints hold:

        * "acceleration": contacts N, forces [N], rows [gddot_N; gddot_H] (Ebrahimi & Eberhard, equation 9). G contains
          [W_N, W_H]^T P [W_N + W_G mu_G, W_H] with mu_G = -mu sign(gdot_T): the friction of sliding contacts is in
          the columns of their normals, ``friction`` of the problem is 0 for them, and their tangential force is
          mu_G lambda_N.
        * "impulse": contacts C, impulses [N s], rows [gdot_N+ + e_N gdot_N-; gdot_T+ + e_T gdot_T-], Newton's law at
          this instant. Normal velocities up to ``velocity_threshold`` are not reflected (e_N = 0).

        In space it is a :class:`lcpflex.solvers.SpatialContactProblem`, with rows n, t1, t2 of each contact in turn;
        the friction of a sliding contact is against its slip, -mu gdot_T / |gdot_T|.

        Keys are (name of the contact, its index). Redundant joint rows are allowed.

        Raises
        ------
        ModelError
            For another level, and at the level of accelerations for a closed contact that approaches: its impact
            comes first.
        """
        in_space = self.W_T.ndim == 3
        if one_of("level", level, LEVELS) == "impulse":
            return _in_space(self, level) if in_space else self._impulses()
        for k in self.C:
            if self.gap_rates[k] < -self.velocity_threshold:
                raise ModelError(
                    f"level: 'acceleration' was given, and contact {self.contacts[k]!r} approaches at "
                    f"{-self.gap_rates[k]:.6g} m/s, expected 'impulse': its impact comes first"
                )
        if in_space:
            return _in_space(self, level)
        H, N = self.H, self.N
        columns = self.W_N[:, N].copy()
        sliding = np.isin(N, self.G)
        columns[:, sliding] -= self.W_T[:, self.G] * (self.friction * np.sign(self.slip_speeds))[self.G]
        rows = np.hstack([self.W_N[:, N], self.W_T[:, H]])
        known = np.concatenate([self.w_N[N], self.w_T[H]])
        held, kept = self.condensed(np.column_stack([columns, self.W_T[:, H], self.h]), self.gamma)
        friction = np.where(sliding, 0.0, self.friction[N])
        return self._problem(rows.T @ held[:, :-1], rows.T @ (held[:, -1] + kept) + known, friction, N)

    def _impulses(self) -> ContactProblem:
        """That of an impact of all closed contacts."""
        C = self.C
        rough = C[self.friction[C] > 0.0]
        rows = np.hstack([self.W_N[:, C], self.W_T[:, rough]])
        held, kept = self.condensed(rows, self.joint_rates)
        reflected = np.where(np.abs(self.gap_rates[C]) > self.velocity_threshold, self.restitution[C], 0.0)
        before = reflected * self.gap_rates[C], self.tangential_restitution[rough] * self.slip_speeds[rough]
        return self._problem(rows.T @ held, rows.T @ (self.u - kept) + np.concatenate(before), self.friction[C], C)

    def _problem(self, G: FloatArray, free: FloatArray, friction: FloatArray, chosen: IntArray) -> ContactProblem:
        return ContactProblem(G, free, friction, tuple((self.contacts[k], int(k)) for k in chosen))

    def condensed(self, columns: FloatArray, rates: FloatArray) -> tuple[FloatArray, FloatArray]:
        """P columns (n, k), and M^-1 J^T (J M^-1 J^T)^-1 rates (n,), the shortest motion in the metric of M.

        columns: (n, k) forces. rates: (r,) what J times the motion is to be.
        """
        spread = np.asarray(np.linalg.solve(self.M, np.column_stack([columns, self.J.T])))
        moved, answers = spread[:, : columns.shape[1]], spread[:, columns.shape[1] :]
        if not len(self.J):
            return moved, np.zeros(len(self.M))
        S = self.J @ answers
        scale = 1.0 / np.sqrt(np.diag(S))  # rows of lengths and of angles
        inverse = np.linalg.pinv(S * np.outer(scale, scale), rcond=INDEPENDENT, hermitian=True) * np.outer(scale, scale)
        held = moved - answers @ (inverse @ (self.J @ moved))
        return np.asarray(held), np.asarray(answers @ (inverse @ rates))


def _in_space(at: StateMechanics, level: str) -> SpatialContactProblem:
    from lcpflex.compile.spatial.state_contacts import accelerations, impulses  # which the plane does without

    return impulses(at) if level == "impulse" else accelerations(at)
