"""What a displacement in space moves, in words."""

from __future__ import annotations

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.jit.struct import pack
from lcpflex.statics.scales import scales_of
from lcpflex.statics.words import what_moves

QUARTER = np.sqrt(0.5)


@pytest.mark.parametrize(
    ("motion", "words"),
    [
        ((0.0, 0.0, -2.0, 0.0, 0.0, 0.0), "'body' moves along (0, 0, -1)"),
        ((0.3, 0.0, 0.4, 0.0, 0.0, 0.0), "'body' moves along (0.6, 0, 0.8)"),
        # omega is about the z axis of the body, which is turned to -y of the world
        ((0.0, 0.0, 0.0, 0.0, 0.0, 2.0), "'body' turns about (0, -1, 0) through (1, 2, 3) m"),
        ((0.0, 0.0, 2.0, 0.0, 0.0, 2.0), "'body' turns about (0, -1, 0) through (0, 2, 3) m"),
        ((0.0, -0.5, 2.0, 0.0, 0.0, 2.0), "'body' turns about (0, -1, 0) through (0, 2, 3) m, 0.25 m/rad along it"),
    ],
)
def test_ways_of_a_body(motion: tuple[float, ...], words: str) -> None:
    scene = lf.SpatialScene()
    scene.add(lf.Cuboid(0.4, 0.3, 0.2, mass=1.0), "body", position=(1.0, 2.0, 3.0))
    compiled = scene.compile()
    q = np.array([1.0, 2.0, 3.0, QUARTER, QUARTER, 0.0, 0.0])
    scales = scales_of(pack(compiled.model), q, compiled.size)
    assert what_moves(("body",), compiled.model, scales, q, np.array(motion)) == words


def test_arms_are_distances_from_the_axes() -> None:
    scene = lf.SpatialScene()
    scene.add(lf.Cuboid(0.4, 0.3, 0.2, mass=1.0), "body")
    compiled = scene.compile()
    found = scales_of(pack(compiled.model), compiled.q.copy(), compiled.size)
    inertia = np.array([0.3**2 + 0.2**2, 0.4**2 + 0.2**2, 0.4**2 + 0.3**2]) / 12.0
    corner = np.sqrt([0.15**2 + 0.1**2, 0.2**2 + 0.1**2, 0.2**2 + 0.15**2])
    assert found.arm[:3] == pytest.approx([1.0] * 3)
    for arm, gyration, far in zip(found.arm[3:], np.sqrt(inertia), corner, strict=True):
        assert arm in (pytest.approx(gyration), pytest.approx(far))
