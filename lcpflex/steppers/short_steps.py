"""How long a Runge-Kutta step may be, and where it ends, for contacts that error control does not see."""

from __future__ import annotations

import math

from lcpflex.dynamics.compliant_contacts import CompliantContacts
from lcpflex.dynamics.contact_forces_history import has_begun
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.jit.leaf import in_space
from lcpflex.kinematics.configuration import normalise
from lcpflex.model.arrays import Model
from lcpflex.steppers.runge_kutta import interpolate

__all__ = ["ALL_OF_IT", "HALVINGS", "onset_share", "travel_time"]

TURN = 0.25  # [rad]
HALVINGS = 45  # of a step, to find where a contact begins
ALL_OF_IT = 1.0 - 1e-6  # share of a step beyond which it is not repeated to end where a contact begins


@in_space("lcpflex.steppers.spatial.speeds")
@kernel
def travel_time(model: Model, y: FloatArray, slope: FloatArray) -> float:
    """Time [s] in which no body turns by more than TURN nor travels farther than the extent of the smallest surface.

    Error control does not see that contacts would be passed over: free flight is exact at any step.
    """
    size = math.inf
    for extent in model.contacts.surface_extent:
        if extent > 0.0:
            size = min(size, extent)
    longest = math.inf
    ndof = model.bodies.dof[len(model.bodies.dof) - 1]
    for b in range(len(model.bodies.mass)):
        d = ndof + model.bodies.dof[b]
        spin = abs(y[d + 2]) + math.sqrt(TURN * abs(slope[d + 2]))
        if spin > 0.0:
            longest = min(longest, TURN / spin)
        if size < math.inf:
            speed = math.hypot(y[d], y[d + 1]) + math.sqrt(size * math.hypot(slope[d], slope[d + 1]))
            if speed > 0.0:
                longest = min(longest, size / speed)
    return longest


@kernel
def onset_share(
    model: Model, nq: int, y: FloatArray, slopes: FloatArray, h: float, at: FloatArray, contacts: CompliantContacts
) -> float:
    """Share of the step h [s] from y at which the first compliant contact with a history begins, or turns back.

    For a step at whose end one has. ``nq``: numbers of a configuration, the first of y; ``at``: scratch for states on
    the dense output.
    """
    base = nq + model.bodies.dof[len(model.bodies.dof) - 1]
    low = 0.0
    high = 1.0
    for _ in range(HALVINGS):
        share = 0.5 * (low + high)
        interpolate(y, slopes, h, share, at)
        normalise(model, at[:nq])
        if has_begun(model, at[:nq], at[nq:base], contacts):
            high = share
        else:
            low = share
    return high
