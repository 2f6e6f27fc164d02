"""Contact problems in space that tests share: towers of boxes, whose operator has half its rank, and heaps."""

import numpy as np

from lcpflex.solvers import SpatialContactProblem


def tower(boxes, friction=0.5, tilt=0.0, spin=0.0, seed=0):
    """A tower of equal cubes, four corner contacts each: rank 6 of 12 rows a box; it falls, leans and turns."""
    rng = np.random.default_rng(seed)
    factor = np.zeros((12 * boxes, 6 * boxes))
    corners = [(x, y) for x in (-0.5, 0.5) for y in (-0.5, 0.5)]
    shares = np.sqrt([1.0, 1.0, 1.0, 6.0, 6.0, 6.0])  # 1 / sqrt(m), 1 / sqrt(J), J = m / 6
    for box in range(boxes):
        for k, (x, y) in enumerate(corners):
            rows = slice(12 * box + 3 * k, 12 * box + 3 * k + 3)
            factor[rows, 6 * box : 6 * box + 6] = _point(x, y, -0.5) * shares
            if box:
                factor[rows, 6 * box - 6 : 6 * box] = -_point(x, y, 0.5) * shares
    velocity = np.zeros((boxes, 6))
    velocity[:, 0], velocity[:, 2] = tilt, -1.0
    velocity[:, 5] = spin
    velocity[1:] += 0.02 * rng.normal(size=(boxes - 1, 6))
    free = factor @ (velocity / shares).ravel()
    return SpatialContactProblem(factor @ factor.T, free, np.full(4 * boxes, friction))


def _point(x, y, z):
    """Rows of the velocity along z, x and y of a point of a body, in its v and omega."""
    rows = np.zeros((3, 6))
    for row, axis in zip(rows, (2, 0, 1), strict=True):
        row[axis] = 1.0
        row[3:] = np.cross((x, y, z), np.eye(3)[axis])
    return rows


def heap(contacts, bodies, seed=0, friction=(0.1, 1.0)):
    """Random contacts between bodies, or with the ground, most of which approach."""
    rng = np.random.default_rng(seed)
    factor = np.zeros((3 * contacts, 6 * bodies))
    for k in range(contacts):
        for body in rng.choice(bodies + 1, size=2, replace=False):
            if body < bodies:
                factor[3 * k : 3 * k + 3, 6 * body : 6 * body + 6] = _turned(rng) @ _point(*rng.normal(size=3))
    free = rng.normal(size=3 * contacts)
    free[::3] -= 1.0
    # in the range of the operator: velocities that bodies can have
    free = factor @ np.linalg.lstsq(factor, free, rcond=None)[0]
    return SpatialContactProblem(factor @ factor.T, free, rng.uniform(*friction, size=contacts))


def _turned(rng):
    return np.linalg.qr(rng.normal(size=(3, 3)))[0]
