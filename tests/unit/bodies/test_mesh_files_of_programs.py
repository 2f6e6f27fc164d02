"""Meshes of one bar as Gmsh, Netgen and CalculiX write it: places, orders of nodes, and what names stand for."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from lcpflex.bodies.fem.files import read_found

FOLDER = Path(__file__).parent / "mesh_files"
EDGES = {
    "tetra": [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)],
    "hexahedron": [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)],
}
FACES = [(0, 4, 7, 3), (1, 2, 6, 5), (0, 1, 5, 4), (3, 7, 6, 2), (0, 3, 2, 1), (4, 5, 6, 7), range(8)]
GMSH, INP = {0: "left end", 2: "right"}, {0: "left_end", 2: "right"}
FILES = {  # kind of the elements, and names of the ends
    "gmsh_hexahedron_2_binary.msh": ("hexahedron", GMSH),
    "gmsh_hexahedron20_binary.msh": ("hexahedron20", GMSH),
    "gmsh_hexahedron20.inp": ("hexahedron20", INP),
    "gmsh_hexahedron27_parametric.msh": ("hexahedron27", GMSH),
    "gmsh_hexahedron27.inp": ("hexahedron27", INP),
    "gmsh_tetra10_2.msh": ("tetra10", GMSH),
    "gmsh_tetra10_binary.msh": ("tetra10", GMSH),
    "gmsh_tetra10.inp": ("tetra10", INP),
    "netgen_tetra10.inp": ("tetra10", {0: "left", 2: "right"}),
    "netgen_tetra10_2.msh": ("tetra10", {0: "2", 2: "4"}),
    "cgx_hexahedron20.inp": ("hexahedron20", {2: "right"}),
}


@pytest.mark.parametrize("name", FILES)
def test_the_bar_is_whole_and_its_ends_are_known(name):
    kind, ends = FILES[name]
    found = read_found(FOLDER / name)
    cells = found.cells(kind)
    shape = kind.rstrip("0123456789")
    corners = {"tetra": 4, "hexahedron": 8}[shape]
    places = found.points[cells]
    arms = places[:, [1, 3, 4] if shape == "hexahedron" else [1, 2, 3]] - places[:, :1]
    volumes = np.linalg.det(arms) / (1.0 if shape == "hexahedron" else 6.0)
    if name == "netgen_tetra10_2.msh":  # all inside out: a mesh that takes them has to turn them around
        volumes = -volumes
    assert volumes.min() > 0.0
    assert volumes.sum() == pytest.approx(2.0, rel=1e-9)
    middles = [*EDGES[shape], *(FACES if kind.endswith("27") else [])] if places.shape[1] > corners else []
    for k, amid in enumerate(middles):
        assert places[:, corners + k] == pytest.approx(places[:, list(amid)].mean(axis=1), abs=1e-6)
    for x, end in ends.items():
        group = found.groups[end]
        at = found.points[group.facets]
        assert at[..., 0] == pytest.approx(x, abs=1e-9)
        if shape == "hexahedron":
            area = np.linalg.norm(np.cross(at[:, 2] - at[:, 0], at[:, 3] - at[:, 1]), axis=1)
        else:
            area = np.linalg.norm(np.cross(at[:, 1] - at[:, 0], at[:, 2] - at[:, 0]), axis=1)
        assert 0.5 * area.sum() == pytest.approx(1.0, rel=1e-9)
        on = np.flatnonzero(np.abs(found.points[:, 0] - x) < 1e-9)
        assert group.nodes.tolist() == on.tolist()


def test_groups_of_gmsh_may_share_entities():
    for name in ("gmsh_tetra10_2.msh", "gmsh_tetra10_binary.msh"):
        groups = read_found(FOLDER / name).groups
        assert set(groups) == {"tip", "left end", "right", "77", "steel", "all of it"}
        assert groups["77"].facets.tolist() == groups["right"].facets.tolist()
        assert len(groups["steel"].nodes) == len(groups["all of it"].nodes) == 219
