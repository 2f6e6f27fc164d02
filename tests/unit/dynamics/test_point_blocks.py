"""Blocks of material points through the modes of their body, against products of whole matrices."""

from __future__ import annotations

import numpy as np
import pytest

from lcpflex.dynamics.spatial.point_blocks import (
    PointBlocks,
    block_of,
    has_blocks,
    point_blocks,
    touching_points,
    weigh_modes,
)
from lcpflex.jit.kernel import FloatArray
from lcpflex.jit.struct import pack
from lcpflex.model.arrays import frozen
from lcpflex.model.spatial import SpatialBodies, SpatialPoints, SpatialPointTable, no_spatial_contacts
from tests.space import bodies_of

MODES = (5, 0, 3)  # of three bodies
POINTS = 4  # of each, one after the other


class Case:
    """Three bodies with points of random shapes, and blocks of some of them with random weights."""

    def __init__(self, room: int = 1000) -> None:
        rng = np.random.default_rng(7)
        self.bodies: SpatialBodies = pack(bodies_of(MODES))
        table = SpatialPointTable()
        self.shapes = [rng.normal(size=(n, 3)) for n in MODES for _ in range(POINTS)]
        for p, phi in enumerate(self.shapes):
            table.add(p // POINTS, rng.normal(size=3), phi, np.zeros_like(phi))
        self.points: SpatialPoints = pack(table.compile())
        self.blocks: PointBlocks = point_blocks(self.bodies, self.points, np.array([0, 2, 3, 5, 8, 11, 3]), room)
        self.weight = rng.uniform(0.5, 2.0, sum(MODES))

    def weigh(self, b: int, weight: FloatArray) -> bool:
        return weigh_modes(self.blocks, b, weight, sum(MODES[:b]))

    def product(self, p: int, r: int) -> FloatArray:
        first = {0: 0, 1: 5, 2: 5}[p // POINTS]
        own = self.weight[first : first + MODES[p // POINTS]]
        return np.asarray(self.shapes[p].T @ (own[:, None] * self.shapes[r]))

    def block(self, p: int, r: int) -> FloatArray:
        return np.reshape(block_of(self.blocks, p, r), (3, 3))


def test_blocks_are_products_of_the_shapes() -> None:
    """Of all pairs, in either order, the first time and again; bodies without modes and other points have none."""
    case = Case()
    assert [bool(has_blocks(case.blocks, p)) for p in range(12)] == [p in (0, 2, 3, 8, 11) for p in range(12)]
    for b in (0, 2):
        case.weigh(b, case.weight)
        assert case.weigh(b, case.weight)
    for own in ((0, 2, 3), (8, 11)):
        for p in own:
            for r in own:
                for _ in range(2):
                    np.testing.assert_allclose(case.block(p, r), case.product(p, r), rtol=1e-13, atol=1e-14)
                if p != r:
                    np.testing.assert_array_equal(case.block(p, r), case.block(r, p).T)


def test_other_weights_make_other_blocks() -> None:
    """Weights that come once are not used; those that come twice are, and others of another body change nothing."""
    case = Case()
    for b in (0, 2):
        case.weigh(b, case.weight)
        assert case.weigh(b, case.weight)
    before, apart = case.block(0, 2), case.block(8, 11)
    case.weight[:5] *= 2.0
    assert not case.weigh(0, case.weight)
    assert case.weigh(0, case.weight)
    np.testing.assert_allclose(case.block(0, 2), 2.0 * before, rtol=1e-13, atol=1e-14)
    assert case.weigh(2, case.weight)
    np.testing.assert_array_equal(case.block(8, 11), apart)


@pytest.mark.parametrize(("room", "some"), [(9, True), (6, True), (5, False)])
def test_bodies_that_need_more_room_have_none(room: int, some: bool) -> None:
    """Three points need six blocks, two three."""
    case = Case(room)
    assert bool(has_blocks(case.blocks, 0)) is some
    assert bool(has_blocks(case.blocks, 8)) is (room != 6)


def test_points_that_may_touch() -> None:
    """Nodes and features of the surfaces of passes, and of those under a rule; of others none."""
    contacts = no_spatial_contacts()._replace(
        node_start=frozen([0, 2, 4, 5], np.int64),
        node_point=frozen([3, 4, 0, 1, 7], np.int64),
        feature_start=frozen([0, 0, 1, 2], np.int64),
        feature_point=frozen([[8, 9, 8], [5, 6, 5]], np.int64, columns=3),
        pass_node=frozen([0], np.int64),
        pass_feature=frozen([2], np.int64),
    )
    assert touching_points(contacts).tolist() == [3, 4, 5, 6, 7]
    assert touching_points(contacts._replace(rule_rank=frozen([0, 0], np.int64))).tolist() == [
        0,
        1,
        3,
        4,
        5,
        6,
        7,
        8,
        9,
    ]
    assert touching_points(no_spatial_contacts()).tolist() == []
