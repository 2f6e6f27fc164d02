"""Properties of piles: sticking, energy, order of bodies, islands that join and part, mass ratios, units, same bits."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex import gallery
from lcpflex.jit.kernel import FloatArray

G = 9.81
STEP = lf.MoreauJean(step=1e-3)


def run(scene: lf.Scene, duration: float, stepper: Any = STEP, record: float | None = 0.01) -> lf.Result:
    result = lf.simulate(scene, duration, stepper, record=record, progress=False)
    assert result.complete
    return result


@pytest.mark.parametrize("name", ["heap", "struck_wall", "link_chain", "hopper"])
def test_energy_audit_closes_and_two_runs_have_the_same_bits(name: str) -> None:
    first, second = (run(gallery.scenes()[name].build(), 0.25) for _ in range(2))  # type: ignore[arg-type]
    assert first.impulse[-1].any()
    assert first.energies.largest_remainder <= 1e-3 * first.energies.scale
    lost = first.energies.friction + first.energies.impact + first.energies.damping
    # together: friction may drive a body on in an impact; forces of a step act on what parted before it, too: order h
    assert (np.diff(lost) >= -1e-5 * first.energies.scale).all()
    for field in ("times", "q", "u", "force", "impulse", "residual"):
        assert getattr(first, field).tobytes() == getattr(second, field).tobytes()


@pytest.mark.parametrize("stepper", [lf.MoreauJean(step=1e-3), lf.GeneralizedAlpha(step=1e-3)], ids=["MJ", "GA"])
def test_what_sticks_in_a_wall_stays_where_it_is(stepper: Any) -> None:
    """A wall that leans on a slope below the angle of friction does not creep; above it, it slides as one block."""
    slope = 0.2

    def leaning(friction: float) -> lf.Result:
        scene = lf.Scene(gravity=(G * np.sin(slope), -G * np.cos(slope)))
        scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
        for course in range(4):
            for k in range(3):
                place = (0.21 * k, 0.05 + 0.1 * course)
                scene.add(lf.Box(width=0.2, height=0.1, mass=1.0), name=f"brick {course}.{k}", position=place)
        scene.contact_all(friction=friction)
        return run(scene, 0.2, stepper)

    stays, slides = leaning(0.3), leaning(0.1)
    assert np.abs(stays.q - stays.q[0]).max() <= 1e-10
    acceleration = G * (np.sin(slope) - 0.1 * np.cos(slope))
    assert slides.u[-1, 0::3] == pytest.approx(acceleration * 0.2, rel=1e-6)


def loose_discs(count: int, order: FloatArray | None = None, unit: float = 1.0, ratio: float = 1.0) -> lf.Scene:
    """Discs in a box, nearly touching, that move at random; lengths and masses in ``unit``, masses up to ``ratio``."""
    rng = np.random.default_rng(3)
    columns = 5
    radius = 0.1 * unit * (1.0 - 1e-4 * rng.uniform(size=count))
    mass = unit * ratio ** rng.uniform(size=count)
    place = 0.1 + 0.2 * np.column_stack(np.divmod(np.arange(count), columns)[::-1]).astype(float)
    velocity = 0.3 * rng.normal(size=(count, 2)) - [0.0, 0.5]
    scene = lf.Scene(gravity=(0.0, -G * unit))
    scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
    scene.ground.half_plane((0.0, 0.0), (1.0, 0.0))
    scene.ground.half_plane((unit, 0.0), (-1.0, 0.0))
    for k in np.arange(count) if order is None else order:
        disc = lf.Disc(radius[k], mass=mass[k])
        scene.add(disc, name=f"disc {k}", position=unit * place[k], velocity=unit * velocity[k])
    scene.contact_all(friction=0.5)
    return scene


def bricks(count: int, order: FloatArray | None = None, speed: float = 0.0) -> lf.Scene:
    """A wall of boxes in courses of four, each by half a box beside the one below, that move at random."""
    rng = np.random.default_rng(5)
    velocity, spin = speed * rng.normal(size=(count, 2)), speed * rng.normal(size=count)
    scene = lf.Scene(gravity=(0.0, -G))
    scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
    for k in np.arange(count) if order is None else order:
        course, i = divmod(int(k), 4)
        scene.add(
            lf.Box(width=0.2, height=0.1, mass=1.0),
            name=f"brick {k}",
            position=(0.201 * i + 0.1 * (course % 2), 0.05 + 0.1 * course),
            velocity=velocity[k],
            angular_velocity=spin[k],
        )
    scene.contact_all(friction=0.5)
    return scene


def by_pair(result: lf.Result) -> dict[frozenset[str], FloatArray]:
    """Contact forces at the end, normal and tangential, of pairs of surfaces in either order."""
    names = (frozenset(name.split("/")) for name in result.contact_names)
    return {name: force for name, force in zip(names, result.force[-1], strict=True) if force.any()}


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize(
    ("build", "count"),
    [(loose_discs, 8), (loose_discs, 40), (loose_discs, 120), (bricks, 24), (partial(bricks, speed=0.05), 24)],
    ids=["heap of 8", "heap of 40", "heap of 120", "wall at rest", "wall in motion"],
)
def test_a_step_does_not_depend_on_the_order_in_which_bodies_were_added(build: Any, count: int, seed: int) -> None:
    """Velocities to ten times the residual, angular ones as those of points 0.1 m away.

    Contact forces of the wall at rest are not unique: those that the step found differ by a sixth, the least ones,
    which results hold, do not.
    """
    order = np.random.default_rng(seed).permutation(count)
    one, other = (run(build(count, o), 1e-3, record=1e-3) for o in (None, order))
    rows = (3 * order[:, None] + [0, 1, 2]).ravel()
    assert one.size[-1] >= 3 * count // 4
    assert one.strict is not None
    assert other.strict is not None
    free = np.abs(one.u[0]).max() + G * 1e-3
    off = np.abs(one.u[-1, rows] - other.u[-1]).reshape(-1, 3) * [1.0, 1.0, 0.1]
    assert off.max() <= 10.0 * max(one.strict.max(), other.strict.max(), 1e-13) * free
    forces, others = by_pair(one), by_pair(other)
    largest = max(np.abs(force).max() for force in forces.values())
    none = np.zeros(2)
    for pair in forces.keys() | others.keys():
        assert np.abs(forces.get(pair, none) - others.get(pair, none)).max() <= 1e-7 * largest


@pytest.mark.parametrize("unit", [1e-3, 1e3])
def test_units_of_length_and_mass_do_not_matter(unit: float) -> None:
    """Millimetres and grams: the same velocities times the unit, to the residual."""
    one, other = (run(loose_discs(30, unit=u), 1e-3, record=1e-3) for u in (1.0, unit))
    assert one.size[-1] >= 30
    bound = 10.0 * max(one.residual.max(), other.residual.max(), 1e-13)
    for k in (0, 1):
        assert np.abs(other.u[-1, k::3] / unit - one.u[-1, k::3]).max() <= bound * np.abs(one.u).max()


@pytest.mark.parametrize("ratio", [1.0, 30.0, 1e3])
def test_heaps_of_unequal_masses_keep_their_momentum(ratio: float) -> None:
    result = run(loose_discs(30, ratio=ratio), 0.2)
    assert np.nanmax(result.residual) <= 1e-8
    assert result.energies.largest_remainder <= 1e-3 * result.energies.scale
    assert result.penetration.max() <= 2e-3


def two_columns(gap: float, speed: float) -> lf.Scene:
    """Two columns of boxes, and a disc that flies from the left towards the right between them."""
    scene = lf.Scene(gravity=(0.0, -G))
    scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
    for x in (0.0, gap):
        for k in range(12):
            scene.add(lf.Box(width=0.2, height=0.1, mass=1.0), name=f"box {x:g}.{k}", position=(x, 0.05 + 0.1 * k))
    place, velocity = (0.5 * gap, 0.15), (speed, 0.0)
    scene.add(lf.Disc(0.1, mass=0.5), name="disc", position=place, velocity=velocity)
    scene.contact_all(friction=0.3)
    return scene


def test_islands_join_and_part_where_a_body_moves_between_them() -> None:
    """The far column does not move before it is met, and the size of the largest problem follows the islands."""
    result = run(two_columns(0.42, 0.5), 0.15, record=1e-3)
    alone = run(two_columns(5.0, 0.0), 0.01, record=1e-3)
    box = slice(36, 72, 3)
    met = int(np.argmax(np.abs(result.u[:, box]).max(axis=1) > 1e-9))
    assert met > 0
    touch = result.times[met]
    assert touch == pytest.approx(0.01 / 0.5, abs=3e-3)
    assert not np.abs(result.q[: met - 1, :36] - result.q[0, :36]).max() > 1e-10
    assert alone.size.max() < result.size.max()
    assert np.nanmax(result.residual) <= 1e-8
    assert result.energies.largest_remainder <= 1e-3 * result.energies.scale


def test_independent_columns_move_as_if_they_were_alone() -> None:
    def columns(count: int) -> lf.Scene:
        scene = lf.Scene(gravity=(0.0, -G))
        scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
        for c in range(count):
            for k in range(5):
                scene.add(
                    lf.Box(width=0.2, height=0.1, mass=1.0),
                    name=f"box {c}.{k}",
                    position=(1.0 * c, 0.05 + 0.1 * k),
                    velocity=(0.2 * k, 0.0),
                )
        scene.contact_all(friction=0.2)
        return scene

    one, four = run(columns(1), 0.3), run(columns(4), 0.3)
    assert four.size.max() == one.size.max()
    relative = four.q.reshape(len(four.times), 4, 5, 3) - [[[[c, 0.0, 0.0]] for c in range(4)]]
    assert np.abs(relative - one.q.reshape(len(one.times), 1, 5, 3)).max() <= 1e-9
