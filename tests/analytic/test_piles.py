"""Heaps, walls, strips, chains, hoppers and silos of the gallery: sums of forces and impulses known exactly."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex import gallery
from lcpflex.jit.kernel import FloatArray

G = 9.81
STEP = lf.MoreauJean(step=1e-3)
NORMALS = {"half_plane1": (0.0, 1.0), "half_plane2": (1.0, 0.0), "half_plane3": (-1.0, 0.0)}


def run(scene: lf.Scene, duration: float, stepper: Any = STEP, record: float = 0.01, solved: float = 1e-8) -> lf.Result:
    result = lf.simulate(scene, duration, stepper, record=record, progress=False)
    assert result.complete
    assert np.nanmax(result.residual) <= solved
    assert result.energies.largest_remainder <= 0.02 * result.energies.scale
    assert not result.found_wrong
    return result


def momentum(result: lf.Result, masses: FloatArray) -> FloatArray:
    """(m, 2) of rigid bodies [N s]."""
    return np.column_stack([result.u[:, 0::3] @ masses, result.u[:, 1::3] @ masses])


def from_planes(result: lf.Result) -> FloatArray:
    """(m, 2) impulses of the half planes of the ground on the bodies since the start [N s]."""
    total = np.zeros((len(result.times), 2))
    for k, name in enumerate(result.contact_names):
        for plane, (x, y) in NORMALS.items():
            if name.endswith(f"ground.{plane}"):
                total += result.impulse[:, k] @ np.array([(x, y), (y, -x)])
    return total


def assert_momentum(result: lf.Result, masses: FloatArray) -> None:
    """What the ground gave is the change of momentum less that by the weight, at every stored instant."""
    gained = momentum(result, masses) - momentum(result, masses)[0]
    gained[:, 1] += masses.sum() * G * result.times
    scale = masses.sum() * G * result.times[-1]
    assert np.abs(gained - from_planes(result)).max() <= 1e-9 * scale
    assert from_planes(result)[-1].any()


def test_heap_takes_up_its_momentum_and_ends_with_its_weight_on_the_box() -> None:
    result = run(gallery.heap(), 2.0)
    masses = np.ones(30)
    assert_momentum(result, masses)
    late = result.times > 1.8
    assert result.energies.kinetic[late].max() <= 0.02 * result.energies.scale
    carried = np.diff(from_planes(result)[late][[0, -1]], axis=0)[0] / np.ptp(result.times[late])
    slowed = np.ptp(momentum(result, masses)[late], axis=0).max() / np.ptp(result.times[late])
    assert carried[1] == pytest.approx(30.0 * G, abs=slowed + 1e-6)
    assert abs(carried[0]) <= slowed + 1e-6


@pytest.mark.parametrize(("courses", "bricks", "friction"), [(6, 4, 0.5), (4, 3, 0.1), (5, 2, 1.0)])
def test_wall_at_rest_carries_in_each_course_what_is_above(courses: int, bricks: int, friction: float) -> None:
    result = run(gallery.brick_wall(courses, bricks, friction=friction), 0.05)
    assert np.abs(result.q - result.q[0]).max() <= 1e-9
    carried = np.zeros(courses)
    sidewards = 0.0
    for k, name in enumerate(result.contact_names):
        upper, lower = sorted(part.split(".outline")[0] for part in name.split("/"))[::-1]
        if lower.startswith("brick") and upper.startswith("brick"):
            above = int(upper.split()[1].split(".")[0]), int(lower.split()[1].split(".")[0])
            if above[0] == above[1]:
                sidewards += abs(result.force[-1, k, 0])
            else:
                carried[above[0] - 1] += result.force[-1, k, 0]
        else:
            carried[0] += result.force[-1, k, 0]
    weights = bricks * G * np.arange(courses, 0, -1)
    assert carried == pytest.approx(weights, rel=1e-8)
    assert sidewards <= 1e-8 * weights[0]


def test_struck_wall_loses_the_momentum_of_the_ball_to_the_ground() -> None:
    result = run(gallery.brick_wall(speed=3.0), 0.3)
    names = result.compiled.layout.bodies  # type: ignore[union-attr]
    halves = [f"brick {course}.{k}" for course in (2, 4, 6) for k in (1, 5)]
    masses = np.array([5.0 if name == "ball" else 0.5 if name in halves else 1.0 for name in names])
    assert masses.sum() == 29.0
    assert_momentum(result, masses)
    along = momentum(result, masses)[:, 0]
    assert along[0] == pytest.approx(gallery.scenes()["struck_wall"].reference["momentum"])
    assert (np.diff(along[along > 0.5]) <= 1e-9).all()  # friction slows it down
    assert result.energies.stored[-1] < result.energies.stored[0]


def test_strips_rest_with_their_weight_on_the_supports() -> None:
    case = gallery.scenes()["strip_pile"]
    result = run(case.build(), 0.3, case.stepper)  # type: ignore[arg-type]
    points = result.contact_points
    ground = [k for k, name in enumerate(result.contact_names) if "ground" in name]
    last = (points.record == len(result.times) - 1) & np.isin(points.contact, ground)
    n = points.normal[last]
    forces = points.force[last][:, :1] * n + points.force[last][:, 1:] * np.column_stack([n[:, 1], -n[:, 0]])
    total = forces.sum(axis=0)
    assert abs(total[1]) == pytest.approx(case.reference["weight"], rel=1e-6)
    assert abs(total[0]) <= 1e-6 * case.reference["weight"]
    assert result.energies.elastic[-1] > 1e-6 * result.energies.scale


@pytest.mark.parametrize("links", [5, 30, pytest.param(300, marks=pytest.mark.slow)])
def test_chain_falls_without_reactions_and_lies_with_its_weight(links: int) -> None:
    result = run(gallery.link_chain(links), 1.0)
    masses = np.full(links, 0.1)
    assert_momentum(result, masses)
    falls = (result.times > 0.0) & (result.times < 0.15)
    reactions = [result.reaction(f"joint {k + 1}") for k in range(links - 1)]
    weight = masses.sum() * G
    assert max(np.abs(r.force[falls]).max() for r in reactions) <= 1e-9 * weight
    assert max(np.linalg.norm(r.impulse[-1]) for r in reactions) > 0.0
    if links <= 30:
        last = from_planes(result)
        assert (last[-1] - last[-2])[1] / 0.01 == pytest.approx(weight, rel=1e-6)


def test_hung_chain_pulls_at_its_hook_and_every_joint_with_what_hangs_below() -> None:
    """Straight down: a chain of n links at rest carries k weights at its k-th joint from below."""
    result = run(gallery.link_chain(20, height=1.0, degrees=90.0, hung=True), 0.05)
    assert np.abs(result.u).max() <= 1e-9
    for k in range(19):
        assert result.reaction(f"joint {k + 1}").force[-1] == pytest.approx([0.0, (k + 1) * 0.1 * G], abs=1e-8)
    assert result.reaction("hook").force[-1] == pytest.approx([0.0, 20 * 0.1 * G], abs=1e-8)


def left_in(result: lf.Result) -> FloatArray:
    return np.asarray((result.q[:, 1::3] > 0.0).sum(axis=1), dtype=float)


@pytest.mark.slow
def test_hopper_clogs_with_friction_and_runs_empty_without() -> None:
    """However slightly they are moved: on steep sides, how many leave hangs on the last digits of a run."""
    for scatter in (0.05, 0.05001, 0.051):
        stopped = left_in(run(gallery.hopper(scatter=scatter), 1.25, record=0.05))
        assert 30 <= stopped[-1] <= 39
        assert (stopped[-10:] == stopped[-1]).all()  # half a second without one that leaves
    flowing = left_in(run(gallery.hopper(friction=0.0), 3.5, record=0.05))
    assert flowing[-1] <= 2
    assert flowing[np.searchsorted(-flowing, -39) + 10] <= 30  # of 40, half a second after the first one


def bottom_force(discs: int, seed: int = 1) -> float:
    """Mean on the sinking bottom of a silo [N], from 0.4 s after it began."""
    result = run(gallery.silo(discs, seed=seed), 3.0, solved=1e-5)  # steps of a settling pile may end in their budget
    own = [k for k, name in enumerate(result.contact_names) if "bottom" in name]
    impulse = result.impulse[:, own, 0].sum(axis=1)
    late = result.times >= 1.9
    return float((impulse[-1] - impulse[late][0]) / (result.times[-1] - result.times[late][0]))


@pytest.mark.slow
def test_walls_of_a_silo_carry() -> None:
    assert 0.3 * 24.0 * G < bottom_force(24) < 0.95 * 24.0 * G


@pytest.mark.slow
def test_force_on_the_bottom_of_a_silo_follows_janssen() -> None:
    """F = F_inf (1 - exp(-W / F_inf)), W the weight that was filled in, for the mean of three fillings."""
    fillings = np.array([8, 16, 32, 64])
    forces = np.array([np.mean([bottom_force(n, seed) for seed in (1, 2, 3)]) for n in fillings])
    weights = fillings * G

    def janssen(limit: float) -> FloatArray:
        return np.asarray(limit * -np.expm1(-weights / limit))

    limits = np.linspace(0.02, 3.0, 3000) * weights[-1]
    limit = min(limits, key=lambda f: float(np.sum((janssen(f) / forces - 1.0) ** 2)))
    assert forces == pytest.approx(janssen(limit), rel=0.25)
    assert (np.diff(forces / weights) < 0.0).all()  # the more, the larger the share of the walls
    assert forces[-1] < 0.8 * weights[-1]
