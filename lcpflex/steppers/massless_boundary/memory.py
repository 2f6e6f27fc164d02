"""Settings of the massless-boundary scheme, and what it hands on from step to step, as its kernels take them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from lcpflex.dynamics.contact_compliance import ContactCompliance
from lcpflex.jit.kernel import FloatArray
from lcpflex.jit.struct import pack

__all__ = ["Boundary", "Settings", "boundary_of"]


class Settings(NamedTuple):
    """Numbers of the scheme, as the compiled loop takes them."""

    step: float
    safety: float
    parts: float  # into which every step is divided, and at the most
    most_parts: float
    gap_tolerance: float
    tolerance: float
    spring: float
    damper: float


class Boundary(NamedTuple):
    """What goes from step to step besides the state."""

    flexibility: FloatArray  # (ndof,) 1/omega^2 of static coordinates, else 0 [s^2]
    acceleration: FloatArray  # (ndof,)
    rate: FloatArray  # (ndof,) of change of the static coordinates, of which contacts are linearised about a guess
    guess: FloatArray  # (ndof,) velocity at which forces are evaluated
    unit: FloatArray  # (2,) of force [N] and of compliance [m/N], of the present problem
    power: FloatArray  # (2,) of dissipative forces, and of loads and drives [W]
    force: FloatArray  # (laws, 2) contact forces [N]
    tally: FloatArray  # (3,) steps that were divided, most parts of one, contacts closed
    compliance: ContactCompliance  # elastic laws of contacts


def boundary_of(flexibility: FloatArray, compliance: ContactCompliance) -> Boundary:
    """At the start: everything at rest, no contact closed."""
    n = len(flexibility)
    return pack(
        Boundary(
            flexibility=np.array(flexibility),
            acceleration=np.zeros(n),
            rate=np.zeros(n),
            guess=np.zeros(n),
            unit=np.ones(2),
            power=np.zeros(2),
            force=np.zeros((len(compliance.soft), 2)),
            tally=np.zeros(3),
            compliance=compliance,
        )
    )
