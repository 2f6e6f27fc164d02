"""The bodies of a spatial scene as arrays."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from lcpflex.bodies.spatial.body import SpatialBody
from lcpflex.bodies.spatial.checks import skew_part
from lcpflex.jit.kernel import FloatArray
from lcpflex.model.arrays import frozen
from lcpflex.model.spatial import N_PLACE, N_RIGID, SpatialBodies

__all__ = ["compile_spatial_bodies", "is_centred"]

ROUNDING = 1e-12  # of its scale, below which an integral is taken for the zero that it stands for


def is_centred(body: SpatialBody) -> bool:
    """Whether the frame is a mean frame about the mass centre: <x> = 0, <Phi> = 0 and <x x Phi_k> = 0 to rounding."""
    radius = math.sqrt(float(np.trace(body.second)) / body.mass)
    worst = max(
        float(np.abs(body.moment).max()) / (body.mass * radius),
        float(np.abs(body.S).max(initial=0.0)) / math.sqrt(body.mass),
        float(np.abs(skew_part(body.first)).max(initial=0.0)) / (math.sqrt(body.mass) * radius),
    )
    return worst <= ROUNDING


def compile_spatial_bodies(sources: Sequence[SpatialBody]) -> SpatialBodies:
    """Inertia, stiffness and damping of all bodies, one after the other.

    What is zero to rounding in the frame of a centred body becomes zero: moment, S and the skew part of each P1_k.
    """
    centred = [is_centred(body) for body in sources]

    def joined(name: str, columns: int = 0) -> FloatArray:
        shape = (-1, columns) if columns else -1
        parts = [np.reshape(getattr(body, name), shape) for body in sources]
        return frozen(np.concatenate([np.zeros((0, columns) if columns else 0), *parts]), columns=columns)

    def unless_centred(name: str) -> FloatArray:
        parts = [(0.0 if mean else 1.0) * getattr(body, name) for body, mean in zip(sources, centred, strict=True)]
        return frozen(np.concatenate([np.zeros((0, 3)), *(part.reshape(-1, 3) for part in parts)]))

    arrays: dict[str, Any] = {name: joined(name) for name in ("stiffness", "damping")}
    for name, parts in (
        ("cross_damping", [body.cross_damping for body in sources]),
        ("products", [body.products for body in sources]),
        ("geometric", [None if body.geometric is None else np.moveaxis(body.geometric, 0, 2) for body in sources]),
    ):
        flat = [np.zeros(0) if part is None else np.ravel(part) for part in parts]
        arrays[f"{name}_start"] = frozen(np.cumsum([0, *map(len, flat)]), np.int64)
        arrays[name] = frozen(np.concatenate([np.zeros(0), *flat]))
    firsts = [_first(body, mean) for body, mean in zip(sources, centred, strict=True)]
    return SpatialBodies(
        dof=frozen(np.cumsum([0, *(N_RIGID + body.modes for body in sources)]), np.int64),
        place=frozen(np.cumsum([0, *(N_PLACE + body.modes for body in sources)]), np.int64),
        centred=frozen(centred, np.int64),
        mass=frozen([body.mass for body in sources]),
        moment=unless_centred("moment"),
        second=frozen(np.reshape([body.second for body in sources], (-1, 3, 3))),
        S=unless_centred("S"),
        first=frozen(np.concatenate([np.zeros((0, 9)), *firsts])),
        second_modes=frozen([body.second_order_modes for body in sources], np.int64),
        **arrays,
    )


def _first(body: SpatialBody, centred: bool) -> FloatArray:
    """(n, 9) P1, exactly symmetric in the mean frame, where <x x Phi_k> vanishes."""
    P = body.first.reshape(-1, 3, 3)
    return np.asarray((0.5 * (P + P.transpose(0, 2, 1)) if centred else P).reshape(-1, 9))
