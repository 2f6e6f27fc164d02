"""Files of Gmsh: what is read of formats 2.2 and 4.1, text and binary in both byte orders; and what is refused."""

from __future__ import annotations

import re

import numpy as np
import pytest

from lcpflex.bodies.fem.files import read_found
from lcpflex.errors import ModelError
from tests.unit.bodies.gmsh_writer import Sample

FORMS = [(version, order) for version in ("2.2", "4.1") for order in ("", "<", ">")]
CUBE = np.array([[x, y, z] for z in (0.0, 1) for x, y in ((0.0, 0), (1, 0), (1, 1), (0, 1))])
EDGES = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]  # of VTK
FACES = [(0, 4, 7, 3), (1, 2, 6, 5), (0, 1, 5, 4), (3, 7, 6, 2), (0, 3, 2, 1), (4, 5, 6, 7)]
# Gmsh's own order of the edges and faces of a hexahedron, and of the edges of a tetrahedron, from its manual.
GMSH_EDGES = [(0, 1), (0, 3), (0, 4), (1, 2), (1, 5), (2, 3), (2, 6), (3, 7), (4, 5), (4, 7), (5, 6), (6, 7)]
GMSH_FACES = [(0, 3, 2, 1), (0, 1, 5, 4), (0, 4, 7, 3), (1, 2, 6, 5), (2, 3, 7, 6), (4, 5, 6, 7)]
TETRA = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]
GMSH_TETRA = [(0, 1), (1, 2), (2, 0), (3, 0), (2, 3), (1, 3)]


def middles(corners, *lists):
    return np.array([corners[list(nodes)].mean(axis=0) for nodes in (*((k,) for k in range(len(corners))), *lists)])


def read(tmp_path, content):
    path = tmp_path / "part.msh"
    path.write_bytes(content)
    return read_found(path)


def two_tetrahedra(**more):
    """Of ten nodes each, with numbers that have gaps and fall, a face in two groups, and a part in two groups."""
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]])
    chosen = [(0, 1, 2, 3), (1, 2, 3, 4)]
    places = [*corners.tolist()]
    rows = []
    for cell in chosen:
        row = list(cell)
        for a, b in GMSH_TETRA:
            middle = (0.5 * (corners[cell[a]] + corners[cell[b]])).tolist()
            if middle not in places:
                places.append(middle)
            row.append(places.index(middle))
        rows.append(row)
    tags = [5000 - 7 * k for k in range(len(places))]
    numbered = [[tags[k] for k in row] for row in rows]
    face = [*numbered[0][:3], *numbered[0][4:7]]
    blocks = [
        ("vertex", [[tags[4]]], [3]),
        ("triangle6", [face], [7, 8]),
        ("tetra10", numbered, [1, 2]),
    ]
    names = {(0, 3): "the tip", (2, 7): 'face "A"', (3, 1): "Stück", (3, 2): "all"}
    return Sample(tags, np.array(places), blocks, names, **more)


@pytest.mark.parametrize(("version", "order"), FORMS)
def test_elements_groups_and_facets(tmp_path, version, order):
    sample = two_tetrahedra()
    found = read(tmp_path, sample.written(version, order))
    assert found.points.tolist() == sample.places.tolist()
    assert found.counts() == {"vertex": 1, "triangle6": 1, "tetra10": 2}
    cells = found.cells("tetra10")
    for cell in cells:  # middle nodes in the order of VTK
        assert found.points[cell] == pytest.approx(middles(found.points[cell[:4]], *TETRA), abs=1e-15)
    assert cells[:, :4].tolist() == [[0, 1, 2, 3], [1, 2, 3, 4]]
    assert set(found.groups) == {"the tip", 'face "A"', "8", "Stück", "all"}
    assert found.groups["the tip"].nodes.tolist() == [4]
    assert found.groups["the tip"].facets is None
    assert found.groups['face "A"'].facets.tolist() == [[0, 1, 2]]
    assert found.groups["8"].facets.tolist() == [[0, 1, 2]]
    assert found.groups["8"].nodes.tolist() == found.groups['face "A"'].nodes.tolist() == [0, 1, 2, 5, 6, 7]
    assert found.groups["all"].nodes.tolist() == found.groups["Stück"].nodes.tolist() == list(range(14))
    assert found.groups["all"].facets is None


@pytest.mark.parametrize(("version", "order"), FORMS)
@pytest.mark.parametrize("kind", ["hexahedron", "hexahedron20", "hexahedron27"])
def test_hexahedra_come_in_the_order_of_vtk(tmp_path, version, order, kind):
    count = int(kind[10:] or 8)
    places = middles(CUBE, *GMSH_EDGES, *GMSH_FACES, range(8))[:count]
    tags = list(range(1000, 1000 + count))
    quad = ("quad", [[tags[k] for k in (0, 3, 2, 1)]], [4])
    found = read(tmp_path, Sample(tags, places, [quad, (kind, [tags], [])]).written(version, order))
    known = middles(CUBE, *EDGES, *FACES, range(8))[:count]
    assert found.points[found.cells(kind)[0]] == pytest.approx(known, abs=1e-15)
    assert found.groups["4"].facets.tolist() == [[0, 3, 2, 1]]
    assert set(found.groups) == {"4"}


def test_a_name_of_points_and_faces_stands_for_the_points(tmp_path):
    sample = two_tetrahedra()
    sample.names[2, 7] = "the tip"
    found = read(tmp_path, sample.written("4.1", ""))
    assert found.groups["the tip"].nodes.tolist() == [4]


def test_a_negative_group_is_one_whose_elements_are_turned(tmp_path):
    sample = two_tetrahedra()
    sample.blocks[1] = (*sample.blocks[1][:2], [-7])
    for version in ("2.2", "4.1"):
        assert read(tmp_path, sample.written(version, "")).groups['face "A"'].facets.tolist() == [[0, 1, 2]]


def test_numbers_as_large_as_they_like_need_no_memory(tmp_path):
    sample = two_tetrahedra()
    large = {tag: tag + 2**52 for tag in sample.tags}
    rows = [(kind, [[large[tag] for tag in row] for row in rows], groups) for kind, rows, groups in sample.blocks]
    other = Sample([large[tag] for tag in sample.tags], sample.places, rows, sample.names)
    for order in ("", "<", ">"):
        found = read(tmp_path, other.written("4.1", order))
        assert found.cells("tetra10")[:, :4].tolist() == [[0, 1, 2, 3], [1, 2, 3, 4]]


@pytest.mark.parametrize("order", ["", "<", ">"])
def test_kinds_that_alternate_make_one_block_each(tmp_path, order):
    """And one header before each element, where the file is binary."""
    places = np.column_stack([np.arange(9.0), np.zeros(9), np.zeros(9)])
    blocks = [(kind, [[k + 1, k + 2, *[k + 3] * (kind == "triangle")]], [k]) for k in range(1, 6) for kind in
              ("line", "triangle")]  # fmt: skip
    found = read(tmp_path, Sample(list(range(1, 10)), places, blocks).written("2.2", order))
    assert [kind for kind, _ in found.blocks] == ["line", "triangle"]
    assert found.cells("triangle").tolist() == [[k, k + 1, k + 2] for k in range(1, 6)]
    assert {name: group.nodes.tolist() for name, group in found.groups.items()} == {
        str(k): [k, k + 1] for k in range(1, 6)
    }


@pytest.mark.parametrize("version", ["2", "2.000000", "2.1"])
def test_version_2_however_it_is_written(tmp_path, version):
    text = two_tetrahedra().written("2.2", "").decode().replace("2.2 0 8", f"{version} 0 8")
    assert read(tmp_path, text.encode()).counts()["tetra10"] == 2


def test_parameters_and_sections_of_others_are_passed_over(tmp_path):
    text = two_tetrahedra().written("4.1", "").decode()
    extra = "$Comments\nfrom elsewhere $Nodes\n$EndComments\n"
    text = text.replace("$Entities", extra + "$Entities", 1)
    lines = text.splitlines()
    at = lines.index("$Nodes") + 2
    count = int(lines[at].split()[3])
    assert lines[at].split()[2] == "0"
    lines[at] = f"2 1 1 {count}"
    for k in range(at + 1 + count, at + 1 + 2 * count):
        lines[k] += " .25 .5"
    found = read(tmp_path, "\r\n".join(lines).encode())
    assert found.points.tolist() == two_tetrahedra().places.tolist()


WRONG = [  # version, what stands in its text, what instead, what is said
    ("4.1", "4.1 0 8", "4 0 8", "format is Gmsh's '4', expected 2.2 or 4.1"),
    ("4.1", "4.1 0 8", "3.0 0 8", "format is Gmsh's '3.0', expected 2.2 or 4.1"),
    ("4.1", "4.1 0 8", "4.1 2 8", r"has '4.1 2 8', expected"),
    ("2.2", "2.2 0 8", "2.2 0 16", r"has '2.2 0 16', expected"),
    ("4.1", "4.1 0 8", "4.1 1 8", "the number 1 in either byte order"),
    ("4.1", "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n", "$NOD\n", "format is Gmsh's 1, expected"),
    ("4.1", "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n", "", "PhysicalNames comes before"),
    ("2.2", "$Nodes\n14", "$Nodes\n1000000000000", "4000000000000 numbers are told, 56 follow, expected"),
    ("2.2", "$Nodes\n14", "$Nodes\n-14", "has the number -14, expected"),
    ("2.2", "$Nodes\n14", "$Nodes\n13", "more than it tells"),
    ("4.1", "2 14 4909 5000", "2 1000000000000000000 1 5", "whole number|tells 1000000000000000000 nodes"),
    ("4.1", "2 14 4909 5000", "2 -14 4909 5000", "number -14, expected"),
    ("4.1", "2 14 4909 5000", "2 15 4909 5000", "tells 15 nodes and has 14, expected"),
    ("4.1", "3 4 1 4", "3 5 1 5", "tells 5 elements and has 4, expected"),
    ("2.2", "5000 0.0 0.0 0.0", "4993 0.0 0.0 0.0", "node 4993 comes twice"),
    ("4.1", "\n5000", "\n4993", "node 4993 comes twice"),
    ("2.2", "5000 0.0 0.0 0.0", "5000.5 0.0 0.0 0.0", "no whole number"),
    ("2.2", "5000 0.0 0.0 0.0", "1e300 0.0 0.0 0.0", "no whole number"),
    ("2.2", "5000 0.0 0.0 0.0", "nan 0.0 0.0 0.0", "no whole number"),
    ("2.2", "5000 0.0 0.0 0.0", "5000 0.0 nan 0.0", r"node 0 is at \[0.0, nan, 0.0\], expected finite places"),
    ("2.2", "5000 0.0 0.0 0.0", "5000 0.0 1e999 0.0", "node 0 is at .*inf"),
    ("2.2", "5000 0.0 0.0 0.0", "5000 0.0 zero 0.0", r"\$Nodes holds 'zero', expected numbers only"),
    ("2.2", "1 15 2 3 1 4972", "1 15 2 3 1 4971", "node 4971 is not in the file"),
    ("2.2", "1 15 2 3 1 4972", "1 15 2 3 1 99999999999999999999999", r"\$Elements|node .* is not in the file"),
    ("2.2", "1 15 2 3 1 4972", "1 999 2 3 1 4972", "elements of type 999 .unknown"),
    ("2.2", "1 15 2 3 1 4972", "1 92 2 3 1 4972", "elements of type 92 .one of higher order"),
    ("2.2", "1 15 2 3 1 4972", "1 15 -2 3 1 4972", "of -2 tags"),
    ("4.1", "0 1 15 1", "0 77 15 1", "has entity 77 of dimension 0"),
    ("4.1", "0 1 15 1", "1 1 15 1", "vertex in an entity of dimension 1"),
    ("4.1", "$EndElements", "", "ends in .Elements"),
    ("4.1", "$Elements", "$Nodes\n$EndNodes\n$Elements", "two sections .Nodes"),
    ("4.1", "$Entities", "$PartitionedEntities", "its mesh is partitioned"),
    ("4.1", '0 3 "the tip"', '0 3 "the tip', "has the line"),
    ("4.1", '0 3 "the tip"\n', "", "has 3 names, expected as many as it tells"),
]


@pytest.mark.parametrize(("version", "old", "new", "said"), WRONG)
def test_wrong_files_are_refused(tmp_path, version, old, new, said):
    text = two_tetrahedra().written(version, "").decode()
    text = re.sub(r" +\n", "\n", text)
    assert old in text
    with pytest.raises(ModelError, match=said) as refused:
        read(tmp_path, text.replace(old, new, 1).encode())
    assert "part.msh" in str(refused.value)
    assert "expected" in str(refused.value)


@pytest.mark.parametrize(("version", "order"), FORMS)
def test_a_file_that_ends_anywhere_is_refused(tmp_path, version, order):
    content = two_tetrahedra().written(version, order)
    for end in range(0, len(content) - len("$EndElements\n"), 7):
        with pytest.raises(ModelError, match="expected"):
            read(tmp_path, content[:end])


@pytest.mark.parametrize(("version", "order"), FORMS)
def test_changed_bytes_give_a_mesh_or_a_refusal(tmp_path, version, order):
    content = two_tetrahedra().written(version, order)
    rng = np.random.default_rng(3)
    for _ in range(150):
        changed = bytearray(content)
        for at in rng.integers(len(content), size=rng.integers(1, 4)):
            changed[at] = rng.integers(256)
        try:
            read(tmp_path, bytes(changed))
        except ModelError as error:
            assert "expected" in str(error)  # noqa: PT017
