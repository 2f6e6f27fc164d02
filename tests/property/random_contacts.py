"""Random contact problems of rigid bodies in plane and space, and a judge of forces that shares no code with a solver.

v = free + J J^T p, the rows of J over the roots of the masses. A problem has 2 to 60 contacts at random places of
random bodies, coefficients up to 3; in some, masses spread over six decades, contacts are there three times, bodies are
pinned to one another, or gaps are left. Every one has a solution: ``free`` is J u of a motion u of the bodies, with
normal velocities raised by gaps, so that forces that leave all bodies at rest, J^T p = 0, have no negative power on it
(Anitescu & Potra 1997; in space Acary, Cadoux, Lemarechal & Malick 2011).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

__all__ = ["Drawn", "draw", "miss"]

FloatArray = npt.NDArray[np.float64]
LARGEST = 60  # contacts
DECADES = 6.0  # of masses that differ


@dataclass(frozen=True)
class Drawn:
    """Rows S k ... S k + S - 1 are the normal and the tangents of contact k, S the dimension; those of pins follow."""

    dimension: int
    seed: int
    kind: str  # what makes it hard
    bodies: int
    white: FloatArray  # (rows, 2, width): of the first and the second body of a row, over the roots of their masses
    body: npt.NDArray[np.int64]  # (rows, 2), -1: the ground
    free: FloatArray  # (rows,)
    terms: FloatArray  # (rows,) sum of the sizes of what free is made of
    friction: FloatArray  # (contacts,)

    @property
    def of_contacts(self) -> int:
        """Rows of contacts."""
        return self.dimension * len(self.friction)

    @cached_property
    def J(self) -> FloatArray:
        """(rows, velocities)."""
        width = self.white.shape[2]
        out = np.zeros((len(self.free), width * self.bodies))
        for r, i in zip(*np.nonzero(self.body >= 0), strict=True):
            out[r, width * self.body[r, i] :][:width] += self.white[r, i]
        return out

    @cached_property
    def condensed(self) -> tuple[FloatArray, FloatArray]:
        """J and free of the contacts alone, of bodies that move as their pins let them."""
        contacts, pins = np.split(self.J, [self.of_contacts])
        own, held = np.split(self.free, [self.of_contacts])
        if not len(pins):
            return contacts, own
        Q, R = np.linalg.qr(pins.T)
        along = contacts @ Q
        return contacts - along @ Q.T, own - along @ np.linalg.solve(R.T, held)


def draw(dimension: int, seed: int) -> Drawn:
    """Problem number ``seed`` of the plane or of space."""
    rng = np.random.default_rng([dimension, seed])
    n = int(rng.integers(2, LARGEST + 1))
    bodies = max(2, round(n * rng.uniform(0.1, 1.0)))
    spread, threefold, pinned, apart = rng.random(4) < (0.6, 0.4, 0.2, 0.3)
    place = np.repeat(np.arange(n), np.where(threefold & (rng.random(n) < 0.5), 3, 1))[:n]
    most = float(rng.choice([0.5, 1.0, 3.0, 3.0]))
    mu = np.where(rng.random(n) < 0.15, 0.0, rng.uniform(0.0, most, n))[place]
    white, body = _contact_rows(rng, dimension, bodies, n)
    rows = (dimension * place[:, None] + np.arange(dimension)).ravel()
    white, body = white[rows], body[rows]
    if pinned:
        pins = _pin_rows(rng, dimension, bodies, int(rng.integers(1, bodies)))
        white, body = np.concatenate([white, pins[0]]), np.concatenate([body, pins[1]])
    mass = 10.0 ** (DECADES * rng.uniform(-0.5, 0.5, bodies) if spread else np.zeros(bodies))
    inertia = mass[:, None] * rng.uniform(0.1, 0.5, (bodies, white.shape[2] - dimension))
    root = np.sqrt(np.hstack([np.repeat(mass[:, None], dimension, axis=1), inertia]))
    products = white * rng.standard_normal((bodies, white.shape[2]))[body] * (body >= 0)[:, :, None]
    free = products.sum(axis=(1, 2))
    gaps = np.where(rng.random(n) < 0.3 * apart, rng.exponential(1.0, n), 0.0)[place]
    free[: dimension * n : dimension] += gaps
    kinds = zip(("masses", "threefold", "pins", "gaps"), (spread, threefold, pinned, apart), strict=True)
    return Drawn(
        dimension, seed, " ".join([f"mu {most:g}", *(name for name, there in kinds if there)]), bodies,
        white / root[body], body, free, np.abs(products).sum(axis=(1, 2)), mu,
    )  # fmt: skip


def _contact_rows(rng: np.random.Generator, dimension: int, bodies: int, n: int) -> tuple[FloatArray, Any]:
    """Rows of n contacts in velocities of the bodies, and their bodies; three in ten are with the ground."""
    body = np.array([rng.choice(bodies, 2, replace=False) for _ in range(n)])
    body[rng.random(n) < 0.3, 1] = -1
    axes = np.linalg.qr(rng.standard_normal((n, dimension, dimension)))[0]
    return _rows(axes, rng.uniform(-1.0, 1.0, (n, 2, dimension)), body)


def _pin_rows(rng: np.random.Generator, dimension: int, bodies: int, count: int) -> tuple[FloatArray, Any]:
    """Rows of pins, or balls in their sockets, between bodies next to each other: no closed chain."""
    own = np.sort(rng.choice(np.arange(1, bodies), count, replace=False))
    axes = np.tile(np.eye(dimension), (count, 1, 1))
    return _rows(axes, rng.uniform(-1.0, 1.0, (count, 2, dimension)), np.column_stack([own, own - 1]))


def _rows(axes: FloatArray, arms: FloatArray, body: Any) -> tuple[FloatArray, Any]:
    """A row for each axis (n, S, S) at arms (n, 2, S): the direction, and its moment about the centre of the body."""
    n, dimension, _ = axes.shape
    arm = np.broadcast_to(arms[:, :, None, :], (n, 2, dimension, dimension))
    axis = np.broadcast_to(axes[:, None, :, :], arm.shape)
    if dimension == 2:
        moment = (arm[..., 0] * axis[..., 1] - arm[..., 1] * axis[..., 0])[..., None]
    else:
        moment = np.cross(arm, axis)
    sign = np.array([1.0, -1.0]) * (body >= 0)
    rows = np.concatenate([axis, moment], axis=-1) * sign[:, :, None, None]
    return rows.transpose(0, 2, 1, 3).reshape(n * dimension, 2, -1), np.repeat(body, dimension, axis=0)


def miss(drawn: Drawn, forces: FloatArray, W: FloatArray | None = None) -> float:
    """What the forces leave of the natural map of Coulomb's law, relative to the load.

        r - P_K(r - (u + mu |u_T| n)),  u = free + W r,  K the cone |r_T| <= mu r_N

    Of each contact in units in which the largest diagonal entry of its block of W is 1; the load is the largest free
    velocity in them. Forces are those of the contacts alone, their pins condensed, W = J J^T where none is given; or
    those of all rows: then u of the pins is missed as well, each row in its own units. In long double; inf for what is
    not finite.
    """
    J, free = (drawn.J, drawn.free) if len(forces) > drawn.of_contacts else drawn.condensed
    own = (J**2).sum(axis=1) if W is None else np.diag(W).copy()
    contacts = slice(0, drawn.of_contacts)
    own[contacts] = np.repeat(own[contacts].reshape(-1, drawn.dimension).max(axis=1), drawn.dimension)
    unit, r = 1.0 / np.sqrt(own), forces.astype(np.longdouble)
    moved = J.astype(r.dtype) @ (J.T.astype(r.dtype) @ r) if W is None else W.astype(r.dtype) @ r
    y, q = (moved + free) * unit, r / unit
    u, p = (part[contacts].reshape(-1, drawn.dimension) for part in (y, q))
    x = p - u
    x[:, 0] -= drawn.friction * np.sqrt((u[:, 1:] ** 2).sum(axis=1))
    worst = max(np.abs(p - _nearest(x, drawn.friction)).max(), np.abs(y[drawn.of_contacts :]).max(initial=0.0))
    return float(worst / np.abs(free * unit).max()) if np.isfinite(q).all() else np.inf


def _nearest(x: Any, friction: FloatArray) -> Any:
    """The points of the cones |r_T| <= mu r_N nearest to x (n, S)."""
    normal, size = x[:, 0], np.sqrt((x[:, 1:] ** 2).sum(axis=1))
    onto = np.maximum(normal + friction * size, 0.0) / (1.0 + friction**2)  # the normal force on the surface
    share = np.where(size > 0.0, friction * onto / np.where(size > 0.0, size, 1.0), 0.0)
    surface = np.column_stack([onto, x[:, 1:] * share[:, None]])
    return np.where((size <= friction * normal)[:, None], x, surface)
