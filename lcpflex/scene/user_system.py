"""A system given by its own functions: M(q), h(t, q, u), gaps, W and w, and joint rows if it has any.

    M(q) udot + C u + K q = h(t, q, u) + J^T lambda + W_N lambda_N + W_T lambda_T,   qdot = B(q) u

It is advanced by the same steppers and solvers as a scene; its functions are called from Python.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from lcpflex.basics.arguments import numbers
from lcpflex.errors import ModelError, in_range, shown
from lcpflex.scene import compiling
from lcpflex.scene.sensors.sensor import Sensor, named_sensors
from lcpflex.scene.user_functions import check_names
from lcpflex.scene.user_kinematics import UserKinematics, call, user_array

if TYPE_CHECKING:
    from lcpflex.jit.kernel import FloatArray
    from lcpflex.scene.compiling import System

__all__ = ["UserSystem"]

JOINT_TOLERANCE = 1e-9  # initial violation of joints, times 1 + the largest |q|, that is no error; rates alike
PENETRATION = 1e-6  # initial penetration, times the same, that is no error
DIFFERENCE_STEP = 2e-4  # of time derivatives [s]


@dataclass(frozen=True, slots=True, eq=False)
class UserSystem:
    """Mechanics written as Python functions of arrays, n velocities, m contacts, r joint rows.

    A configuration has n coordinates, qdot = u; or nq >= n numbers, as with quaternions, qdot = ``kinematics``(q) u.

    Attributes
    ----------
    q, u
        Initial configuration (nq,) and velocity (n,).
    mass
        M, symmetric positive definite: an (n, n) array or a function q -> (n, n).
    force
        h: function (t, q, u) -> (n,) of all forces but those of ``stiffness``, ``damping`` and constraints.
    gaps
        Function q -> (m,) [m], positive open.
    normals, tangents
        W_N and W_T: (n, m) arrays or functions q -> (n, m); gdot = W^T u. No ``tangents`` are needed without friction.
        W_T (n, m, 2) has two directions at right angles for each contact, whose friction is then that of space: the
        circular cone. Forces of friction in the record are along these two, a third number is 0.
    normal_bias, tangent_bias
        w: functions (q, u) -> (m,) with gddot = W^T udot + w, (m, 2) for two directions; where omitted, (d/dt W)^T u by
        central differences.
    friction, restitution, tangential_restitution
        mu >= 0, e_N and e_T in [0, 1]: numbers or (m,).
    names
        Names of the contacts.
    stiffness, damping
        Constant K and C, (n, n), symmetric positive semidefinite, which time-stepping schemes treat implicitly.
    potential
        Potential energy of ``force`` as a function of q [J]; without it all of ``force``, and what changes of M do,
        u^T (dM/dt) u / 2, counts as work of loads.
    constraints, jacobian
        phi(t, q) -> (r,) and J(t, q) -> (r, n) of bilateral joints.
    constraint_rate, constraint_bias
        Functions (t, q) -> (r,), the partial time derivative of phi, and (t, q, u) -> (r,), phiddot - J udot; where
        omitted, by central differences, for which phi and J are called a little before the start, too.
    kinematics
        B with qdot = B u: an (nq, n) array or a function q -> (nq, n), of rank n; where omitted, the unit matrix. Steps
        move q along B by the midpoint rule, Runge-Kutta and implicit methods integrate B u; position corrections are
        moves, too. Moreau-Jean takes ``force`` once more at the mean velocity of its step (as for bodies in space).
    normalise
        Function q -> (nq,) that takes out of q what integration has left beside the configurations, as the length of
        quaternions; with ``kinematics`` only.
    sensors
        What is measured beside the record: ``lf.sensors.Coordinates``, ``Contact``, ``Energy`` and ``Function``, see
        :meth:`lcpflex.Scene.sensor`; without a name they are called sensor1, sensor2, ...

    Raises
    ------
    ModelError
        For an argument of a wrong shape or range, or a function that fails or returns a wrong shape at the start;
        when simulated, for a start that violates joints or penetrates.
    """

    q: npt.ArrayLike
    u: npt.ArrayLike
    mass: npt.ArrayLike | Callable[..., Any]
    force: Callable[..., Any]
    gaps: Callable[..., Any] | None = None
    normals: npt.ArrayLike | Callable[..., Any] | None = None
    tangents: npt.ArrayLike | Callable[..., Any] | None = None
    normal_bias: Callable[..., Any] | None = None
    tangent_bias: Callable[..., Any] | None = None
    friction: npt.ArrayLike = 0.0
    restitution: npt.ArrayLike = 0.0
    tangential_restitution: npt.ArrayLike = 0.0
    names: Sequence[str] = ()
    stiffness: npt.ArrayLike | None = None
    damping: npt.ArrayLike | None = None
    potential: Callable[..., Any] | None = None
    constraints: Callable[..., Any] | None = None
    jacobian: Callable[..., Any] | None = None
    constraint_rate: Callable[..., Any] | None = None
    constraint_bias: Callable[..., Any] | None = None
    sensors: Sequence[Sensor] = ()
    kinematics: npt.ArrayLike | Callable[..., Any] | None = None
    normalise: Callable[..., Any] | None = None
    _functions: Functions = field(init=False, repr=False)

    def __reduce__(self) -> tuple[Any, ...]:
        """By its arguments; functions by their names, ModelError for one that cannot be found by it."""
        given = {part.name: getattr(self, part.name) for part in fields(self) if part.init}
        check_names((f"UserSystem: {name}", value) for name, value in given.items())
        check_names((f"sensor {one.name!r}: function", getattr(one, "function", None)) for one in self.sensors)
        return UserSystem, tuple(given.values())

    def __deepcopy__(self, memo: dict[int, Any]) -> UserSystem:
        """A system cannot be changed."""
        return self

    def __post_init__(self) -> None:
        q = user_array("q", self.q, (-1,))
        if not q.size:
            raise ModelError("q: an empty array was given, expected at least one coordinate")
        for name in ("force", *OPTIONAL):
            if not callable(getattr(self, name)) and not (name in OPTIONAL and getattr(self, name) is None):
                raise ModelError(f"{name}: {shown(getattr(self, name))} was given, expected a function")
        u = user_array("u", self.u, q.shape if self.kinematics is None else (-1,))
        n = len(u)
        if not 0 < n <= len(q):
            raise ModelError(f"u: {n} velocities were given with {len(q)} numbers in q, expected 1 to {len(q)}")
        if self.normalise is not None and self.kinematics is None:
            raise ModelError("normalise: a function was given without kinematics, expected both, or None")
        if self.stiffness is not None and self.kinematics is not None:
            raise ModelError("stiffness: a matrix was given with kinematics, expected None (it is part of force then)")
        kinematics = UserKinematics(self.kinematics, self.normalise, len(q), n)
        q = kinematics.start(q)
        object.__setattr__(self, "q", q)
        object.__setattr__(self, "u", u)
        if (self.gaps is None) != (self.normals is None):
            raise ModelError("gaps and normals: one was given without the other, expected both or neither")
        if (self.constraints is None) != (self.jacobian is None):
            raise ModelError("constraints and jacobian: one was given without the other, expected both or neither")
        m = len(call("gaps", self.gaps, (-1,), q)) if self.gaps is not None else 0
        for name, high in (("friction", math.inf), ("restitution", 1.0), ("tangential_restitution", 1.0)):
            given = numbers(getattr(self, name))
            if given is None or given.shape not in ((), (m,)):
                raise ModelError(f"{name}: {shown(getattr(self, name))} was given, expected a number or {m} of them")
            values = [in_range(name, value, 0.0, high) for value in given.reshape(-1).tolist()]
            object.__setattr__(self, name, np.array(values * m if given.shape == () else values))
        listed = isinstance(self.names, Sequence) and not isinstance(self.names, str) and len(self.names) in (0, m)
        names = (tuple(self.names) or tuple(f"contact{k + 1}" for k in range(m))) if listed else ()
        texts = all(isinstance(name, str) and name for name in names)
        if not listed or not texts or len(names) != m or len(set(names)) != m:
            raise ModelError(f"names: {shown(self.names)} was given, expected {m} different names")
        object.__setattr__(self, "names", names)
        if self.tangents is None and np.any(self.friction):
            raise ModelError("tangents: None was given, expected W_T because friction is not zero")
        for name in ("stiffness", "damping"):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, _semidefinite(name, user_array(name, getattr(self, name), (n, n))))
        object.__setattr__(self, "sensors", named_sensors(self.sensors))
        object.__setattr__(self, "_functions", Functions(self, kinematics, n, m))
        self._functions.try_all()

    def system(self, project: bool = False, indents: Callable[[str], bool] | None = None) -> System:
        """What a stepper takes; with ``project``, started at the nearest state that fulfils the joints.

        ``indents`` tells of a contact whether the stepper has a force law for it, on whose indentation it may rest.
        """
        return compiling.system_of(self, project, indents)


OPTIONAL = (
    "gaps", "normal_bias", "tangent_bias", "potential", "constraints", "jacobian", "constraint_rate", "constraint_bias",
    "normalise",
)  # fmt: skip


def _semidefinite(name: str, matrix: FloatArray) -> FloatArray:
    """The matrix, if it is symmetric and positive semidefinite."""
    largest = float(np.abs(matrix).max())
    if not np.allclose(matrix, matrix.T, rtol=0.0, atol=1e-9 * largest):
        raise ModelError(f"{name}: an unsymmetric matrix was given, expected a symmetric one (the rest is force)")
    least = float(np.linalg.eigvalsh(matrix)[0])
    if least < -1e-9 * largest:
        raise ModelError(
            f"{name}: a matrix with the eigenvalue {least:.6g} was given, expected a positive semidefinite one "
            "(what feeds energy in is force)"
        )
    return matrix


class Functions:
    """The functions of a :class:`UserSystem`, each checked at every call, with defaults for those left out."""

    def __init__(self, given: UserSystem, kinematics: UserKinematics, n: int, m: int) -> None:
        self._given = given
        self.kinematics = kinematics
        self._across: tuple[int, ...] = (2,) if m and _two_directions(given) else ()
        self.n = n
        self.m = m
        self.stiffness, self.damping = self._of("stiffness", (n, n)), self._of("damping", (n, n))
        self.friction = np.asarray(given.friction, dtype=float)
        start = np.asarray(given.q, dtype=float)
        self.n_joint = (
            0 if given.constraints is None else len(call("constraints", given.constraints, (-1,), 0.0, start))
        )

    def try_all(self) -> None:
        """Call every function once at the initial state, so that a wrong one is refused before time is spent."""
        q = np.asarray(self._given.q, dtype=float)
        u = np.asarray(self._given.u, dtype=float)
        mass = self.mass(q)
        if not np.allclose(mass, mass.T, rtol=1e-10, atol=1e-12 * float(np.abs(mass).max())):
            raise ModelError("mass: an unsymmetric matrix was given, expected M(q) symmetric positive definite")
        try:
            np.linalg.cholesky(mass)
        except np.linalg.LinAlgError:
            raise ModelError(
                "mass: an indefinite matrix was given, expected M(q) symmetric positive definite"
            ) from None
        self.force(0.0, q, u)
        self.potential(q)
        if self.m:
            self.gaps(q)
            self.normals(q)
            self.tangents(q)
            self.biases(q, u)
        if self.n_joint:
            self.residual(0.0, q)
            self.jacobian(0.0, q)
            self.rate(0.0, q)
            self.constraint_bias(0.0, q, u)

    def start(
        self, q: FloatArray, u: FloatArray, project: bool, indents: Callable[[str], bool] | None
    ) -> tuple[FloatArray, FloatArray]:
        """The start, or its projection onto the joints in the mass metric; ModelError where it cannot be."""
        scale = 1.0 + float(np.abs(q).max())
        if self.n_joint:
            if project:
                q, u = self._projected(q, u, 1e-3 * JOINT_TOLERANCE * scale)
            hint = "the joints contradict each other" if project else "change it, or use project=True"
            J, rate = self.jacobian(0.0, q), self.rate(0.0, q)
            speed = float((np.abs(J) @ np.abs(u) + np.abs(rate)).max())
            for name, violated, allowed in (
                ("q", self.residual(0.0, q), JOINT_TOLERANCE * scale),
                ("u", J @ u + rate, JOINT_TOLERANCE * (scale + speed)),
            ):
                worst = int(np.argmax(np.abs(violated)))
                if not abs(violated[worst]) <= allowed:
                    raise ModelError(
                        f"{name}: the start violates row {worst} of the constraints by {violated[worst]:.6g}, "
                        f"expected at most {allowed:.1g}: {hint}"
                    )
        soft = np.array([indents is not None and indents(name) for name in self._given.names], dtype=bool)
        gaps = np.where(soft, np.inf, self.gaps(q)) if self.m else np.zeros(0)
        if gaps.size and not gaps.min() >= -PENETRATION * scale:
            name = self._given.names[int(gaps.argmin())]
            raise ModelError(
                f"q: contact {name!r} penetrates by {-gaps.min():.6g} m at the start, "
                f"expected at most {PENETRATION * scale:.1g} m"
            )
        return q, u

    def _projected(self, q: FloatArray, u: FloatArray, tolerance: float) -> tuple[FloatArray, FloatArray]:
        """Newton steps dq = -M^-1 J^T (J M^-1 J^T)^+ phi, and one such step for u."""

        def nearest(J: FloatArray, residual: FloatArray) -> FloatArray:
            spread = np.linalg.solve(self.mass(q), J.T)
            return np.asarray(spread @ (np.linalg.pinv(J @ spread, rcond=1e-12, hermitian=True) @ residual))

        for _ in range(50):
            phi = self.residual(0.0, q)
            if (np.abs(phi) <= tolerance).all():
                break
            q = self.kinematics.moved(q, nearest(self.jacobian(0.0, q), phi), -1.0)
        J = self.jacobian(0.0, q)
        return q, u - nearest(J, J @ u + self.rate(0.0, q))

    def _of(self, name: str, shape: tuple[int, ...], *arguments: Any) -> FloatArray:
        """What was given as ``name``: a function, asked with copies of the arguments, or an array; zeros for None."""
        given = getattr(self._given, name)
        if given is None:
            return np.zeros(shape)
        copies = [one.copy() if isinstance(one, np.ndarray) else one for one in arguments]
        return call(name, given, shape, *copies) if callable(given) else user_array(name, given, shape)

    def mass(self, q: FloatArray) -> FloatArray:
        """M (n, n)."""
        return self._of("mass", (self.n, self.n), q)

    @property
    def books_inertia(self) -> bool:
        """Whether M is a function of q and ``force`` has no known potential: u^T (dM/dt) u / 2 is part of its work."""
        return callable(self._given.mass) and not self.has_potential

    def mass_rate(self, q: FloatArray, u: FloatArray) -> FloatArray:
        """dM/dt (n, n) along the motion, by central differences."""
        e = _difference_step(q, u)
        moved = self.kinematics.moved
        return np.asarray((self.mass(moved(q, u, e)) - self.mass(moved(q, u, -e))) / (2.0 * e))

    def force(self, t: float, q: FloatArray, u: FloatArray) -> FloatArray:
        """h (n,)."""
        return self._of("force", (self.n,), t, q, u)

    @property
    def has_potential(self) -> bool:
        """Whether ``force`` has a known potential."""
        return self._given.potential is not None

    def potential(self, q: FloatArray) -> float:
        """Potential energy of ``force`` [J]; 0 where unknown."""
        return float(self._of("potential", (), q))

    def gaps(self, q: FloatArray) -> FloatArray:
        """g_N (m,)."""
        return self._of("gaps", (self.m,), q)

    def normals(self, q: FloatArray) -> FloatArray:
        """W_N (n, m)."""
        return self._of("normals", (self.n, self.m), q)

    @property
    def has_cones(self) -> bool:
        """Whether contacts slide in planes, and not along lines."""
        return bool(self._across)

    def tangents(self, q: FloatArray) -> FloatArray:
        """W_T (n, m), or (n, m, 2)."""
        return self._of("tangents", (self.n, self.m, *self._across), q)

    def biases(self, q: FloatArray, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        """w_N (m,) and w_T, (m,) or (m, 2)."""
        normal = self._bias("normal_bias", self.normals, (self.m,), q, u)
        return normal, self._bias("tangent_bias", self.tangents, (self.m, *self._across), q, u)

    def _bias(
        self, name: str, w: Callable[[FloatArray], FloatArray], shape: tuple[int, ...], q: FloatArray, u: FloatArray
    ) -> FloatArray:
        if getattr(self._given, name) is not None:
            return self._of(name, shape, q, u)
        e = _difference_step(q, u)  # (d/dt W)^T u along the motion, by central differences
        moved = self.kinematics.moved
        change = w(moved(q, u, e)) - w(moved(q, u, -e))
        return np.asarray(np.reshape(change.reshape(self.n, -1).T @ u / (2.0 * e), shape))

    def residual(self, t: float, q: FloatArray) -> FloatArray:
        """phi (r,)."""
        return self._of("constraints", (self.n_joint,), t, q)

    def jacobian(self, t: float, q: FloatArray) -> FloatArray:
        """J (r, n)."""
        return self._of("jacobian", (self.n_joint, self.n), t, q)

    def rate(self, t: float, q: FloatArray) -> FloatArray:
        """Partial time derivative of phi (r,)."""
        if self._given.constraint_rate is None:
            h = DIFFERENCE_STEP
            far_before, before, after, far_after = (self.residual(t + k * h, q) for k in (-2, -1, 1, 2))
            return np.asarray((8.0 * (after - before) - (far_after - far_before)) / (12.0 * h))
        return self._of("constraint_rate", (self.n_joint,), t, q)

    def constraint_bias(self, t: float, q: FloatArray, u: FloatArray) -> FloatArray:
        """phiddot - J udot (r,)."""
        if self._given.constraint_bias is not None:
            return self._of("constraint_bias", (self.n_joint,), t, q, u)
        e = _difference_step(q, u)
        after, before = self.kinematics.moved(q, u, e), self.kinematics.moved(q, u, -e)
        ahead = self.jacobian(t + e, after) @ u + self.rate(t + e, after)
        behind = self.jacobian(t - e, before) @ u + self.rate(t - e, before)
        return np.asarray((ahead - behind) / (2.0 * e))


def _two_directions(given: UserSystem) -> bool:
    """Whether W_T has two columns for each contact."""
    tangents: Any = given.tangents
    try:
        start = np.array(given.q, dtype=float)
        return np.ndim(tangents(start) if callable(tangents) else tangents) == 3
    except Exception:  # said of what is wrong with it where it is asked for its values
        return False


def _difference_step(q: FloatArray, u: FloatArray) -> float:
    """Time step [s] that moves the configuration by about 1e-5 of its size: the best of a central difference."""
    return 1e-5 * (1.0 + float(np.abs(q).max(initial=0.0))) / max(1.0, float(np.abs(u).max(initial=0.0)))
