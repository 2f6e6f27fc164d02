"""A chain of rings on a bar: it falls into its links, swings, and comes to rest.

Each ring is one body with eight capsules around it, an octagon; nothing but contact holds a ring in the next. They
begin with slack and with a push: rings strike each other, roll and slide. Point contacts do not resist spin about their
normal, so a drag in the air, c v at each ring, ends what swings across the bar. What must come out, with the mass M of
all rings and of the bar, which a load cell holds:

* at any time, the cell has given the impulse  M g t + momentum - its start + c (ways of the rings);
* at rest it carries M g, and the contacts above each ring the weight of it and of those below;
* at rest neighbours are  2 R - 2 r sqrt(1 + sin^2 a) / cos a  apart, a = 22.5 degrees: two corners of octagons, with
  corners at R and tubes of radius r, hook into each other at right angles, each side of one on each of the other. What
  impacts left of depth makes it more, by  sqrt(1 + sin^2 a) / cos a  times that depth at most;
* rings that are linked stay linked: Gauss's linking number of neighbours is 1 or -1 at all times, and no tube is
  deeper in another than the speed of an impact times the step.
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from scipy.spatial.transform import Rotation

import lcpflex as lf
from lcpflex.bodies import SurfaceShape

RINGS, SIDES, RADIUS, TUBE, MASS = 5, 8, 0.04, 0.006, 0.1  # a ring: corners at RADIUS [m], [m], [kg]
FRICTION, SLACK, PUSH = 0.3, 6e-3, 0.5  # [m] a link, [m/s]
DRAG, GRAVITY, END, STEP = 0.3, 9.81, 3.0, 5e-4  # c [N s/m], [m/s^2], [s], [s]
HALF = np.pi / SIDES
HOOK = 2.0 * TUBE * np.sqrt(1.0 + np.sin(HALF) ** 2) / np.cos(HALF)  # between the corners of two rings [m]
PITCH = 2.0 * RADIUS - HOOK  # of the chain at rest [m]
CORNERS = RADIUS * np.array([[np.sin(2.0 * k * HALF), 0.0, np.cos(2.0 * k * HALF)] for k in range(SIDES)])


def ring_shape(around: int = 10) -> SurfaceShape:
    """What is drawn: a tube along the octagon."""
    angle = 2.0 * np.pi * np.arange(around) / around
    outward = CORNERS / RADIUS
    tube = [
        corner + TUBE * (np.cos(t) * out / np.cos(HALF) + np.sin(t) * np.array([0.0, 1.0, 0.0]))
        for corner, out in zip(CORNERS, outward, strict=True)
        for t in angle
    ]
    k, j = (grid.ravel() for grid in np.meshgrid(np.arange(SIDES), np.arange(around), indexing="ij"))
    here, there = k * around, (k + 1) % SIDES * around
    up = (j + 1) % around
    first = np.stack([here + j, there + j, there + up], axis=1)
    second = np.stack([here + j, there + up, here + up], axis=1)
    triangles = np.concatenate([first, second])
    return SurfaceShape(np.array(tube), triangles[:, ::-1], np.zeros((len(tube), 0, 3)))


def ring() -> lf.SpatialBody:
    """A thin ring in the x-z plane."""
    across = 0.5 * MASS * (RADIUS * np.cos(HALF)) ** 2
    second = np.diag([across, 0.5 * MASS * TUBE**2, across])
    return lf.SpatialBody(mass=MASS, second=second, points={}, shape=ring_shape())


def chain() -> lf.SpatialScene:
    """Rings hang from a bar along y, each a quarter turned against the one above."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, -GRAVITY))
    along_y = Rotation.from_euler("x", 90, degrees=True)
    bar = scene.add(lf.Capsule(TUBE, 0.12, mass=MASS), name="bar", orientation=along_y)
    scene.join(lf.Weld(bar.point("center"), scene.ground.at(0.0, 0.0, 0.0), name="load cell"))
    above = [bar.surface()]
    height = 2.0 * TUBE / np.cos(HALF) - RADIUS + SLACK
    for n in range(RINGS):
        placed = scene.add(
            ring(), name=f"ring {n + 1}", position=(0.0, 0.0, height),
            orientation=Rotation.from_euler("z", 90 * (n % 2), degrees=True),
            velocity=(PUSH * n / RINGS, 0.5 * PUSH * n / RINGS, 0.0),
        )  # fmt: skip
        around = [placed.capsule(CORNERS[k], CORNERS[(k + 1) % SIDES], TUBE) for k in range(SIDES)]
        for i, a in enumerate(above):
            for j, b in enumerate(around):
                scene.contact(b, a, friction=FRICTION, name=f"{n} {i} {j}")
        air = scene.ground.at(0.0, 0.0, height)
        scene.load(lf.Bushing(placed.at(0.0, 0.0, 0.0), air, stiffness=(0.0, 0.0, 0.0), damping=(DRAG, DRAG, DRAG)))
        above, height = around, height - PITCH + SLACK
    return scene


def carried(result: lf.Result) -> np.ndarray:
    """(RINGS, 3) what the contacts above each ring do to it at the end [N]."""
    points = result.contact_points.at(len(result.times) - 1)
    below = np.array([int(result.contact_names[k].split()[0]) for k in points.contact])
    return np.array([points.vector[below == n].sum(axis=0) for n in range(RINGS)])


def left_over(result: lf.Result) -> np.ndarray:
    """(m, 3) what the book of impulses leaves over [N s]; every step is stored."""
    cell = result.reaction("load cell")
    given = cell.impulse + np.cumsum(np.nan_to_num(cell.force) * STEP, axis=0)
    centres = np.array([result.point(f"ring {n + 1}", (0.0, 0.0, 0.0)) for n in range(RINGS)])
    ways = (centres - centres[:, :1]).sum(axis=0)
    momentum = result.momentum().linear
    weight = np.outer(result.times, [0.0, 0.0, -(RINGS + 1) * MASS * GRAVITY])
    return np.asarray(momentum - momentum[0] - given - weight + DRAG * ways)


def linking(first: np.ndarray, second: np.ndarray) -> float:
    """Linking number of two closed polygons (k, 3): solid angles of pairs of sides, summed (Klenin and Langowski)."""
    total = 0.0
    for a, b in zip(first, np.roll(first, -1, axis=0), strict=True):
        for c, d in zip(second, np.roll(second, -1, axis=0), strict=True):
            ca, da, cb, db = c - a, d - a, c - b, d - b
            corners = np.array([np.cross(ca, da), np.cross(da, db), np.cross(db, cb), np.cross(cb, ca)])
            n = corners / np.linalg.norm(corners, axis=1, keepdims=True)
            angle = np.arcsin(np.clip(np.sum(n * np.roll(n, -1, axis=0), axis=1), -1.0, 1.0)).sum()
            total += angle * np.sign(np.dot(np.cross(d - c, b - a), c - a))
    return total / (4.0 * np.pi)


def run(folder: Path = Path()) -> lf.Result:
    result = lf.simulate(chain(), END, lf.MoreauJean(step=STEP), record=STEP)
    names = [f"ring {n + 1}" for n in range(RINGS)]
    polygons = np.array(
        [[result.point(name, (corner[0], corner[1], corner[2])) for corner in CORNERS] for name in names]
    )
    looked = range(0, len(result.times), 50)
    linked = np.array([[linking(polygons[n, :, k], polygons[n + 1, :, k]) for n in range(RINGS - 1)] for k in looked])
    heights = np.array([result.point(name, (0.0, 0.0, 0.0))[:, 2] for name in names])
    pitch = -np.diff(heights[:, -1])
    cell, above = result.reaction("load cell").force[-1, 2], carried(result)
    weight, below = (RINGS + 1) * MASS * GRAVITY, MASS * GRAVITY * np.arange(RINGS, 0, -1)
    book = np.abs(left_over(result)).max()
    deepest = float(np.max(result.penetration))
    print(f"load cell at rest {cell:.6f} N, weight {weight:.6f} N")
    print(f"above the rings {above[:, 2].round(5)} N, weight {below.round(5)} N")
    print(
        f"rings apart at rest {1e3 * pitch.min():.3f} to {1e3 * pitch.max():.3f} mm, closed form {1e3 * PITCH:.3f} mm"
    )
    print(f"book of impulses: {book:.1e} N s of {weight * END:.1f} N s are left over")
    found = sorted(set(np.abs(linked).round(9).ravel().tolist()))
    print(f"linking numbers, without sign: {found}; tubes at most {1e3 * deepest:.3f} mm deep in others")
    assert abs(cell / weight - 1.0) < 1e-4
    assert np.abs(above[:, 2] / below - 1.0).max() < 1e-3
    assert (pitch - PITCH).min() > -1e-5
    assert (pitch - PITCH).max() < HOOK / (2.0 * TUBE) * result.penetration[-1] + 1e-5
    assert np.abs(np.abs(linked) - 1.0).max() < 1e-9
    assert deepest < STEP * 0.5  # at 0.5 m/s
    assert book < 1e-4 * weight * END

    figure = Figure(figsize=(12, 7), layout="constrained")
    grid = figure.add_gridspec(2, 3)
    for column, t in enumerate((0.3, END)):
        axes = figure.add_subplot(grid[:, column])
        result.draw(t, axes=axes, view=(12.0, -55.0))
    force, place = figure.add_subplot(grid[0, 2]), figure.add_subplot(grid[1, 2])
    force.plot(result.times, result.reaction("load cell").force[:, 2], linewidth=0.8, label="load cell")
    force.axhline(weight, color="black", linestyle=":", label="weight")
    force.set(ylabel="force [N], but for impacts", xlabel="time [s]", ylim=(0.0, 2.5 * weight))
    force.legend()
    for axis, label in enumerate("xy"):
        place.plot(result.times, 1e3 * result.point(names[-1], (0.0, 0.0, 0.0))[:, axis], label=f"last ring, {label}")
    place.set(ylabel="place [mm]", xlabel="time [s]")
    place.legend()
    figure.savefig(folder / "chain_of_rings.png", dpi=110)
    return result


if __name__ == "__main__":
    print(run().summary())
