"""Scenes of many bodies that the benchmarks share, and the CPU seconds of the steps of each contestant."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

import lcpflex as lf
from tests.benchmarks.peers.body_gauss_seidel import Discs, solve

STEP, FRICTION, GRAVITY = 1e-3, 0.5, 9.81
FloatArray = NDArray[np.float64]


@dataclass
class Steps:
    """What steps cost [s of CPU] and how well their contact problems were solved (STRICT: of the free velocity)."""

    seconds: FloatArray
    residual: FloatArray = field(default_factory=lambda: np.zeros(0))

    def __str__(self) -> str:
        ms = 1e3 * self.seconds
        text = f"first {ms[0]:.2f}, mean {ms.mean():.3f}, median {np.median(ms):.3f}, slowest {ms.max():.2f} ms"
        if not self.residual.size:
            return text
        unmet = np.count_nonzero(self.residual > 1e-8)
        return f"{text}; STRICT {self.residual.max():.0e}, {unmet} of {len(ms)} above 1e-8"


def heap_of(count: int, scatter: float = 0.02, seed: int = 1) -> tuple[FloatArray, FloatArray, float]:
    """Centres and angles (n, 3), radii (n,) and the width of the box of discs that are about to fall into it."""
    rng = np.random.default_rng(seed)
    columns = max(3, round(math.sqrt(0.6 * count)))
    radius = 0.1 * (1.0 - scatter * rng.uniform(size=count))
    row, column = np.divmod(np.arange(count), columns)
    q = np.column_stack([0.11 + 0.22 * column + 0.008 * rng.uniform(-1.0, 1.0, count), 0.105 + 0.22 * row, 0.0 * row])
    return q, radius, 0.22 * columns


def overlap(q: FloatArray, radius: FloatArray, width: float) -> float:
    """The largest one [m]."""
    near = np.linalg.norm(q[:, None, :2] - q[None, :, :2], axis=2) - radius[:, None] - radius[None]
    np.fill_diagonal(near, 1.0)
    sides = np.minimum(np.minimum(q[:, 0], width - q[:, 0]), q[:, 1]) - radius
    return float(max(0.0, -near.min(), -sides.min()))


def box_of_discs(q: FloatArray, radius: FloatArray, width: float, u: FloatArray | None = None) -> lf.Scene:
    """Scene of discs of 1 kg between two walls."""
    scene = lf.Scene(gravity=(0.0, -GRAVITY))
    scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
    scene.ground.half_plane((0.0, 0.0), (1.0, 0.0))
    scene.ground.half_plane((width, 0.0), (-1.0, 0.0))
    rate = np.zeros_like(q) if u is None else u
    for k, r in enumerate(radius):
        scene.add(
            lf.Disc(r, mass=1.0),
            name=f"disc {k}",
            position=(q[k, 0], q[k, 1]),
            angle=q[k, 2],
            velocity=(rate[k, 0], rate[k, 1]),
            angular_velocity=rate[k, 2],
        )
    scene.contact_all(friction=FRICTION)
    return scene


def tower_of(count: int) -> FloatArray:
    """Places of boxes on each other."""
    return np.array([(0.0, 0.05 + 0.1 * k) for k in range(count)])


def wall_of(count: int) -> FloatArray:
    """Places of about as many boxes, in courses of their square root, each by half a box beside the one below."""
    m = round(math.sqrt(count))
    return np.array([(0.2 * k + 0.1 * (r % 2), 0.05 + 0.1 * r) for r in range(count // m) for k in range(m)])


def boxes_at(places: FloatArray) -> lf.Scene:
    """Boxes of 1 kg, 0.2 m x 0.1 m."""
    scene = lf.Scene(gravity=(0.0, -GRAVITY))
    scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
    for k, (x, y) in enumerate(places):
        scene.add(lf.Box(width=0.2, height=0.1, mass=1.0), name=f"box {k}", position=(x, y))
    scene.contact_all(friction=FRICTION)
    return scene


def own_steps(scene: lf.Scene, steps: int, skip: int = 0, stepper: object = None) -> Steps:
    """Steps of lcpflex by its run, recording nothing, with the residuals of a run that stores each."""
    stepper = lf.MoreauJean(step=STEP) if stepper is None else stepper
    run = stepper.start(scene.compiled().system(), 1e3, 1e3)  # type: ignore[attr-defined]
    if skip:
        assert not run.advance(skip)
    seconds = np.empty(steps)
    for k in range(steps):
        began = time.process_time()
        assert not run.advance(1)
        seconds[k] = time.process_time() - began
    return Steps(seconds)


def strict_of(scene: lf.Scene, steps: int) -> FloatArray:
    """STRICT residual of each step."""
    result = lf.simulate(scene, steps * STEP, lf.MoreauJean(step=STEP), record=STEP, progress=False)
    assert result.strict is not None
    return np.nan_to_num(result.strict[1:])


def sweeping_steps(heap: Discs, steps: int, tolerance: float = 1e-8, most: int = 2000) -> Steps:
    """Steps of body Gauss-Seidel."""
    seconds, residual = np.empty(steps), np.empty(steps)
    for k in range(steps):
        began = time.process_time()
        residual[k] = heap.step(tolerance, most)[0]
        seconds[k] = time.process_time() - began
    return Steps(seconds, residual)


def sweeping_boxes(places: FloatArray, steps: int, most: int) -> Steps:
    """Steps of body Gauss-Seidel for boxes at rest, on the contact points that lcpflex finds at the start."""
    result = lf.simulate(boxes_at(places), STEP, lf.MoreauJean(step=STEP), record=STEP, progress=False)
    points = result.contact_points
    last = points.record == 1
    number = {f"box {k}.outline": k for k in range(len(places))}
    bodies = np.array([[number.get(s, -1) for s in result.contact_names[c].split("/")] for c in points.contact[last]])
    normal, place = points.normal[last], points.place[last]
    centre = np.vstack([places, [0.0, -1.0]])  # the last one: that of the ground
    turned = np.einsum("ki,ki->k", normal, centre[bodies[:, 0]] - centre[bodies[:, 1]]) < 0.0
    bodies[turned] = bodies[turned, ::-1]
    arms = np.where(bodies[:, :, None] >= 0, place[:, None] - centre[bodies], 0.0)
    inverse = np.tile([1.0, 12.0 / (0.2**2 + 0.1**2)], (len(places), 1))
    u, p = np.zeros((len(places), 3)), np.zeros((len(bodies), 2))
    seconds, residual = np.empty(steps), np.empty(steps)
    for k in range(steps):
        began = time.process_time()
        u[:, 1] -= GRAVITY * STEP
        residual[k] = solve(u, inverse, bodies, normal, arms, FRICTION, p, 1e-8, most)[0]
        seconds[k] = time.process_time() - began
    return Steps(seconds, residual)


def exponent(sizes: list[int], seconds: list[float]) -> float:
    """Slope of a straight line through the logarithms."""
    return float(np.polyfit(np.log(sizes), np.log(seconds), 1)[0])
