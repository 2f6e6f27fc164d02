"""Small vibrations of a scene about the state in which it rests, or turns as a whole.

Seen from axes that turn at omega about the origin of the world, a scene that turns with them rests. With the residual

    r(q, v, w, lambda) = M(q) udot - h(q, u) - J^T lambda,   phi(q) = 0

where u and udot belong to the motion that has the velocity v and the acceleration w as seen from the turning axes, the
state (q, lambda) is the one with r(q, 0, 0, lambda) = 0, and small motions d q = Z y about it, J Z = 0, follow

    Z^T (M w + (dr/dv) v + (dr/dq) d q) = 0

Derivatives are central differences of r.
"""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.dynamics.applied_forces import applied_forces
from lcpflex.dynamics.body_forces import elastic_forces, inertial_forces
from lcpflex.dynamics.mass_matrix import mass_matrix
from lcpflex.dynamics.start import violation
from lcpflex.errors import ModelError, ModelWarning, SolverError, in_range, shown
from lcpflex.jit.kernel import FloatArray
from lcpflex.jit.struct import pack
from lcpflex.model.planar import N_RIGID
from lcpflex.scene.planar_only import refuse_space
from lcpflex.scene.scene import Scene

if TYPE_CHECKING:
    from collections.abc import Callable

    import numpy.typing as npt

    from lcpflex.compile.compiled_scene import CompiledScene

__all__ = ["Vibrations", "small_vibrations"]

DIFFERENCE = (
    1e-5  # of a large change of each coordinate: forces are at most quadratic in them, but for the sine of angles
)
ITERATIONS = 30
SETTLED = 1e-9
BALANCED = 1e-11  # of the largest stiffness: a force left over moves the scene away
INDEPENDENT = 1e-10  # of joint rows


@dataclass(frozen=True, slots=True, eq=False)
class Vibrations:
    """Small motions exp(s t) about a steady state.

    Attributes
    ----------
    q : (ndof,) the steady state
    exponents : (2 f,) s, complex, of the f coordinates that the joints leave free, ascending by imaginary part [1/s]
    """

    q: FloatArray
    exponents: npt.NDArray[np.complex128]

    @property
    def frequencies(self) -> FloatArray:
        """Imaginary parts above zero, ascending [rad/s]; what does not oscillate is not among them."""
        return np.asarray(self.exponents.imag[self.exponents.imag > 0.0])

    @property
    def growth(self) -> float:
        """Greatest real part [1/s]: above zero (and rounding) the state is unstable."""
        return float(self.exponents.real.max(initial=-math.inf))


def small_vibrations(scene: Scene, spin: float = 0.0) -> Vibrations:
    """Frequencies and growth of small motions of a scene about its steady state. Contacts are left out.

    Parameters
    ----------
    scene : with joints and loads as they are at t = 0; its start is the first guess of the steady state. With a spin,
        nothing in it may tell one direction of the world from another: no gravity, no ground point but the origin
    spin : of the scene as a whole about the origin of the world [rad/s]; drives must turn at it

    Raises
    ------
    ModelError
        For gravity with a spin, and what ``scene.compile()`` refuses.
    SolverError
        If no steady state was found near the start.
    """
    spin = in_range("spin", spin, -math.inf, math.inf)
    refuse_space("small_vibrations", scene)
    if not isinstance(scene, Scene):
        raise ModelError(f"scene: {shown(scene)} was given, expected a Scene")
    compiled = scene.compiled(project=True)  # what penetrates is refused: it would vibrate about another place
    for warning in compiled.warnings:
        warnings.warn(warning, ModelWarning, stacklevel=2)
    if spin != 0.0 and np.any(compiled.model.loads.gravity):
        raise ModelError("gravity: it was given with a spin, expected none: a scene that turns in it is never steady")
    turning = _Turning(compiled, spin)
    q, reaction = _steady(turning, compiled.q.copy())
    n = len(q)
    still = np.zeros(n)
    J = turning.joints(q)[1]
    free = _null(J, turning.scale)
    K = _stiffness(turning, q, reaction)
    D = _jacobian(lambda v: turning.residual(q, v, reaction), still, turning.scale)
    M, D, K = (free.T @ A @ free for A in (turning.mass(q), D, K))
    zero, one = np.zeros_like(M), np.eye(len(M))
    exponents = np.linalg.eigvals(np.block([[zero, one], [-np.linalg.solve(M, K), -np.linalg.solve(M, D)]]))
    order = np.lexsort((exponents.real, exponents.imag))
    return Vibrations(q, np.asarray(exponents[order], dtype=np.complex128))


class _Turning:
    """The mechanics of a scene as seen from turning axes."""

    def __init__(self, compiled: CompiledScene, spin: float) -> None:
        self._compiled = compiled
        self._model = pack(compiled.model)
        self._spin = spin
        self._frames = compiled.model.bodies.dof[:-1]
        self.scale = _scale(compiled)

    def _external(self, q: FloatArray, u: FloatArray) -> FloatArray:
        external = np.zeros((self._compiled.n_external, 3))
        state = self._compiled.state(0.0, q, u)
        for callback in self._compiled.callbacks:
            callback.fill(0.0, state, external)
        return external

    def joints(self, q: FloatArray) -> tuple[FloatArray, FloatArray]:
        """phi (m,) and J (m, ndof)."""
        u = np.zeros_like(q)
        found = violation(self._compiled.model, q, u, self._external(q, u))
        return found.position, found.jacobian

    def mass(self, q: FloatArray) -> FloatArray:
        """M (ndof, ndof)."""
        return mass_matrix(self._compiled.model, q)

    def residual(self, q: FloatArray, v: FloatArray, reaction: FloatArray) -> FloatArray:
        """r of the module at w = 0 (ndof,)."""
        x, y, spin = self._frames, self._frames + 1, self._spin
        u, udot = v.copy(), np.zeros_like(v)
        u[x] -= spin * q[y]
        u[y] += spin * q[x]
        u[self._frames + 2] += spin
        udot[x] = -(spin**2) * q[x] - 2.0 * spin * v[y]
        udot[y] = -(spin**2) * q[y] + 2.0 * spin * v[x]
        model = self._model
        force = np.zeros_like(q)
        inertial_forces(model.bodies, model.loads, q, u, force)
        elastic_forces(model.bodies, q, u, force, force)
        applied_forces(model, 0.0, q, u, np.zeros(2), self._external(q, u), force, force, force)
        return np.asarray(self.mass(q) @ udot - force - self.joints(q)[1].T @ reaction)


def _steady(turning: _Turning, q: FloatArray) -> tuple[FloatArray, FloatArray]:
    """State and reactions (m,) without any motion as seen from the turning axes, by Newton's method.

    Along the joints and across them apart from each other: stiff modes and constraints differ by many powers of ten.
    """
    for _ in range(ITERATIONS):
        phi, J = turning.joints(q)
        free, scale = _null(J, turning.scale), turning.scale
        reaction = _reaction(turning, q, J)
        rest = turning.residual(q, np.zeros_like(q), reaction)
        K = _stiffness(turning, q, reaction)
        onto = -scale * (np.linalg.pinv(J * scale) @ phi)
        along = np.linalg.lstsq(free.T @ K @ free, -free.T @ (rest + K @ onto), rcond=1e-14)[0]
        change = onto + free @ along
        size = float(np.abs(scale[:, None] * K * scale).max())
        q = q + change
        if np.abs(change / scale).max() <= SETTLED * (1.0 + np.abs(q / scale).max()):
            J = turning.joints(q)[1]
            reaction = _reaction(turning, q, J)
            left = _null(J, scale).T @ turning.residual(q, np.zeros_like(q), reaction)
            if np.abs(left).max(initial=0.0) <= BALANCED * size:
                return q, reaction
            break
    raise SolverError("no steady state was found near the start of the scene, by Newton's method")


def _reaction(turning: _Turning, q: FloatArray, J: FloatArray) -> FloatArray:
    """lambda (m,) that leaves the least residual."""
    unheld = turning.residual(q, np.zeros_like(q), np.zeros(len(J)))
    return np.asarray(np.linalg.pinv((J * turning.scale).T) @ (turning.scale * unheld))


def _stiffness(turning: _Turning, q: FloatArray, reaction: FloatArray) -> FloatArray:
    still = np.zeros_like(q)
    return _jacobian(lambda x: turning.residual(x, still, reaction), q, turning.scale)


def _scale(compiled: CompiledScene) -> FloatArray:
    """(ndof,) what is a large change of each coordinate: the extent of a body, a radian, a mode that moves so far."""
    bodies, points = compiled.model.bodies, compiled.model.points
    scale = np.full(len(compiled.q), compiled.size)
    for b, first in enumerate(bodies.dof[:-1]):
        scale[first + 2] = 1.0
        n = int(bodies.dof[b + 1] - first) - N_RIGID
        own = [points.phi[points.start[p] : points.start[p + 1]] for p in np.flatnonzero(points.body == b)]
        moved = np.abs(own).max(axis=(0, 2)) if own and n else np.zeros(n)
        scale[first + N_RIGID : first + N_RIGID + n] /= np.maximum(moved, np.finfo(float).tiny)
        scale[first + N_RIGID : first + N_RIGID + n][moved == 0.0] = 1.0  # a mode that no point of the scene shows
    return scale


def _jacobian(function: Callable[..., FloatArray], x: FloatArray, scale: FloatArray) -> FloatArray:
    columns: list[Any] = []
    for k in range(len(x)):
        step = np.zeros_like(x)
        step[k] = DIFFERENCE * scale[k]
        columns.append((function(x + step) - function(x - step)) / (2.0 * step[k]))
    return np.column_stack(columns)


def _null(J: FloatArray, scale: FloatArray) -> FloatArray:
    """(ndof, f) basis of the motions that the joints leave free, orthonormal in parts of ``scale``."""
    _, sizes, rows = np.linalg.svd(J * scale)
    rank = int((sizes > INDEPENDENT * sizes.max(initial=0.0)).sum())
    return np.asarray(scale[:, None] * rows[rank:].T)
