"""Spatial models made by hand: two bodies with random inertia-free modes, points of them and of the ground."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from lcpflex.dynamics.time_functions import SignalTable
from lcpflex.jit.kernel import FloatArray
from lcpflex.jit.struct import pack
from lcpflex.kinematics.spatial.configuration import advance
from lcpflex.model.arrays import Offsets, frozen
from lcpflex.model.coordinates import SPATIAL_KINDS as KINDS
from lcpflex.model.spatial import (
    SpatialBodies,
    SpatialJoints,
    SpatialLoads,
    SpatialModel,
    SpatialPointTable,
    no_spatial_contacts,
)

__all__ = ["MODES", "Line", "Moving", "bodies_of", "derivatives", "model_of", "moving"]

MODES = (3, 2)
Row = tuple[Any, ...]


def bodies_of(modes: Sequence[int]) -> SpatialBodies:
    """Offsets and unit masses: what kinematics asks of bodies."""
    nb, total = len(modes), sum(modes)
    sizes: Offsets = np.concatenate([[0], np.cumsum(modes)])
    return SpatialBodies(
        dof=frozen(sizes + 6 * np.arange(nb + 1), np.int64),
        place=frozen(sizes + 7 * np.arange(nb + 1), np.int64),
        centred=frozen(np.ones(nb), np.int64),
        mass=frozen(np.ones(nb)),
        moment=frozen(np.zeros((nb, 3))),
        second=frozen(np.tile(np.eye(3), (nb, 1, 1))),
        S=frozen(np.zeros((total, 3))),
        first=frozen(np.zeros((total, 9))),
        stiffness=frozen(np.ones(total)),
        damping=frozen(np.zeros(total)),
        cross_damping_start=frozen(np.zeros(nb + 1), np.int64),
        cross_damping=frozen([]),
        second_modes=frozen(np.zeros(nb), np.int64),
        products_start=frozen(np.zeros(nb + 1), np.int64),
        products=frozen([]),
    )


@dataclass(slots=True)
class Line:
    """One joint row or spring: kind, directions, rest, motion, points."""

    kind: str
    axis: Any = (1.0, 0.0, 0.0)
    on_p: Any = (0.0, 0.0, 0.0)
    on_q: Any = (0.0, 0.0, 0.0)
    rest: float = 0.0
    motion: Any = None
    ends: tuple[int, int] = (0, 1)


@dataclass(slots=True)
class Moving:
    """A model and a state of it."""

    model: Any
    q: FloatArray
    u: FloatArray
    external: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))

    def at(self, t: float, a: FloatArray | None = None) -> FloatArray:
        """q at time t of a motion that has velocity u and acceleration a at 0."""
        out = self.q.copy()
        advance(self.model, self.q, self.u if a is None else self.u + 0.5 * t * a, t, out)
        return out


def model_of(
    modes: Sequence[int],
    points: SpatialPointTable,
    lines: Sequence[Line] = (),
    springs: Sequence[tuple[Line, float, float]] = (),
    forces: Sequence[tuple[int, int, Sequence[Any]]] = (),
) -> SpatialModel:
    """A model of bodies with so many modes, each line a joint of its own."""
    signals = SignalTable()
    moved = [-1 if line.motion is None else signals.motion("motion", line.motion) for line in lines]
    driven = [[signals.force("force", part) for part in parts] for _, _, parts in forces]
    joints = SpatialJoints(
        point=frozen([line.ends for line in lines], np.int64, columns=2),
        row=frozen(np.arange(len(lines) + 1), np.int64),
        kind=frozen([KINDS.index(line.kind) for line in lines], np.int64),
        axis=frozen([line.axis for line in lines], columns=3),
        on_p=frozen([line.on_p for line in lines], columns=3),
        on_q=frozen([line.on_q for line in lines], columns=3),
        rest=frozen([line.rest for line in lines]),
        signal=frozen(moved, np.int64),
    )
    loads = SpatialLoads(
        gravity=frozen(np.zeros(3)),
        spring_kind=frozen([KINDS.index(line.kind) for line, _, _ in springs], np.int64),
        spring_point=frozen([line.ends for line, _, _ in springs], np.int64, columns=2),
        spring_axis=frozen([line.axis for line, _, _ in springs], columns=3),
        spring_on_p=frozen([line.on_p for line, _, _ in springs], columns=3),
        spring_on_q=frozen([line.on_q for line, _, _ in springs], columns=3),
        spring_value=frozen([(k, d, line.rest) for line, k, d in springs], columns=3),
        force_kind=frozen([kind for kind, _, _ in forces], np.int64),
        force_point=frozen([point for _, point, _ in forces], np.int64),
        force_signal=frozen(driven, np.int64, columns=3),
    )
    return SpatialModel(bodies_of(modes), points.compile(), signals.compile()[0], joints, loads, no_spatial_contacts())


def moving(seed: int, modes: Sequence[int] = MODES, grounded: int = -1, far: float = 1.0, **parts: Any) -> Moving:
    """Two bodies anywhere, deformed and moving at random; points 0 and 1 on them, ``grounded`` of which on the ground.

    far: size of the angle between the two bodies [rad].
    """
    random = np.random.default_rng(seed)
    points = SpatialPointTable()
    for end in range(2):
        n = 0 if end == grounded else modes[end]
        points.add(
            -1 if end == grounded else end,
            random.uniform(-1, 1, 3),
            0.3 * random.standard_normal((n, 3)),
            0.3 * random.standard_normal((n, 3)),
        )
    model = pack(model_of(modes, points, **parts))
    n = 12 + sum(modes)
    q = np.zeros(n + 2)
    for b in range(2):
        q[model.bodies.place[b] + 3] = 1.0
    turn = random.standard_normal(n)
    both = random.standard_normal(3) if grounded < 0 else np.zeros(3)
    for b in range(2):
        d = model.bodies.dof[b]
        turn[d + 3 : d + 6] *= far / np.linalg.norm(turn[d + 3 : d + 6]) * (0.5 if grounded < 0 else 1.0)
    lifted = np.zeros(n)
    for b in range(2):
        d = model.bodies.dof[b]
        lifted[d + 3 : d + 6] = both
    advance(model, q, lifted, 1.0, q)
    advance(model, q, turn, 1.0, q)
    return Moving(model, q, random.standard_normal(n))


def derivatives(values: Any, h: float) -> tuple[FloatArray, FloatArray]:
    """First and second derivative at 0 of a function of time, by central differences of the eighth order."""
    near = [np.asarray(values(k * h), dtype=float) for k in range(-4, 5)]
    first = (1 / 280, -4 / 105, 1 / 5, -4 / 5, 0.0, 4 / 5, -1 / 5, 4 / 105, -1 / 280)
    second = (-1 / 560, 8 / 315, -1 / 5, 8 / 5, -205 / 72, 8 / 5, -1 / 5, 8 / 315, -1 / 560)
    one = sum(weight * value for weight, value in zip(first, near, strict=True)) / h
    two = sum(weight * value for weight, value in zip(second, near, strict=True)) / (h * h)
    return np.asarray(one), np.asarray(two)
