"""The convex relaxation of Coulomb friction in space as a problem: K ∋ r _|_ G r + free ∈ K*. It is another model."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from lcpflex.basics.arguments import flag, point_of
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray
from lcpflex.solvers.certificate import guarded_residual, strict_residual
from lcpflex.solvers.contact.cones.conic import ConicProgram, relaxed_miss
from lcpflex.solvers.contact.spatial import SpatialContactProblem

__all__ = ["RelaxedSpatialProblem", "relaxed_solution"]

PRESSED = 1e-8  # r_N, relative to the largest, beyond which a contact counts as pressed


@dataclass(frozen=True, slots=True)
class RelaxedSpatialProblem:
    """The relaxed law K ∋ r _|_ G r + free ∈ K* for the contacts of a :class:`SpatialContactProblem`.

    Unknowns are the forces (3 k,). Raises ModelError if ``contact`` is something else.
    """

    contact: SpatialContactProblem

    def __post_init__(self) -> None:
        if not isinstance(self.contact, SpatialContactProblem):
            raise ModelError(f"contact is a {type(self.contact).__name__}: expected a SpatialContactProblem")

    @property
    def size(self) -> int:
        """Number 3 k of force components."""
        return self.contact.size

    @property
    def unknown_keys(self) -> tuple[Hashable, ...]:
        """Those of the contacts."""
        return self.contact.unknown_keys

    def slack(self, z: npt.ArrayLike) -> FloatArray:
        """The velocities (3 k,) under the forces z (3 k,)."""
        return self.contact.slack(z)

    def residual(self, z: npt.ArrayLike, scaled: bool = True) -> float:
        """The largest component of r' - P_K(r' - u') in units of each contact; relative to its terms if ``scaled``.

        z (3 k,): the forces; inf where they hold NaN or inf. Raises ModelError if z has another shape.
        """
        return self.residuals(z)[0] if flag("scaled", scaled) else self._parts(z)[0]

    def residuals(self, z: npt.ArrayLike) -> tuple[float, float]:
        """The residual of z (3 k,) relative to the terms of the velocities, and to the free velocity alone."""
        worst, size, load = self._parts(z)
        return float(guarded_residual(worst, size, load)), float(strict_residual(worst, load))

    def lift(self, z: npt.ArrayLike) -> float:
        """Largest u_N of the contacts that forces z (3 k,) press: 0 if Coulomb's law holds too; in units of free."""
        pressed = self.contact.forces(z)[:, 0]
        chosen = pressed > PRESSED * np.abs(pressed).max(initial=0.0)
        return float(self.slack(z)[::3][chosen].max(initial=0.0))

    def _parts(self, z: npt.ArrayLike) -> tuple[float, float, float]:
        """What is left, the size of its terms, and that of the free velocities, in units of the contacts."""
        contact, point = self.contact, point_of("z", z, self.size)
        _, size, load = contact.residual_parts(point)
        d = contact.unknown_units.d
        with np.errstate(all="ignore"):
            r, u = point / d, contact.slack(point) * d
        if not (size < np.inf and np.isfinite(r).all() and np.isfinite(u).all()):
            return np.inf, np.inf, np.inf
        miss, slope = np.empty(self.size), np.empty((self.size, 3))
        worst = float(relaxed_miss(r, u, contact._data[2], len(contact.friction), miss, slope))
        return (worst, size, load) if worst < np.inf else (np.inf, np.inf, np.inf)


def relaxed_solution(contact: SpatialContactProblem) -> tuple[FloatArray, int, str]:
    """Forces (3 k,) of the relaxed law as Clarabel and Newton steps find them, the iterations, and what it says."""
    units = contact.unknown_units
    program = ConicProgram.of(contact.balanced())
    load = np.array(program.problem.free)
    forces, iterations, said = program.solve(load)
    if np.isfinite(forces).all():
        forces, _ = program.polished(load, forces)
    return units.outward(forces), iterations, said
