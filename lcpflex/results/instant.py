"""One stored instant, as functions of the user are asked about it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from lcpflex.errors import ModelError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lcpflex.bodies.placed_point import PlacedPoint
    from lcpflex.dynamics.spatial.state import SpatialState
    from lcpflex.dynamics.time_functions import OnBody, State
    from lcpflex.jit.kernel import FloatArray
    from lcpflex.results.result import Result

__all__ = ["Instant"]


@dataclass(frozen=True, slots=True, eq=False)
class Instant:
    """State and forces at one instant of a run: nc contacts, nj joints, ndof coordinates, as in :class:`Result`.

    Attributes
    ----------
    time
        [s].
    q, u
        (ndof,) coordinates and their rates [m], [rad], [kg^1/2 m] and by the second.
    contacts
        Names of the nc contacts; of a rule between many surfaces, those that have touched of late.
    force, impulse
        (nc, 2) normal and tangential force of each contact [N], and its impulse since the start [N s]; in space (nc, 4)
        as in :class:`Result`.
    gap
        (nc,) [m], NaN where far.
    state
        (nc,) OPEN, STICK, SLIP or CREEP.
    joint_force
        (nj, 3) F_x, F_y [N] and M [N m] of each joint, in space (nj, 6), three of each;
        world axes, as in ``Result.reaction``.
    """

    time: float
    q: FloatArray
    u: FloatArray
    contacts: tuple[str, ...]
    force: FloatArray
    impulse: FloatArray
    gap: FloatArray
    state: NDArray[np.int8]
    joint_force: FloatArray
    _state: State | SpatialState | None = field(repr=False)

    @classmethod
    def of(cls, result: Result, k: int) -> Instant:
        """Stored instant k of a result; its arrays are copies."""
        q, u, t = result.q[k].copy(), result.u[k].copy(), float(result.times[k])
        joints = np.zeros((0, 3)) if result.joint_force is None else result.joint_force[k].copy()
        own = None if result.compiled is None else result.compiled.state(t, q, u)
        arrays = (result.force[k].copy(), result.impulse[k].copy(), result.gap[k].copy(), result.state[k].copy())
        return cls(t, q, u, result.contact_names, *arrays, joints, own)

    def position(self, point: PlacedPoint) -> FloatArray:
        """r_P (2,), in space (3,) [m], world axes.

        point: of the scene. Raises ModelError for a system of the user's own.
        """
        return self._known.position(point)

    def velocity(self, point: PlacedPoint) -> FloatArray:
        """rdot_P (2,), in space (3,) [m/s], world axes.

        point: of the scene. Raises ModelError for a system of the user's own.
        """
        return self._known.velocity(point)

    def angle(self, of: OnBody) -> float:
        """Angle [rad] of a body, or of the material at a point of one.

        of: a body or a point of the scene. Raises ModelError for a system of the user's own, and in space, where there
        is ``rotation``.
        """
        known = self._known
        if not hasattr(known, "angle"):
            raise ModelError("angle: bodies in space have no one angle; expected rotation(of)")
        return float(known.angle(of))

    def rotation(self, of: OnBody) -> FloatArray:
        """(3, 3) axes of a body of a spatial scene, or of the material at a point of one, as columns; world axes.

        of: a body or a point of the scene. Raises ModelError in the plane, where there is ``angle``.
        """
        known = self._known
        if not hasattr(known, "rotation"):
            raise ModelError("rotation: bodies of a planar scene have one angle; expected angle(of)")
        return np.asarray(known.rotation(of))

    def angular_velocity(self, of: OnBody) -> float | FloatArray:
        """Angular velocity [rad/s] of a body, or of the material at a point of one; in space (3,), world axes.

        of: a body or a point of the scene. Raises ModelError for a system of the user's own.
        """
        return self._known.angular_velocity(of)

    @property
    def _known(self) -> State | SpatialState:
        if self._state is None:
            raise ModelError("a system of the user's own has no points and bodies; expected q and u to be asked")
        return self._state
