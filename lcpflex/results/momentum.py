"""Linear and angular momentum of bodies, and where their mass centre is, over the stored instants.

    p = sum m v_C          L = sum <r x rdot>  about the origin of the world          r_C = sum <r> / sum m

In free motion p changes by weight and L by its moment alone: what else changes them are joints, loads and contacts.
Bodies that collide keep their common p to rounding; in space their common L to the order of the step, 1 of time
stepping, and to rounding by the massless boundary when the contact is open again.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.basics.arguments import absent
from lcpflex.errors import ModelError
from lcpflex.kinematics.places import turned
from lcpflex.model.planar import N_RIGID

if TYPE_CHECKING:
    from lcpflex.compile.compiled_scene import CompiledScene
    from lcpflex.jit.kernel import FloatArray
    from lcpflex.results.result import Result

__all__ = ["Momentum", "momentum_of"]


@dataclass(frozen=True, slots=True, eq=False)
class Momentum:
    """Momentum of one body, or of all, over m stored instants; world axes.

    Attributes
    ----------
    linear
        (m, 2) p [kg m/s]; (m, 3) in space.
    angular
        (m,) L about the origin of the world, counter-clockwise [kg m^2/s]; (m, 3) in space.
    centre
        (m, 2) place of the mass centre [m]; (m, 3) in space.
    mass
        [kg].
    """

    linear: FloatArray
    angular: FloatArray
    centre: FloatArray
    mass: float

    @property
    def about_centre(self) -> FloatArray:
        """L - r_C x p, the angular momentum about the moving mass centre, as ``angular`` [kg m^2/s]."""
        return np.asarray(self.angular - _cross(self.centre, self.linear))


def momentum_of(result: Result, body: str | None) -> Momentum:
    """Of one body, or of all of them. Raises ModelError where there is none of that name."""
    compiled = result.compiled
    if compiled is None:
        raise ModelError("momentum: a system of the user's own has no bodies; expected the result of a Scene")
    names = compiled.layout.bodies
    if body is not None and (not isinstance(body, str) or body not in names):
        raise ModelError(f"body: no body {absent(body, names)}")
    chosen = range(len(names)) if body is None else [names.index(body)]
    linear, angular, centre = (_in_space if compiled.spatial else _in_the_plane)(result, compiled)
    mass = compiled.model.bodies.mass[list(chosen)]
    parts = [part[:, list(chosen)] for part in (linear, angular, centre)]
    middle = np.einsum("b,mbi->mi", mass, parts[2]) / mass.sum()
    return Momentum(parts[0].sum(axis=1), parts[1].sum(axis=1), middle, float(mass.sum()))


def _in_space(result: Result, compiled: CompiledScene) -> tuple[FloatArray, FloatArray, FloatArray]:
    """p, L and r_C (m, nb, 3) of each body."""
    from lcpflex.dynamics.inertia import factors
    from lcpflex.dynamics.spatial.body_forces import momenta
    from lcpflex.jit.struct import pack

    bodies = pack(compiled.model.bodies)
    work: Any = factors(bodies)
    found = np.zeros((len(result.times), len(compiled.layout.bodies), 9))
    for row, q, u in zip(found, result.q, result.u, strict=True):
        momenta(bodies, q.copy(), u.copy(), work, row)
    return found[..., :3], found[..., 3:6], found[..., 6:]


def _in_the_plane(result: Result, compiled: CompiledScene) -> tuple[FloatArray, FloatArray, FloatArray]:
    """p (m, nb, 2), L (m, nb) and r_C (m, nb, 2) of each body: the rigid rows of M u."""
    from lcpflex.dynamics.mass_matrix import body_mass_matrix

    bodies, q, u = compiled.model.bodies, result.q, result.u
    m, nb = len(result.times), len(compiled.layout.bodies)
    linear, angular, centre = np.zeros((m, nb, 2)), np.zeros((m, nb)), np.zeros((m, nb, 2))
    for b in range(nb):
        own = slice(int(bodies.dof[b]), int(bodies.dof[b + 1]))
        modes = slice(own.start - N_RIGID * b, own.stop - N_RIGID * (b + 1))
        moved = np.array(
            [body_mass_matrix(bodies, b, x)[:N_RIGID] @ v for x, v in zip(q[:, own], u[:, own], strict=True)]
        )
        moved = moved.reshape(m, N_RIGID)
        place, angle = q[:, own.start : own.start + 2], q[:, own.start + 2]
        arm = bodies.moment[b] + q[:, own.start + N_RIGID : own.stop] @ bodies.S[modes]
        linear[:, b] = moved[:, :2]
        angular[:, b] = moved[:, 2] + _cross(place, moved[:, :2])
        centre[:, b] = place + turned(angle, arm) / bodies.mass[b]
    return linear, angular, centre


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """a x b of vectors (..., 3), or its one component of vectors (..., 2)."""
    if a.shape[-1] == 3:
        return np.cross(a, b)
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])
