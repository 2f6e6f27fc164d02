"""Surfaces of solids of revolution, of which the half section is meshed: the solid goes on beyond the axis."""

from __future__ import annotations

import numpy as np
import pytest

import lcpflex as lf
from lcpflex import gallery
from lcpflex.bodies.surface import whole_section
from lcpflex.contact.detection import contact_table, detect
from lcpflex.jit.struct import pack


def test_whole_section_of_a_half():
    half = np.array([(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0)])  # a cylinder, its axis with a node
    whole = whole_section(half)
    np.testing.assert_array_equal(whole, [(2, 0), (2, 1), (0, 1), (0, 0), (0, -1), (2, -1)])
    for k in range(len(half)):  # wherever the loop begins
        turned = whole_section(np.roll(half, k, axis=0))
        np.testing.assert_array_equal(turned, whole)
    ring = half + np.array([0.0, 0.5])
    np.testing.assert_array_equal(whole_section(ring), ring)
    x, y = whole.T
    assert 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) == 4.0  # counter-clockwise


@pytest.mark.parametrize("aside", [0.0, 1e-12, -1e-12, -1e-6])
def test_no_node_falls_beside_the_axis_of_a_solid_of_revolution(aside):
    """The face of a rod ends on its axis, but the solid goes on: rounding may move a node there to the other side."""
    scene = lf.Scene()
    rod = scene.add(gallery.meshed_rod(4e-4, modes=2), "rod")
    tip = scene.add(lf.RigidBody(mass=1.0, inertia=1.0), position=(-1.0, 0.0))
    scene.join(lf.Prismatic(rod.point("far"), scene.ground.at(1.0, 0.0), axis=(1.0, 0.0)))
    face = rod.surface("tip")
    scene.contact(tip.node(0.0, 0.0), face)
    compiled = scene.compiled()
    q = compiled.q.copy()
    first = compiled.model.bodies.dof[1]
    q[first : first + 2] = (1e-6, aside)
    table = contact_table(8, len(compiled.model.contacts.surface_body))
    n = detect(pack(compiled.model), q, 1e-9, table)
    assert n == 1
    np.testing.assert_allclose(table.normal[0], (-1.0, 0.0), atol=1e-15)
    assert table.gap[0] == pytest.approx(-1e-6, rel=1e-9)
