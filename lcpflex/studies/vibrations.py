"""Small vibrations of a scene about the state in which it rests, or turns as a whole, in the plane and in space.

Seen from axes that turn at Omega about the origin of the world, a scene that turns with them rests. With the residual

    r(q, v, w, lambda) = M(q) udot - h(q, u) - J^T lambda,   phi(q) = 0

where u and udot belong to the motion that has the velocity v and the acceleration w as seen from the turning axes, the
state (q, lambda) is the one with r(q, 0, 0, lambda) = 0, and small motions d q = Z y about it, J Z = 0, follow

    Z^T (M w + (dr/dv) v + (dr/dq) d q) = 0

Derivatives are central differences of r. In space d q are displacements in the coordinates of velocities, and bodies
may spin about their own axes, in carriers that rest (:mod:`lcpflex.studies.turning_axes`).
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.basics import libs
from lcpflex.basics.arguments import array_of, mapping_of, whole_number
from lcpflex.errors import ModelError, ModelWarning, SolverError, in_range, shown
from lcpflex.jit.kernel import FloatArray
from lcpflex.scene.register import Register
from lcpflex.studies.exponents import all_exponents, local_rate, loose, lowest_exponents, nearest, saddle
from lcpflex.studies.turning_axes import TurningAxes

if TYPE_CHECKING:
    import numpy.typing as npt

    from lcpflex.compile.compiled_scene import CompiledScene
    from lcpflex.scene.scene import Scene
    from lcpflex.scene.spatial.scene import SpatialScene

__all__ = ["Vibrations", "small_vibrations"]

ITERATIONS = 30
SETTLED = 1e-9
BALANCED = 1e-11  # of the largest stiffness: a force left over moves the scene away
LARGE = 400  # coordinates from which on matrices are sparse: all exponents of as many take a second
COUNT = 40  # pairs of exponents of a large scene
HELD_BY_INERTIA = 1e-6  # of the local stiffness, in steps to the steady state of a large scene that may float


@dataclass(frozen=True, slots=True, eq=False)
class Vibrations:
    """Small motions exp(s t) about a steady state.

    Attributes
    ----------
    q : (nq,) the steady state, as many as ndof in the plane
    exponents : (2 f,) s, complex, of the f coordinates that the joints leave free, ascending by imaginary part [1/s];
        of those nearest to 0 alone where not all were looked for
    complete : whether these are all
    """

    q: FloatArray
    exponents: npt.NDArray[np.complex128]
    complete: bool = True

    @property
    def frequencies(self) -> FloatArray:
        """Imaginary parts above zero, ascending [rad/s]; what does not oscillate is not among them."""
        return np.asarray(self.exponents.imag[self.exponents.imag > 0.0])

    @property
    def growth(self) -> float:
        """Greatest real part [1/s]: above zero (and rounding) the state is unstable.

        Of the exponents that were looked for: where these are not all, a faster motion may grow all the same.
        """
        return float(self.exponents.real.max(initial=-math.inf))


def small_vibrations(
    scene: Scene | SpatialScene,
    spin: npt.ArrayLike = 0.0,
    rotors: Mapping[str, Any] | None = None,
    count: int | None = None,
) -> Vibrations:
    """Frequencies and growth of small motions of a scene about its steady state. Contacts are left out.

    Parameters
    ----------
    scene : with joints and loads as they are at t = 0; its start is the first guess of the steady state. With a spin,
        nothing in it may tell one direction about the axis from another: no gravity but along the axis, no ground
        point off it
    spin : of the scene as a whole about the origin of the world [rad/s], in space (3,), world axes, or 0; drives must
        turn at it. Frequencies are those that are seen from axes that turn with it
    rotors : in space, constant spins (3,) of bodies by name, in their own axes, beside that of the whole [rad/s]:
        wheels in their bearings, tops. They must be the same all round. Speeds of the start are not read
    count : how many pairs of exponents, those nearest to 0; None for all, of scenes of more than 400 coordinates for
        40 pairs. Matrices of these are sparse

    Raises
    ------
    ModelError
        For gravity with a spin that is not along it, spins that joints do not let turn, rotors that are not the same
        all round, and what ``scene.compile()`` refuses.
    SolverError
        If no steady state was found near the start, or not the exponents of a large scene.
    """
    if not isinstance(scene, Register):
        raise ModelError(f"scene: {shown(scene)} was given, expected a Scene or a SpatialScene")
    turning = _spin(spin, scene.spatial)
    spins = mapping_of("rotors", {} if rotors is None else rotors)
    if spins and not scene.spatial:
        raise ModelError("rotors: they were given for a planar scene, expected none: there spin has no effect")
    if count is not None:
        count = whole_number("count", count, 1, 1_000_000)
    compiled: CompiledScene = scene.compiled(project=True)
    for warning in compiled.warnings:  # what penetrates is refused: it would vibrate about another place
        warnings.warn(warning, ModelWarning, stacklevel=2)
    _check_gravity(compiled, turning)
    axes = TurningAxes(compiled, turning, spins)
    large = len(compiled.u) > LARGE
    q, reaction = (_steady_of_many if large else _steady)(axes, compiled.q.copy())
    if not axes.at_rest:
        axes.check_rotors(q)
    M, D, K = axes.mass(q), axes.damping(q, reaction), axes.stiffness(q, reaction)
    J = axes.jacobian(axes.joints(q))
    pairs = COUNT if count is None and large else count
    if large:
        assert pairs is not None
        exponents, complete = lowest_exponents(M, D, K, J, axes.scale, pairs), False
    else:
        exponents = all_exponents(M, D, K, loose(J.toarray(), axes.scale))
        complete = pairs is None or 2 * pairs >= len(exponents)
        if not complete:
            exponents = exponents[nearest(exponents, pairs or 0)]
    order = np.lexsort((exponents.real, exponents.imag))
    return Vibrations(q, np.asarray(exponents[order], dtype=np.complex128), complete)


def _spin(given: npt.ArrayLike, spatial: bool) -> FloatArray:
    """(1,), in space (3,)."""
    if not spatial:
        return np.array([in_range("spin", given, -math.inf, math.inf)])
    if np.ndim(given) == 0 and given == 0.0:
        return np.zeros(3)
    return array_of("spin", given, (3,))


def _check_gravity(compiled: CompiledScene, spin: FloatArray) -> None:
    gravity = np.asarray(compiled.model.loads.gravity)
    if not (spin.any() and gravity.any()):
        return
    if len(spin) == 1 or np.linalg.norm(np.cross(gravity, spin)) > SETTLED * np.linalg.norm(gravity) * np.linalg.norm(
        spin
    ):
        expected = "none" if len(spin) == 1 else "none, or gravity along the axis"
        raise ModelError(
            f"gravity: it was given with a spin, expected {expected}: a scene that turns in it is never steady"
        )


def _steady(axes: TurningAxes, q: FloatArray) -> tuple[FloatArray, FloatArray]:
    """State and reactions (m,) without any motion as seen from the turning axes, by Newton's method.

    Along the joints and across them apart from each other: stiff modes and constraints differ by many powers of ten.
    """
    scale, still = axes.scale, np.zeros(len(axes.scale))
    for _ in range(ITERATIONS):
        found = axes.joints(q)
        J = found.jacobian
        free = loose(J, scale)
        reaction = _reaction(axes, q, J)
        rest = axes.residual(q, still, reaction)
        K = axes.stiffness(q, reaction).toarray()
        onto = -scale * (np.linalg.pinv(J * scale) @ found.position)
        along = np.linalg.lstsq(free.T @ K @ free, -free.T @ (rest + K @ onto), rcond=1e-14)[0]
        change = onto + free @ along
        size = float(np.abs(scale[:, None] * K * scale).max())
        q = axes.moved(q, change)
        if axes.is_small(q, change, SETTLED):
            J = axes.joints(q).jacobian
            reaction = _reaction(axes, q, J)
            left = loose(J, scale).T @ axes.residual(q, still, reaction)
            if np.abs(left).max(initial=0.0) <= BALANCED * size:
                return q, reaction
            break
    raise SolverError("no steady state was found near the start of the scene, by Newton's method")


def _reaction(axes: TurningAxes, q: FloatArray, J: FloatArray) -> FloatArray:
    """lambda (m,) that leaves the least residual."""
    unheld = axes.residual(q, np.zeros(len(axes.scale)), np.zeros(len(J)))
    return np.asarray(np.linalg.pinv((J * axes.scale).T) @ (axes.scale * unheld))


def _steady_of_many(axes: TurningAxes, q: FloatArray) -> tuple[FloatArray, FloatArray]:
    """As :func:`_steady` by sparse factors of coordinates and reactions together.

    A part of the inertia is added to the stiffness, so that what floats has a factor and stays where it is.
    """
    scale, still = axes.scale, np.zeros(len(axes.scale))
    across = libs.sparse.diags(scale)
    metric = libs.sparse.diags(1.0 / scale**2).tocsr()
    for _ in range(ITERATIONS):
        found = axes.joints(q)
        J = axes.jacobian(found)
        none = np.zeros(J.shape[0])
        unheld = axes.residual(q, still, none)
        reaction = saddle(metric, J, scale)(unheld, none)[1]
        rest = axes.residual(q, still, reaction)
        K, M = axes.stiffness(q, reaction), axes.mass(q)
        held = K + HELD_BY_INERTIA * local_rate(M, K) ** 2 * M
        change = saddle(held, J, scale)(-rest, -found.position)[0]
        size = float(abs(across @ K @ across).max())
        q = axes.moved(q, change)
        if axes.is_small(q, change, SETTLED):
            J = axes.jacobian(axes.joints(q))
            unheld = axes.residual(q, still, none)
            reaction = saddle(metric, J, scale)(unheld, none)[1]
            left = scale * axes.residual(q, still, reaction)
            if np.abs(left).max(initial=0.0) <= BALANCED * size:
                return q, reaction
            break
    raise SolverError("no steady state was found near the start of the scene, by Newton's method")
