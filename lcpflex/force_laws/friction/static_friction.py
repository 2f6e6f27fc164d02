"""The static coefficient of friction laws that have one, and what their public face is given."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from lcpflex.errors import ModelError, shown
from lcpflex.force_laws.arguments import finite_numbers
from lcpflex.jit.kernel import FloatArray

LARGEST = 10**8  # forces at a time

__all__ = ["check_static_friction", "common_shape", "slip_of"]


def slip_of(slip: Any, normal: Any, mu: Any) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Slip velocities, normal forces >= 0 and coefficients of friction >= 0 as arrays."""
    return finite_numbers("slip", slip, -math.inf), finite_numbers("normal", normal, 0.0), finite_numbers("mu", mu, 0.0)


def common_shape(given: Sequence[FloatArray]) -> tuple[int, ...]:
    """The shape that slip, normal force and coefficient are broadcast to."""
    shapes = [x.shape for x in given]
    try:
        shape = np.broadcast_shapes(*shapes)
        if math.prod(shape) <= LARGEST:
            return shape
    except ValueError:
        pass
    given_shapes = ", ".join(map(str, shapes))
    raise ModelError(f"slip, normal, mu: arrays of shapes {given_shapes} were given, expected ones that go together")


def check_static_friction(law: Any, mu: float, contact: str) -> None:
    """Raise ModelError where the static coefficient of a law is less than the ``mu`` of a contact."""
    static = law.static_friction
    if static is not None and static < mu:
        raise ModelError(
            f"static_friction: {shown(static)} was given, "
            f"expected at least the friction {shown(mu)} of contact {contact!r}"
        )
