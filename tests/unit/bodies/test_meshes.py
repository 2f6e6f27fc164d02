"""Meshes of simple shapes: sizes, names, grading towards a contact, curved edges; two of them that collide."""

from __future__ import annotations

import math

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.bodies.continuum import Continuum
from lcpflex.bodies.fem import grading as mesh_grading, meshes
from lcpflex.bodies.solid_of_revolution import SolidOfRevolution
from tests import libs

STEEL = (7800.0, 2e11, 0.3)


def edges_of(mesh):
    """(m, 3) lengths of the edges of triangles, and (m,) their areas."""
    corners = mesh.p[:, mesh.t]
    arms = np.roll(corners, -1, axis=1) - corners
    area = 0.5 * np.abs(arms[0, 0] * arms[1, 1] - arms[1, 0] * arms[0, 1])
    return np.hypot(*arms).T, area


@pytest.mark.parametrize("triangles", [True, False])
def test_rectangles_and_bars(triangles):
    mesh = meshes.bar(2.0, 0.1, 20, across=3, triangles=triangles)
    assert type(mesh).__name__ == ("MeshTri2" if triangles else "MeshQuad2")
    assert type(meshes.bar(2.0, 0.1, 20, triangles=triangles, order=1)).__name__[:-1] == type(mesh).__name__[:-1]
    assert mesh.p.min(axis=1) == pytest.approx([0.0, -0.05])
    assert mesh.p.max(axis=1) == pytest.approx([2.0, 0.05])
    assert mesh.nelements == 20 * 3 * (1 + triangles)
    assert {name: len(facets) for name, facets in mesh.boundaries.items()} == {
        "left": 3, "right": 3, "bottom": 20, "top": 20,
    }  # fmt: skip
    lines = np.array([0.0, 0.1, 0.3, 0.9])
    assert np.unique(meshes.grid(lines, lines, triangles=triangles, order=1).p[0]) == pytest.approx(lines)


@pytest.mark.parametrize("quadratic", [False, True])
def test_a_ring_is_round(quadratic):
    body = Continuum(meshes.ring(0.8, 1.0, 24, 2, order=1 + quadratic), *STEEL).reduce(0)
    places = np.array([point.place for point in body.surfaces["outer"].points])
    assert np.hypot(*places.T) == pytest.approx(1.0)
    assert len(places) == 24 * (1 + quadratic)
    chords = math.sin(2 * math.pi / 24) / (2 * math.pi / 24)  # area of the polygon against that of the circle
    assert body.mass == pytest.approx(7800.0 * math.pi * 0.36 * (1.0 if quadratic else chords), rel=2e-5)
    assert sorted(body.surfaces) == ["hole1", "inner", "outer", "outline"]


@pytest.mark.parametrize("make", [meshes.half_disc, meshes.half_section_of_sphere])
@pytest.mark.parametrize("quadratic", [False, True])
def test_half_rounds_are_fine_at_their_pole_only(make, quadratic):
    R, finest, within = 0.015, 1e-4, 4e-4
    mesh = make(R, 0.003, finest=finest, within=within, order=1)
    pole = np.array([0.0, -R]) if make is meshes.half_disc else np.array([R, 0.0])
    lengths, area = edges_of(mesh)
    distance = np.hypot(*(mesh.p[:, mesh.t] - pole[:, None, None])).min(axis=0)
    longest = lengths.max(axis=1)
    assert (longest <= np.minimum(0.003, finest + 0.2 * np.maximum(distance - within, 0.0)) * 1.001).all()
    assert longest[distance == 0.0].size
    assert longest[distance > 0.8 * R].min() > 5.0 * finest
    assert (4.0 * math.sqrt(3.0) * area / (lengths**2).sum(axis=1)).min() > 0.3  # 1: equal sides
    assert mesh.nvertices < 1500
    boundary = mesh.p[:, mesh.facets[:, mesh.boundaries["round"]]]
    assert np.hypot(*boundary).ravel() == pytest.approx(R, rel=1e-12)
    curved = make(R, 0.003, finest=finest, within=within, order=1 + quadratic)
    body = Continuum(curved, *STEEL).reduce(0)
    assert body.mass == pytest.approx(7800.0 * 0.5 * math.pi * R**2, rel=1e-6 if quadratic else 5e-3)


def test_a_sphere_and_a_rod_fine_enough_for_hertz_stay_small():
    """0.05 mm where they touch, a few mm elsewhere."""
    sphere = meshes.half_section_of_sphere(0.015, 0.003, finest=5e-5, within=3e-4)
    rod = meshes.half_section_of_rod(1.0, 0.01, 0.005, finest=5e-5, within=3e-4)
    for mesh, pole in ((sphere, (0.015, 0.0)), (rod, (0.0, 0.0))):
        near = np.hypot(*(mesh.p - np.array(pole)[:, None])) <= 3e-4
        assert near.sum() >= 20
        assert mesh.nvertices < 2500
        assert edges_of(mesh)[0].max() <= 0.005
    body = SolidOfRevolution(rod, *STEEL).reduce(1)
    assert body.mass == pytest.approx(7800.0 * math.pi * 1e-4, rel=1e-10)
    assert body.frequencies()[0] == pytest.approx(math.pi * math.sqrt(2e11 / 7800.0), rel=1e-3)


def test_grading_towards_a_line_keeps_names_and_shape():
    coarse = meshes.rectangle(1.0, 0.5, 8, 4, triangles=True)
    mesh = meshes.graded(coarse, [(0.4, 0.5), (0.6, 0.5)], 0.01, within=0.02)
    lengths, area = edges_of(mesh)
    assert area.sum() == pytest.approx(0.5, rel=1e-12)
    middle = mesh.p[:, mesh.t].mean(axis=1)
    on_line = (np.abs(middle[0] - 0.5) < 0.1) & (middle[1] > 0.48)
    assert lengths[on_line].max() <= 0.01 * (1 + 1e-9)
    assert lengths.max() > 0.08
    for name, side in coarse.boundaries.items():
        ends, fine = coarse.p[:, coarse.facets[:, side]], mesh.p[:, mesh.facets[:, mesh.boundaries[name]]]
        whole = np.hypot(*(ends[:, 1] - ends[:, 0])).sum()
        assert np.hypot(*(fine[:, 1] - fine[:, 0])).sum() == pytest.approx(whole, rel=1e-12)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: meshes.rectangle(0.0, 1.0, 1, 1), "length: 0.0"),
        (lambda: meshes.rectangle(1.0, float("inf"), 1, 1), "height: inf"),
        (lambda: meshes.rectangle(1.0, 1.0, 0, 1), "nx: 0"),
        (lambda: meshes.rectangle(1.0, 1.0, 1, 1.5), "ny: 1.5"),
        (lambda: meshes.grid([0.0], [0.0, 1.0]), "x: .*two ascending"),
        (lambda: meshes.grid([0.0, 1.0], [0.0, 1.0, 1.0]), "y: .*two ascending"),
        (lambda: meshes.bar(1.0, -1.0, 3), "height: -1.0"),
        (lambda: meshes.bar(1.0, "thin", 3), "height: 'thin'"),
        (lambda: meshes.ring(1.0, 0.9, 8, 1), "outer: 0.9"),
        (lambda: meshes.ring(0.5, 0.9, 2, 1), "around: 2"),
        (lambda: meshes.half_disc(-1.0, 0.1), "radius: -1.0"),
        (lambda: meshes.half_disc(1.0, 0.1, finest=0.2), "finest: 0.2"),
        (lambda: meshes.half_disc(1.0, 0.1, finest=0.0), "finest: 0.0"),
        (lambda: meshes.half_disc(1.0, 0.1, finest=0.01, within=-1.0), "within: -1.0"),
        (lambda: meshes.half_section_of_rod(1.0, 0.1, 0.0), "size: 0.0"),
        (lambda: meshes.graded(meshes.rectangle(1.0, 1.0, 2, 2), (0.0, 0.0), 0.1), "MeshQuad2 was given"),
        (lambda: meshes.graded(libs.skfem.MeshTri(), (0.0, 0.0), 0.1, growth=2.0), "growth: 2.0"),
        (lambda: meshes.graded(libs.skfem.MeshTri(), (0.0, 0.0, 0.0), 0.1), "towards"),
        (lambda: meshes.graded(libs.skfem.MeshTri(), "corner", 0.1), "towards"),
        (lambda: meshes.bar(1.0, 0.1, 3, order=3), "order: 3 was given"),
        (lambda: meshes.ring(0.5, 1.0, 8, 1, order=0), "order: 0 was given"),
        (lambda: meshes.half_disc(1.0, 0.1, order="linear"), "order: 'linear' was given"),
        (lambda: meshes.graded(meshes.half_disc(1.0, 0.3), (0.0, -1.0), 0.1), "an edge is curved at"),
        (lambda: meshes.quadratic(libs.skfem.MeshTet()), "MeshTet1 was given"),
        (lambda: meshes.quadratic(None), "NoneType was given"),
    ],
)
def test_shapes_that_cannot_be(make, said):
    with pytest.raises(lf.ModelError, match=said):
        make()


def test_a_mesh_without_end_is_refused(monkeypatch):
    monkeypatch.setattr(mesh_grading, "ELEMENTS", 5000)
    with pytest.raises(lf.ModelError, match="finest: 1e-09 m was given, expected a mesh of less than"):
        meshes.graded(libs.skfem.MeshTri(), [(0.0, 0.0), (1.0, 0.0)], 1e-9, growth=1.0)


def test_two_meshes_that_collide_keep_their_momentum():
    """Nodes of each against edges of the other, both flexible, one of triangles and one of quadratic quadrilaterals."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    grid = meshes.rectangle(0.1, 0.06, 3, 2).translated((-0.05, -0.03))  # about the mass centre: momentum is m v
    block = Continuum(grid, *STEEL, thickness=0.01).reduce(6)
    grid = meshes.rectangle(0.05, 0.04, 3, 3, triangles=True).translated((-0.025, -0.02))
    striker = Continuum(grid, *STEEL, thickness=0.01).reduce(6)
    still = scene.add(block, "block")
    moving = scene.add(striker, "striker", position=(-0.0751, 0.003), velocity=(2.0, 0.3))
    scene.contact(moving.surface("right"), still.surface("left"))
    result = lf.simulate(scene, 2e-4, stepper=lf.MoreauJean(step=1e-7))
    assert result.force[:, :, 0].max() > 0.0
    momentum = block.mass * result.u[:, 0:2] + striker.mass * result.u[:, 9:11]
    assert np.abs(momentum - momentum[0]).max() < 1e-12 * np.abs(momentum[0]).max()
    assert result.u[-1, 0] > 0.1  # the block was set in motion
