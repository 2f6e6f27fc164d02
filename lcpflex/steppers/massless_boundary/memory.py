"""Numbers, state and memory of the massless-boundary scheme, as its kernels take them."""

from __future__ import annotations

from lcpflex.dynamics.contact_compliance import ContactCompliance
from lcpflex.dynamics.stable_step import HeldRows
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.jit.struct import array, struct

__all__ = ["BoundaryScheme"]


@struct
class BoundaryScheme:
    """Numbers of the scheme, its state, and what goes from step to step."""

    step: float
    safety: float
    least_parts: float  # into which every step is divided, and at the most
    most_parts: float
    gap_tolerance: float
    least: float  # compliance up to which a contact has none [m/N]
    tolerance: float
    spring: float
    damper: float
    q: FloatArray
    u: FloatArray
    flexibility: FloatArray  # (ndof,) 1/omega^2 of static coordinates, else 0 [s^2]
    held_flexibility: FloatArray  # (ndof,) the same of modes with mass that joints and springs hold, or (0,): of none
    load: FloatArray = array("nq")  # static coordinates that forces and torques of the scene make
    load_before: FloatArray = array("nq")  # those of the step before
    loaded: int  # 1: there may be some
    foreseen: FloatArray = array("foreseen")  # configuration about which contacts were looked for, in space
    reach: float  # how far its static coordinates may be from the solution [m]
    turn_start: IntArray  # (bodies + 1,) offsets into turn; equal where the coordinates of a body are its own
    turn: FloatArray  # flat matrices T, row-major, of frame (3, in space 6) and modes (lcpflex.dynamics.held_modes)
    acceleration: FloatArray = array("ndof")
    rate: FloatArray = array("ndof")  # of change of the static coordinates, of which contacts are linearised
    guess: FloatArray = array("ndof")  # velocity at which forces are evaluated
    joined: FloatArray = array("ndof")  # change of the velocity by which joints are fulfilled at the end of the step
    momentum: FloatArray = array("carried", 6)  # of each body in space, linear and angular, about the world's origin
    wrench: FloatArray = array("carried", 6)  # what changes it: all but inertial forces
    unit: FloatArray  # (2,) of force [N] and of compliance [m/N], of the present problem
    power: FloatArray = array(2)  # of dissipative forces, and of loads and drives [W]
    force: FloatArray = array("laws", "sums")  # contact forces [N]
    parts: float  # of the present step
    closed_then: int  # contacts closed when a step was divided
    n_split: int  # steps that were divided
    finest: float  # most parts of one
    n_closed: int  # contacts
    compliance: ContactCompliance  # elastic laws of contacts
    held: HeldRows
