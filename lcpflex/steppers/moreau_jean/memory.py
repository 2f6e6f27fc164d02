"""What a Moreau-Jean step is made with."""

from __future__ import annotations

from lcpflex.jit.kernel import FloatArray
from lcpflex.jit.struct import struct
from lcpflex.steppers.strike_order import StrikeOrder

__all__ = ["MoreauJeanScheme"]


@struct
class MoreauJeanScheme:
    """Numbers of the scheme, and its state."""

    step: float
    theta: float
    activation: float
    gap_tolerance: float
    projection: int
    tolerance: float
    velocity_threshold: float
    gyroscopic: int  # passes of the correction in space, at most
    unsettled: int  # steps in which they did not suffice
    q: FloatArray
    u: FloatArray
    order: StrikeOrder
