"""Settings of the massless-boundary scheme, and what it hands on from step to step, as its kernels take them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from lcpflex.dynamics.contact_compliance import ContactCompliance
from lcpflex.jit.kernel import FloatArray
from lcpflex.jit.struct import allocate, array, struct

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


@struct
class Boundary:
    """What goes from step to step besides the state."""

    flexibility: FloatArray  # (ndof,) 1/omega^2 of static coordinates, else 0 [s^2]
    acceleration: FloatArray = array("ndof")
    rate: FloatArray = array("ndof")  # of change of the static coordinates, of which contacts are linearised
    guess: FloatArray = array("ndof")  # velocity at which forces are evaluated
    unit: FloatArray  # (2,) of force [N] and of compliance [m/N], of the present problem
    power: FloatArray = array(2)  # of dissipative forces, and of loads and drives [W]
    force: FloatArray = array("laws", 2)  # contact forces [N]
    n_split: int  # steps that were divided
    finest: float  # most parts of one
    n_closed: int  # contacts
    compliance: ContactCompliance  # elastic laws of contacts


def boundary_of(flexibility: FloatArray, compliance: ContactCompliance) -> Boundary:
    """At the start: everything at rest, no contact closed."""
    return allocate(
        Boundary,
        {"ndof": len(flexibility), "laws": len(compliance.soft)},
        flexibility=np.array(flexibility),
        unit=np.ones(2),
        compliance=compliance,
    )
