"""Forces of joints and closed contacts at a place of rest, of all that balance the loads those of the least norm.

    E x = -h,    lambda_N >= 0,    |lambda_T| <= mu lambda_N,    E = [J^T, W_N^T, W_T^T]

With one solution x_p and the null space N of E it is a least-distance problem in y, x = x_p + N y, solved by
non-negative least squares and then on its active constraints, to rounding. Which contacts have forces within their
cones in some solution is told by linear programs; which forces are the same in all by the null space of the sides that
all solutions touch.

In space cones are of second order, and programs of those, of an interior-point method, take the places of both.

Loads and rows are known to the accuracy of the place alone. Friction at many contacts of a long flexible body does
nearly nothing to it: E then has singular values s of 1e-9, and what is left of the balance, 1e-11 of the largest force,
moves the forces in such a direction by 1e-11 / s, out of their cones. Where no forces balance the loads exactly, those
directions v are open as far as that: |v.(x - x_p)| <= 1e-11 / s.

Source: Lawson & Hanson 1974 (least-distance programming).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linprog, nnls

from lcpflex.jit.kernel import FloatArray
from lcpflex.statics.balance import Configuration
from lcpflex.statics.cone_programs import Cones, ends_in_cones, margins_in_cones, shortest_in_cones
from lcpflex.statics.scales import Scales

__all__ = ["SharedForces", "could_stick", "shared_forces"]

CUT = 1e-10  # of the largest singular value of E: forces without an effect
BALANCED = 1e-9  # of the largest force: what may be left
KNOWN = 1e-11  # of the largest force: what a place of rest leaves of the balance (refinement.EXACT)
SLACK = 1e-11  # of the largest force: by how much a force may leave its cone
ACTIVE = 1e-9  # of the largest force: nearer to the side of a cone is on it
OPEN = 1e-7  # of the largest force: a range of solutions smaller than that is one force
SAME = 1e-9  # entry of the null space that is none
MARGIN = 1e-3  # of the largest force: as far inside a cone as is asked for
LIGHT = 1e-6  # of the largest force: contacts and joints of bodies that bear less are measured by no less
PULLS = 1e-3, 1e-14  # of the largest force on the lighter body, and on any: by how much a contact of it may pull


@dataclass(frozen=True, slots=True, eq=False)
class SharedForces:
    """Of a configuration with n contacts."""

    p: FloatArray  # multipliers of all rows of the configuration
    unique: NDArray[np.bool_]  # of each multiplier: the same in all solutions
    pressed: NDArray[np.bool_]  # (n,) carries a normal force in some solution
    sticks: NDArray[np.bool_]  # (m,) its force is within the cone in some solution


def shared_forces(
    at: Configuration,
    scales: Scales,
    closed: NDArray[np.bool_],
    unit: FloatArray,
    scale: float,
    acting: Callable[[FloatArray], FloatArray],
) -> SharedForces | None:
    """Of the ``closed`` (n,) contacts and all joints; None where no forces balance the loads.

    unit (rows,): what a multiplier is measured in for the norm, 1 for forces, a length for moments [m]. scale: the
    largest force that acts [N]. acting: (ndof,) the largest force on the body of each coordinate, of multipliers [N];
    by those of the lighter body it is told what a contact does, which beside heavy bodies would seem nothing.
    """
    chosen = np.concatenate([np.ones(at.n_joint, bool), closed, closed[at.tangent]])
    p, unique = np.zeros(len(at.rows)), np.ones(len(at.rows), bool)
    pressed, sticks = np.zeros(at.n_contacts, bool), np.zeros(len(at.tangent), bool)
    size = max(scale, 1e-300)
    E = (at.rows[chosen] * unit[chosen, None] / scales.arm).T
    load = -at.force / scales.arm / size
    if not chosen.any() or scale == 0.0:
        return SharedForces(p, unique, pressed, sticks) if np.abs(load).max(initial=0.0) <= BALANCED else None
    U, sizes, V = np.linalg.svd(E)
    rank = int((sizes > CUT * sizes[0]).sum())
    x = V[:rank].T @ ((U[:, :rank].T @ load) / sizes[:rank])
    if not np.abs(E @ x - load).max() <= BALANCED:
        return None
    N = V[rank:].T
    cones = _cones(at, chosen)
    bounds = np.zeros((0, len(x) + 1))
    found = _least(x, N, cones)
    if found is None:
        N, bounds = _nearly_open(x, sizes[:rank] / sizes[0], V)
        found = _least_within(x, N, cones, bounds)
    if found is None:
        return None
    x = found
    p[chosen] = x * unit[chosen] * size
    own_size = _lighter(at.rows[chosen], acting(p)) / size
    least = cones.sides(x) + PULLS[0] * cones.counted(own_size) + PULLS[1]
    if not (least >= 0.0).all():
        return None
    d = np.clip(own_size, LIGHT, 1.0)
    N = np.linalg.qr(N / d[:, None])[0] if len(bounds) else _orthonormal(N, E, d)
    ranges = _with_one(x / d, N, cones, bounds * np.append(d, 1.0))
    inside = _inside(*ranges)
    unique[chosen] = _unique(*ranges, inside)[: len(x)]
    k = np.flatnonzero(closed)
    pressed[k] = inside[: len(k)]
    rubbing = np.flatnonzero(closed[at.tangent])
    if at.d == 1:
        sides = inside[len(k) : len(k) + 2 * len(rubbing)].reshape(2, -1)
        sticks[rubbing] = sides[0] & sides[1]
    else:
        sticks[rubbing] = np.repeat(inside[len(inside) - len(rubbing) // 2 :], 2)
    return SharedForces(p, unique, pressed, sticks)


def could_stick(at: Configuration, scales: Scales, pressed: NDArray[np.bool_], p: FloatArray) -> NDArray[np.bool_]:
    """(m,) which tangents of ``pressed`` (n,) contacts are within the cone for some forces of the same effect as p.

    p (rows,): multipliers, of the largest force.
    """
    chosen = np.concatenate([np.ones(at.n_joint, bool), pressed, pressed[at.tangent]])
    _, sizes, V = np.linalg.svd((at.rows[chosen] / scales.arm).T)
    rank = int((sizes > CUT * sizes[0]).sum())
    inside = _inside(p[chosen], V[rank:].T, _cones(at, chosen))
    sticks, rubbing = np.zeros(len(at.tangent), bool), np.flatnonzero(pressed[at.tangent])
    sticks[rubbing] = np.repeat(inside[len(inside) - len(rubbing) // 2 :], 2)
    return sticks


def _lighter(rows: FloatArray, on: FloatArray) -> FloatArray:
    """(k,) of rows (k, ndof), the largest force on that of its bodies which bears less; on: (ndof,) of bodies."""
    least = np.where(rows != 0.0, on, np.inf).min(axis=1, initial=np.inf)
    return np.asarray(np.where(np.isfinite(least), least, on.max(initial=0.0)))


def _orthonormal(N: FloatArray, E: FloatArray, d: FloatArray) -> FloatArray:
    """The null space N of E in units d (k,) of its multipliers; each body is weighed by its lightest contact."""
    if not N.shape[1] or (d == 1.0).all():
        return N
    touched = np.where(E != 0.0, d, np.inf).min(axis=1, initial=np.inf)
    weights = np.where(np.isfinite(touched), touched, 1.0)
    _, sizes, V = np.linalg.svd(E * d / weights[:, None])
    rank = len(d) - N.shape[1]
    if int((sizes > CUT * sizes[0]).sum()) == rank:
        return np.asarray(V[rank:].T)
    return np.asarray(np.linalg.qr(N / d[:, None])[0])


def _cones(at: Configuration, chosen: NDArray[np.bool_]) -> Cones:
    """Of the multipliers of the rows ``chosen``: normals >= 0, then friction: in the plane both of its sides >= 0."""
    r, n = at.n_joint, at.n_contacts
    eye = np.eye(len(at.rows))[:, chosen]
    normals, tangents, limits = eye[r : r + n], eye[r + n :], at.friction[at.tangent, None] * eye[r + at.tangent]
    closed = np.abs(normals).sum(axis=1) > 0.0
    rubs = closed[at.tangent]
    if at.d == 1:
        sides = [(limits + tangents)[rubs], (limits - tangents)[rubs]]
        return Cones(np.vstack([normals[closed], *sides]), np.zeros((0, 3, len(eye[0]))))
    second = np.stack([limits[rubs][::2], tangents[rubs][::2], tangents[rubs][1::2]], axis=1)
    return Cones(normals[closed], second)


def _least(x: FloatArray, N: FloatArray, cones: Cones) -> FloatArray | None:
    """The shortest x + N y in the cones; None where there is none. x is at right angles to N."""
    if (cones.sides(x) >= -SLACK).all():
        return x
    if not N.shape[1]:
        return None
    if len(cones.second):
        y = shortest_in_cones(x, N, cones, SLACK)
        return np.asarray(x + N @ y) if y is not None and (cones.sides(x + N @ y) >= -ACTIVE).all() else None
    C = cones.linear
    G, h = C @ N, -(C @ x) - SLACK
    u, _ = nnls(np.vstack([G.T, h]), np.append(np.zeros(N.shape[1]), 1.0))
    left = np.append(G.T @ u, h @ u - 1.0)
    if not -left[-1] > 1e-9:
        return None
    y = -left[:-1] / left[-1]
    active = C @ (x + N @ y) <= ACTIVE
    exact = np.linalg.lstsq(G[active], -(C @ x)[active], rcond=CUT)[0]
    for trial in (exact, y):
        if (C @ (x + N @ trial) >= -ACTIVE).all():
            return np.asarray(x + N @ trial)
    return None


def _nearly_open(x: FloatArray, sizes: FloatArray, V: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Directions in which the balance does not tell forces to OPEN, and how far each is open: bounds (k, n + 1).

    x is a solution, and ``bounds`` are rows of ``bounds @ [x, 1] >= 0``. sizes: of the rows V, relative, where they
    have an effect; the other rows have none.
    """
    rank = len(sizes)
    first = int((sizes > KNOWN / OPEN).sum())
    ways, reach = V[first:rank], KNOWN / sizes[first:]
    there = ways @ x
    bounds = [np.column_stack([sign * ways, reach - sign * there]) for sign in (1.0, -1.0)]
    return V[first:].T, np.vstack(bounds)


def _with_one(x: FloatArray, N: FloatArray, cones: Cones, bounds: FloatArray) -> tuple[FloatArray, FloatArray, Cones]:
    """[x, 1], its null space and its cones, those of x and the bounds; as they are without bounds."""
    if not len(bounds):
        return x, N, cones
    return np.append(x, 1.0), np.vstack([N, np.zeros(N.shape[1])]), cones.with_one(bounds)


def _least_within(x: FloatArray, N: FloatArray, cones: Cones, bounds: FloatArray) -> FloatArray | None:
    """The nearest to x of x + N y in the cones and within the bounds; None where there is none."""
    if not len(bounds):
        return None
    found = _least(*_with_one(x, N, cones, bounds))
    return None if found is None else found[:-1]


def _unique(x: FloatArray, N: FloatArray, cones: Cones, inside: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Which entries of x are the same in all solutions; ``inside``: the sides that some solution keeps away from.

    The mean of several solutions keeps away from all of those, and may move as far as the other sides C_A let it:
    N y with C_A N y = 0.
    """
    unique = np.asarray(np.abs(N).max(axis=1, initial=0.0) <= SAME)
    if not N.shape[1]:
        return unique
    if len(cones.second):
        for i in np.flatnonzero(~unique) if not inside.all() else ():
            unique[i] = max(ends_in_cones(sign * N[i], x, N, cones, ACTIVE) for sign in (1.0, -1.0)) <= OPEN
        return unique
    _, sizes, V = np.linalg.svd(cones.linear[~inside] @ N)
    ways = N @ V[int((sizes > SAME).sum()) :].T
    return np.asarray(np.abs(ways).max(axis=1, initial=0.0) <= SAME)


def _inside(x: FloatArray, N: FloatArray, cones: Cones) -> NDArray[np.bool_]:
    """Which sides of cones some solution keeps away from."""
    inside = np.asarray(cones.sides(x) > OPEN)
    if not N.shape[1] or inside.all():
        return inside
    while not inside.all():  # one solution may use up at one contact what would do for several; the mean of all is in
        margins = _margins(x, N, cones, ~inside)
        more = inside | (margins > OPEN)
        if (more == inside).all():
            break
        inside = more
    return inside


def _margins(x: FloatArray, N: FloatArray, cones: Cones, wanted: NDArray[np.bool_]) -> FloatArray:
    """How far a solution is inside of each cone that is inside of many; 0 where none is found."""
    free, C = N.shape[1], cones.linear
    if len(cones.second):
        margins = margins_in_cones(x, N, cones, wanted, MARGIN, ACTIVE)
        return np.zeros(len(wanted)) if margins is None else margins
    found = linprog(
        np.append(np.zeros(free), -wanted.astype(float)),
        A_ub=np.hstack([-(C @ N), np.eye(len(C))]),
        b_ub=np.maximum(C @ x, 0.0) + ACTIVE,
        bounds=[(None, None)] * free + [(0.0, MARGIN)] * len(C),
    )
    return np.zeros(len(C)) if found.x is None else np.asarray(found.x[free:])
