"""Entries of contact tables in space, made by hand: features of two bodies (or the ground) that turn and deform."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from lcpflex.contact.spatial.pairs import contact_bias, contact_point, contact_rows, locate, refresh
from lcpflex.contact.spatial.table import (
    EDGE_CAP,
    EDGE_EDGE,
    EDGE_RIM,
    EDGE_SIDE,
    NODE_CAP,
    NODE_EDGE,
    NODE_FACET,
    NODE_POINT,
    NODE_RIM,
    NODE_SIDE,
    RIM_FACET,
    RIM_RIM,
    spatial_contact_table,
)
from lcpflex.jit.kernel import FloatArray
from lcpflex.jit.struct import pack
from lcpflex.kinematics.spatial.configuration import advance
from lcpflex.kinematics.spatial.points import point_axes, point_place
from lcpflex.model.spatial import SpatialModel, SpatialPointTable
from tests.space import Moving, model_of

__all__ = ["ENDS", "Pair", "pair"]

ENDS = {NODE_FACET: (1, 3), NODE_EDGE: (1, 2), NODE_POINT: (1, 1), EDGE_EDGE: (2, 2), RIM_FACET: (2, 3)}
ENDS |= {
    NODE_SIDE: (1, 2),
    NODE_CAP: (1, 2),
    NODE_RIM: (1, 2),
    EDGE_SIDE: (2, 2),
    EDGE_RIM: (2, 2),
    EDGE_CAP: (2, 2),
    RIM_RIM: (2, 2),
}

EDGES = (EDGE_SIDE, EDGE_RIM, EDGE_CAP)


@dataclass(slots=True)
class Pair:
    """Entry 0 of a table, its model and a state."""

    moving: Moving
    table: Any
    plain: SpatialModel  # not packed

    def at(self, q: FloatArray) -> None:
        refresh(self.moving.model, q, self.table, 0)

    def gap(self, q: FloatArray) -> float:
        self.at(q)
        return float(self.table.gap[0])

    def blocks(self, q: FloatArray) -> FloatArray:
        """(3, 2, width) along n, t1, t2, body i and body j; they must overwrite what is there."""
        self.at(q)
        rows = np.full((3, 2, int(np.max(np.diff(self.moving.model.bodies.dof)))), 7.0)
        contact_rows(self.moving.model, q, self.table, 0, rows[0], rows[1:])
        return rows

    def rows(self, q: FloatArray) -> FloatArray:
        """(3, nu) W^T along n, t1, t2."""
        dof, blocks = self.moving.model.bodies.dof, self.blocks(q)
        rows = np.zeros((3, int(dof[-1])))
        for side in range(2):
            b = int(self.table.body[0, side])
            if b >= 0:
                rows[:, dof[b] : dof[b + 1]] += blocks[:, side, : dof[b + 1] - dof[b]]
            else:
                assert not blocks[:, side].any()
        return rows

    def bias(self, q: FloatArray, u: FloatArray) -> FloatArray:
        """(3,) w along n, t1, t2."""
        self.at(q)
        return np.array(contact_bias(self.moving.model, q, u, self.table, 0))

    def axes(self) -> FloatArray:
        """(3, 3) n, t1, t2."""
        n, t = self.table.normal[0].copy(), self.table.tangent[0].copy()
        return np.stack([n, t, np.cross(n, t)])

    def frozen(self, q: FloatArray) -> Any:
        """A function of configurations: r_i - r_j of the material that touches at q, carried along by the bodies."""
        self.at(q)
        i, j = ENDS[int(self.table.kind[0])]
        point, foot, n = self.table.point[0], self.table.foot[0].copy(), self.table.normal[0].copy()
        sides = [
            (point[:1], [1.0], self.lever(q, n)),
            (point[i : i + j], [1.0 - foot.sum(), *foot][:j], self.table.radius[0, 1] * n),
        ]
        kind = int(self.table.kind[0])
        if kind == NODE_POINT:
            sides[1] = (point[1:2], [1.0], sides[1][2])
        elif kind in (NODE_SIDE, NODE_CAP, NODE_RIM):
            sides[1] = (point[1:2], [1.0], self.on_cylinder(q, self.place(q, int(point[0]))))
        elif kind in EDGES:
            sides[0] = (point[:2], [1.0 - foot[0], foot[0]], sides[0][2])
            nearest = (1.0 - foot[0]) * self.place(q, int(point[0])) + foot[0] * self.place(q, int(point[1]))
            sides[1] = (point[2:3], [1.0], self.on_cylinder(q, nearest))
        elif kind == RIM_RIM:
            place = np.array(contact_point(self.moving.model, q, self.table, 0))
            sides[0] = (point[:1], [1.0], place - self.place(q, int(point[0])))
            sides[1] = (point[2:3], [1.0], place - self.table.gap[0] * n - self.place(q, int(point[2])))
        elif kind == NODE_EDGE:
            sides[1] = (point[1:3], [1.0 - foot[0], foot[0]], sides[1][2])
        elif kind == EDGE_EDGE:
            sides[0] = (point[:2], [1.0 - foot[0], foot[0]], sides[0][2])
            sides[1] = (point[2:4], [1.0 - foot[1], foot[1]], sides[1][2])
        else:
            sides[1] = (sides[1][0], sides[1][1], np.zeros(3))
        now = [[self.turned(q, p) for p in points] for points, _, _ in sides]

        def between(at: FloatArray) -> FloatArray:
            places = []
            for (points, weights, lever), before in zip(sides, now, strict=True):
                places.append(
                    sum(
                        w * (np.array(self.place(at, p)) + self.turned(at, p) @ turned.T @ lever)
                        for p, w, turned in zip(points, weights, before, strict=True)
                    )
                )
            return np.asarray(places[0] - places[1])

        return between

    def lever(self, q: FloatArray, n: FloatArray) -> FloatArray:
        """From the node, edge or centre of body i to where it touches."""
        lever = -self.table.radius[0, 0] * n
        if self.table.kind[0] == RIM_FACET:
            points, (o, x) = self.moving.model.points, self.table.point[0, :2]
            a = self.turned(q, o) @ (points.place[x] - points.place[o])
            a /= np.linalg.norm(a)
            m = n - (n @ a) * a
            lever = lever - self.table.radius[0, 2] * m / np.linalg.norm(m)
        return np.asarray(lever)

    def on_cylinder(self, q: FloatArray, there: FloatArray) -> FloatArray:
        """From the start of a cylinder to the place of its side, end or rim that is nearest to another place."""
        kind, R = int(self.table.kind[0]), self.table.radius[0, 2]
        points, (o, x) = (
            self.moving.model.points,
            self.table.point[0, 2:4] if kind in EDGES else self.table.point[0, 1:3],
        )
        axis = points.place[x] - points.place[o]
        a = self.turned(q, o) @ axis / np.linalg.norm(axis)
        y = there - self.place(q, o)
        z, across = a @ y, y - (a @ y) * a
        end = float(np.linalg.norm(axis)) if self.table.sense[0] > 0.0 else 0.0
        around = R * across / np.linalg.norm(across)
        nearest = {NODE_SIDE: z * a + around, NODE_CAP: end * a + across, NODE_RIM: end * a + around}
        nearest |= {
            EDGE_SIDE: z * a + R * self.table.normal[0],
            EDGE_RIM: nearest[NODE_RIM],
            EDGE_CAP: nearest[NODE_CAP],
        }  # whatever its sense
        return np.asarray(nearest[kind])

    def place(self, q: FloatArray, p: int) -> FloatArray:
        return np.array(point_place(self.moving.model.bodies, self.moving.model.points, q, p))

    def turned(self, q: FloatArray, p: int) -> FloatArray:
        return np.reshape(point_axes(self.moving.model.bodies, self.moving.model.points, q, p), (3, 3))


def pair(
    kind: int,
    seed: int,
    modes: tuple[int, int] = (3, 2),
    grounded: int = -1,
    radius: npt.ArrayLike = (0.0, 0.0, 0.0),
    sense: float = 1.0,
) -> Pair:
    """Features anywhere on two bodies that are anywhere and move anyhow; those of ``grounded`` on the ground."""
    random = np.random.default_rng(seed)
    points = SpatialPointTable()
    for end in range(2):
        n = 0 if end == grounded else modes[end]
        for _ in range(ENDS[kind][end]):
            points.add(
                -1 if end == grounded else end,
                random.uniform(-1, 1, 3),
                0.3 * random.standard_normal((n, 3)),
                0.3 * random.standard_normal((n, 3)),
            )
    plain = model_of(modes, points)
    model = pack(plain)
    q = np.zeros(14 + sum(modes))
    q[model.bodies.place[:-1] + 3] = 1.0
    advance(model, q, random.standard_normal(12 + sum(modes)), 1.0, q)
    table = pack(spatial_contact_table(1))
    table.kind[0] = kind
    table.point[0, : sum(ENDS[kind])] = np.arange(sum(ENDS[kind]))
    table.node[0] = 0
    table.radius[0] = radius
    table.sense[0] = sense
    table.along[0] = -1
    table.body[0] = [-1 if end == grounded else end for end in range(2)]
    made = Pair(Moving(model, q, random.standard_normal(12 + sum(modes))), table, plain)
    locate(made.moving.model, made.moving.q, made.table, 0)  # as detection does
    return made
