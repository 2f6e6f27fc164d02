"""What reductions of beams, bars and meshes share: modal damping, numbers of modes, signs and checks of integrals."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from lcpflex.basics.arguments import numbers
from lcpflex.basics.options import keep_number
from lcpflex.bodies.body import Displacement, array_of, whole_number
from lcpflex.errors import ModelError, in_range, shown
from lcpflex.jit.kernel import FloatArray

__all__ = [
    "Damping",
    "Rayleigh",
    "check_damping",
    "continued",
    "count_of_modes",
    "damped_modes",
    "modal_damping",
    "sampled",
    "signed",
    "skew",
    "vanish",
    "with_residual",
]

ORTHOGONAL = 1e-9  # largest <Phi> and <Phi^T J x>, relative to the mass and inertia they belong to


@dataclass(frozen=True, slots=True)
class Rayleigh:
    """Damping C = alpha M + beta K of the deformation: 2 zeta_k omega_k = alpha + beta omega_k^2.

    Parameters
    ----------
    alpha : >= 0 [1/s]
    beta : >= 0 [s]
    """

    alpha: float
    beta: float

    def __post_init__(self) -> None:
        keep_number(self, "alpha", 0.0, math.inf)
        keep_number(self, "beta", 0.0, math.inf)


Damping: TypeAlias = float | Sequence[float] | npt.NDArray[np.float64] | Rayleigh


def modal_damping(damping: Damping, omega: FloatArray) -> FloatArray:
    """(n,) 2 zeta_k omega_k [1/s] of modes with the angular frequencies omega (n,).

    ``damping`` is one damping ratio zeta for all modes, one for each, or :class:`Rayleigh`.

    Raises
    ------
    ModelError
        For a negative or non-finite ratio, or a wrong number of them.
    """
    if isinstance(damping, Rayleigh):
        return np.asarray(damping.alpha + damping.beta * omega**2)
    if is_one(damping):
        return 2.0 * in_range("damping", damping, 0.0, math.inf) * omega
    ratios = array_of("damping", damping, (len(omega),))
    if len(ratios) and ratios.min() < 0.0:
        raise ModelError(f"damping: a ratio of {ratios.min()!r} was given, expected ratios >= 0")
    return 2.0 * ratios * omega


def is_one(damping: object) -> bool:
    """Whether it is not several numbers: one, or nothing that could be a damping."""
    given = numbers(damping)
    return given is None or given.ndim == 0


def check_damping(damping: Damping, modes: int) -> None:
    """Refuse a damping that does not fit, before the eigenproblem is solved."""
    modal_damping(damping, np.ones(modes))


def damped_modes(modes: int | None, available: int, damping: Damping | None, residual_damping: float | None) -> int:
    """The number of modes to keep, with dampings that fit, or ModelError, before the eigenproblem is solved."""
    n = count_of_modes(modes, available)
    if damping is not None:
        check_damping(damping, n)
    if residual_damping is not None:
        in_range("residual_damping", residual_damping, 0.0, math.inf)
    return n


def continued(damping: Any, modes: int) -> Any:
    """The damping of so many modes: of several ratios the last one goes on, as for residual modes."""
    if damping is None or isinstance(damping, Rayleigh) or is_one(damping):
        return damping
    ratios = np.asarray(damping, dtype=np.float64)[:modes]
    return np.concatenate([ratios, np.full(modes - len(ratios), ratios[-1] if len(ratios) else 0.0)])


def with_residual(damping: Damping, residual_damping: float | None, omega: FloatArray, free: int) -> FloatArray:
    """(n,) 2 zeta_k omega_k [1/s] of ``free`` free modes and the residual ones behind them, omega (n,) [rad/s].

    ``damping`` is that of :func:`modal_damping` for the free modes; residual ones have the damping ratio
    ``residual_damping``, or, where it is None, that of the others: the last one of several.

    Raises
    ------
    ModelError
        For negative or non-finite ratios, or a wrong number of them.
    """
    rest = omega[free:]
    if residual_damping is not None:
        ratio = in_range("residual_damping", residual_damping, 0.0, math.inf)
        return np.concatenate([modal_damping(damping, omega[:free]), 2.0 * ratio * rest])
    if isinstance(damping, Rayleigh) or is_one(damping):
        return modal_damping(damping, omega)
    own = modal_damping(damping, omega[:free])
    last = float(np.asarray(damping, dtype=np.float64)[-1]) if free else 0.0
    return np.concatenate([own, 2.0 * last * rest])


def sampled(displacement: Displacement, places: FloatArray) -> FloatArray:
    """Values of a displacement field: (k, 2) of a function at the places (k, 2), or the given (nodes, 2) array.

    Raises
    ------
    ModelError
        If the function raises or gives anything but two finite numbers, or the array has another shape.
    """
    if not callable(displacement):
        return array_of("displacement", displacement, (-1, 2))
    values = np.empty((len(places), 2))
    for k, (x, y) in enumerate(places):
        try:
            value = displacement(float(x), float(y))
        except Exception as error:
            raise ModelError(f"displacement: the function raised {shown(error)} at ({x:g}, {y:g})") from error
        values[k] = array_of(f"displacement at ({x:g}, {y:g})", value, (2,))
    return values


def count_of_modes(modes: int | None, available: int, which: str = "elastic modes") -> int:
    """The number of modes to keep, ``None`` for all; raises :class:`ModelError` if the mesh has fewer of them."""
    if modes is None:
        return available
    return whole_number("modes", modes, 0, available, f" (the mesh has {available} {which})")


def signed(shapes: FloatArray, translations: npt.NDArray[np.bool_] | None = None) -> FloatArray:
    """Fix the sign of each column: the first displacement above half of the largest is positive."""
    looked_at = np.abs(shapes if translations is None else shapes[translations])
    first = (looked_at > 0.5 * looked_at.max(axis=0, initial=0.0)).argmax(axis=0) if shapes.size else []
    rows = np.arange(len(shapes)) if translations is None else np.flatnonzero(translations)
    leading = shapes[rows[first], np.arange(shapes.shape[1])] if shapes.size else np.zeros(0)
    return np.asarray(shapes * np.where(leading < 0.0, -1.0, 1.0))


def skew(coupling: FloatArray) -> FloatArray | None:
    """The skew part of D, or None where D vanishes to rounding (|D_kl| <= 1 in an orthonormal basis)."""
    if not coupling.size or np.abs(coupling).max() <= 1e-10:
        return None
    return np.asarray(0.5 * (coupling - coupling.T))


def vanish(name: str, integrals: FloatArray, scale: float) -> FloatArray:
    """Zeros in the place of integrals that vanish to rounding; raises :class:`ModelError` if they do not."""
    worst = float(np.abs(integrals).max(initial=0.0))
    if not worst <= ORTHOGONAL * scale:
        raise ModelError(
            f"{name}: {worst / scale:.3g} of its scale, expected 0 to rounding: the modes found are not orthogonal to "
            f"the rigid motions (fewer modes, or a stiffness and mass with fewer orders of magnitude, may help)"
        )
    return np.zeros_like(integrals)
