"""Input files of Abaqus and CalculiX: elements, sets, surfaces, parts and their instances; and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from lcpflex.bodies.continuum import Continuum
from lcpflex.bodies.fem.files import read_found
from lcpflex.errors import ModelError

CUBE = np.array([[x, y, z] for z in (0.0, 1) for x, y in ((0.0, 0), (1, 0), (1, 1), (0, 1))])
EDGES = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
FACES_VTK = [(0, 4, 7, 3), (1, 2, 6, 5), (0, 1, 5, 4), (3, 7, 6, 2), (0, 3, 2, 1), (4, 5, 6, 7)]
FACES = [(0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0)]  # S1 ... of Abaqus
TETRA = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
TETRA_EDGES = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]
TETRA_FACES = [(0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)]


def middles(corners, *lists):
    return np.array([corners[list(nodes)].mean(axis=0) for nodes in (*((k,) for k in range(len(corners))), *lists)])


def read(tmp_path, text, name="part.inp"):
    path = tmp_path / name
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return read_found(path)


def lines_of(places, first=1):
    return "\n".join(f"{first + k}, {', '.join(map(repr, place))}" for k, place in enumerate(places.tolist()))


TWO = """** a comment
*HEADING
whatever, it says: *not a keyword
*Node, nset=Nall
** amid the data
1000, 0., 0., 0.
1010, 1., 0., 0.,
1020, 1.0D0, 1., 0.

1030, 0, 1.
  1040 , 0., 0., 1.
1050, 1., 0., 1.
1060, 1., 1., 1.
1070, 0., 1., 1.
1080, 0., 0., 2.
1090, 1., 0., 2.
1100, 1., 1., 2.
1110, 0., 1., 2.
5000, 9., 9., 9.
*ELEMENT, TYPE = C3D8R,
 ELSET=Steel
7, 1000, 1010, 1020, 1030, 1040, 1050, 1060, 1070
9, 1040, 1050, 1060, 1070,
   1080, 1090, 1100, 1110
*element,type=MASS,elset=weights
100, 5000
*NSET, NSET="the tip"
1080, 1090,
STEEL_END
*nset, nset=Steel_End, generate
1100, 1119, 10
*NSET, NSET=from elements, ELSET=upper
*ELSET, ELSET=upper
9
*ELSET, ELSET=both, GENERATE
7, 9, 2
*ELSET, ELSET=all
both, weights
*SURFACE, NAME=top, TYPE=ELEMENT
upper, S2
*SURFACE, NAME=outside
Steel,
*SURFACE, NAME=points, TYPE=NODE
the tip, 1.
1000
*SURFACE, NAME=pipe, TYPE=CYLINDER
nonsense
*SOLID SECTION, ELSET=Steel, MATERIAL=M
*NODE PRINT, NSET=Nall
U
*STEP
*END STEP
"""


def test_elements_sets_and_surfaces(tmp_path):
    found = read(tmp_path, TWO)
    assert found.counts() == {"hexahedron": 2}
    assert found.points.shape == (13, 3)
    assert found.points[:8].tolist() == CUBE.tolist()
    assert found.cells("hexahedron").tolist() == [list(range(8)), list(range(4, 12))]
    groups = {name: group.nodes.tolist() for name, group in found.groups.items()}
    assert groups == {
        "Nall": list(range(13)),
        "the tip": [8, 9, 10, 11],
        "Steel_End": [10, 11],
        "from elements": list(range(4, 12)),
        "points": [0, 8, 9, 10, 11],
        "Steel": list(range(12)),
        "upper": list(range(4, 12)),
        "both": list(range(12)),
        "all": list(range(12)),
        "top": [8, 9, 10, 11],
        "outside": list(range(12)),
    }
    assert found.groups["top"].facets.tolist() == [[8, 11, 10, 9]]
    assert len(found.groups["outside"].facets) == 10
    assert [4, 5, 6, 7] not in np.sort(found.groups["outside"].facets, axis=1).tolist()
    assert found.groups["Steel"].facets is None


def test_ends_of_lines_of_other_systems_and_bytes_of_other_alphabets(tmp_path):
    known = read(tmp_path, TWO)
    for text in (TWO.replace("\n", "\r\n").encode(), TWO.replace("\n", "\r").encode(), b"\xef\xbb\xbf" + TWO.encode()):
        assert read(tmp_path, text).groups.keys() == known.groups.keys()
    found = read(tmp_path, TWO.replace("upper", "größer").encode("latin-1"))
    assert "größer" in found.groups


@pytest.mark.parametrize(
    ("element", "kind", "corners", "edges", "faces"),
    [
        ("C3D4", "tetra", TETRA, [], TETRA_FACES),
        ("C3D10M", "tetra10", TETRA, TETRA_EDGES, TETRA_FACES),
        ("C3D8I", "hexahedron", CUBE, [], FACES),
        ("C3D20R", "hexahedron20", CUBE, EDGES, FACES),
        ("c3d27", "hexahedron27", CUBE, [*EDGES, range(8), FACES[0], FACES[1], *FACES[2:]], FACES),
    ],
)
def test_solid_elements_and_their_faces(tmp_path, element, kind, corners, edges, faces):
    places = middles(corners, *edges)
    row = [str(k) for k in (1, *range(1, 1 + len(places)))]
    text = f"*NODE\n{lines_of(places)}\n*ELEMENT, TYPE={element}\n"
    text += ",\n".join(", ".join(row[k : k + 16]) for k in range(0, len(row), 16)) + "\n"
    text += "".join(f"*SURFACE, NAME=side{k + 1}\n1, S{k + 1}\n" for k in range(len(faces)))
    found = read(tmp_path, text)
    order = [*EDGES, *FACES_VTK, range(8)] if kind == "hexahedron27" else edges
    assert found.points[found.cells(kind)[0]] == pytest.approx(middles(corners, *order), abs=1e-15)
    for k, face in enumerate(faces):
        group = found.groups[f"side{k + 1}"]
        assert group.facets.tolist() == [list(face)]
        plane = found.points[list(face)]
        normal = np.cross(plane[1] - plane[0], plane[2] - plane[0])
        on = np.flatnonzero(np.abs((found.points - plane[0]) @ normal) < 1e-12)
        assert group.nodes.tolist() == on.tolist()  # all nodes of the face, amid edges and itself, too


def test_c3d27_in_an_order_that_nobody_has_is_refused(tmp_path):
    places = middles(CUBE, *EDGES, *FACES_VTK, range(8))
    row = ", ".join(map(str, [1, *range(1, 9), *range(27, 8, -1)]))
    with pytest.raises(ModelError, match="order that is not known, expected"):
        read(tmp_path, f"*NODE\n{lines_of(places)}\n*ELEMENT, TYPE=C3D27\n{row}\n")


def test_surfaces_of_shells_name_facets_of_a_solid(tmp_path):
    text = (
        f"*NODE\n{lines_of(CUBE)}\n*ELEMENT, TYPE=C3D8\n1,1,2,3,4,5,6,7,8\n*ELEMENT, TYPE=S4R, ELSET=skin\n2,1,2,3,4\n"
    )
    text += "*SURFACE, NAME=above\nskin, SPOS\n*NSET, NSET=below\n1, 2, 3, 4\n*SURFACE, NAME=below\n1, S1\n"
    found = read(tmp_path, text)
    assert found.counts() == {"hexahedron": 1, "quad": 1}
    assert found.groups["skin"].facets.tolist() == found.groups["above"].facets.tolist() == [[0, 1, 2, 3]]
    assert found.groups["below"].facets.tolist() == [[0, 1, 2, 3]]  # the set has its name, and the same nodes


PARTS = f"""*HEADING
*PART, NAME=Block
*NODE
{lines_of(CUBE, 11)}
*ELEMENT, TYPE=C3D8, ELSET=body
5, 11, 12, 13, 14, 15, 16, 17, 18
*NSET, NSET=foot
11, 12, 13, 14
*ELSET, ELSET=_picked, INTERNAL
5
*SURFACE, NAME=lid
_picked, S2
*END PART
*PART, NAME=unused
*NODE
1, 0, 0, 0
*END PART
*ASSEMBLY, NAME=Assembly
*INSTANCE, NAME=First, PART=block
*END INSTANCE
*INSTANCE, NAME="the second", PART=Block
10., 0., 0.
10., 0., 0., 10., 0., 1., 90.
*END INSTANCE
*NODE, NSET=reference
1, 5., 5., 5.
*NSET, NSET=feet, INSTANCE=First
11, 12
*NSET, NSET=feet, INSTANCE="the second"
foot
*NSET, NSET=dotted
First.13, "the second.18", First.foot
*ELSET, ELSET=_lids, INTERNAL, INSTANCE=First
5
*SURFACE, NAME=lids
_lids, S2
the second.body, S2
*END ASSEMBLY
"""


def test_instances_of_parts(tmp_path):
    found = read(tmp_path, PARTS)
    assert found.counts() == {"hexahedron": 2}
    assert found.points[0].tolist() == [5, 5, 5]
    assert found.points[1:9].tolist() == CUBE.tolist()
    turned = np.column_stack([10.0 - CUBE[:, 1], CUBE[:, 0], CUBE[:, 2]])
    assert found.points[9:] == pytest.approx(turned, abs=1e-15)
    assert found.cells("hexahedron").tolist() == [list(range(1, 9)), list(range(9, 17))]
    groups = {name: group.nodes.tolist() for name, group in found.groups.items()}
    assert groups["reference"] == [0]
    assert groups["feet"] == [1, 2, 9, 10, 11, 12]
    assert groups["dotted"] == [1, 2, 3, 4, 16]
    assert groups["First.foot"] == [1, 2, 3, 4]
    assert groups["the second.foot"] == [9, 10, 11, 12]
    assert groups["lids"] == [5, 6, 7, 8, 13, 14, 15, 16]
    assert len(found.groups["lids"].facets) == 2
    assert found.groups["the second.lid"].facets.tolist() == [[13, 16, 15, 14]]
    assert not any("_picked" in name or "_lids" in name for name in groups)
    alone = read(tmp_path, PARTS.partition("*PART, NAME=unused")[0])
    assert alone.groups["foot"].nodes.tolist() == [0, 1, 2, 3]


def test_files_in_files(tmp_path):
    folder = tmp_path / "more"
    folder.mkdir()
    (folder / "nodes.txt").write_text("** only data\n" + lines_of(CUBE) + "\n")
    (folder / "mesh.inp").write_text(
        "*NODE\n*INCLUDE, INPUT=nodes.txt\n*ELEMENT, TYPE=C3D8, ELSET=all, INPUT=rows.txt\n"
    )
    (folder / "rows.txt").write_text("1,1,2,3,4,5,6,7,8\n")
    found = read(tmp_path, "*HEADING\n*Include, input=more/mesh.inp\n*NSET, NSET=two\n1, 2\n")
    assert found.counts() == {"hexahedron": 1}
    assert found.groups["two"].nodes.tolist() == [0, 1]
    assert found.groups["all"].nodes.tolist() == list(range(8))


def test_edges_of_plane_elements_are_surfaces(tmp_path):
    text = "*NODE\n1,0,0\n2,1,0\n3,1,1\n4,0,1\n*ELEMENT, TYPE=CPS4\n9,1,2,3,4\n*SURFACE, NAME=right\n9, S2\n"
    path = tmp_path / "plane.inp"
    path.write_text(text)
    mesh = Continuum(path, 7800.0, 2e11, 0.3).finite_elements()
    assert mesh.chains["right"][0].tolist() == [1, 2]


def test_what_calculix_writes_besides(tmp_path):
    """Nodes of incompatible modes on the lines of elements, fluid networks, surfaces of nodes and faces of one name."""
    text = f"*NODE\n{lines_of(CUBE)}\n9, 5., 5., 5.\n*ELEMENT, TYPE=C3D8I\n1,1,2,3,4,5,6,7,8,9,1,\n"
    text += "*ELEMENT, TYPE=D, ELSET=water\n2,0,9,1\n*SURFACE, NAME=s, TYPE=NODE\n9\n*SURFACE, NAME=s\n1, S1\n"
    text += "*SURFACE, NAME=t, TYPE=NODE\n1\n2\n3\n4\n*SURFACE, NAME=t\n1, S1\n"
    found = read(tmp_path, text, name="part.msh")
    assert found.cells("hexahedron").tolist() == [list(range(8))]
    assert found.groups["s"].nodes.tolist() == [8]
    assert found.groups["t"].facets.tolist() == [[0, 1, 2, 3]]


def test_cylindrical_coordinates(tmp_path):
    found = read(tmp_path, "*NODE, SYSTEM=C\n1, 2., 90., 3.\n*ELEMENT, TYPE=MASS\n1, 1\n")
    assert found.points == pytest.approx(np.array([[0.0, 2.0, 3.0]]), abs=1e-15)
    assert found.counts() == {}


SMALL = "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n*ELEMENT, TYPE=C3D4, ELSET=e\n1,1,2,3,4\n"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "has no .NODE, expected nodes"),
        ("1, 2, 3\n", "begins with '1, 2, 3', expected a keyword"),
        (SMALL.replace("C3D4", "COH3D6"), "elements of type 'COH3D6' in line 6, expected"),
        (SMALL.replace("C3D4", "C3D99"), "elements of type 'C3D99'"),
        (SMALL.replace("TYPE=C3D4, ", ""), "line 6 has no TYPE, expected TYPE="),
        (SMALL.replace("1,1,2,3,4", "1,1,2,3"), "no elements of 4 nodes"),
        (SMALL.replace("1,1,2,3,4", "1,1,2,3,4,\n5"), "no elements of 4 nodes"),
        (SMALL.replace("1,1,2,3,4", "1,1,2\n3,4,2,1,2,3,4"), "no elements of 4 nodes"),
        (SMALL.replace("1,1,2,3,4", "1,1,,2,3,4"), "empty entry, expected"),
        (SMALL.replace("1,1,2,3,4", "1,1,2,3,99999999999"), "node 99999999999 is not in the file"),
        (SMALL.replace("1,1,2,3,4", "1,1,2,3,-4"), "node -4 is not in the file"),
        (SMALL.replace("1,1,2,3,4", "1,1,2,3,4\n1,1,2,3,4"), "element 1 comes twice"),
        (SMALL.replace("2,1,0,0", "1,1,0,0"), "node 1 comes twice"),
        (SMALL.replace("2,1,0,0", "2,1 0,0"), "without a comma"),
        (SMALL.replace("2,1,0,0", "2,nan,0,0"), "node 1 is at .*nan.*expected finite"),
        (SMALL.replace("2,1,0,0", "2,<x>,0,0"), "holds '<x>', expected numbers only"),
        (SMALL.replace("2,1,0,0", "2.5,1,0,0"), "no whole number"),
        (SMALL.replace("2,1,0,0", "2,1,0,0,0,0,0,0"), "a line of 8 numbers"),
        (SMALL + "*NSET, NSET=n\n1, 7\n", "node 7 is not in the file"),
        (SMALL + "*NSET, NSET=n\n1, other\n", "holds 'other', expected a set that is there"),
        (SMALL + "*NSET, NSET=n, INSTANCE=i\n1\n", "the instance 'i', expected one that is there"),
        (SMALL + "*NSET, NSET=n\nm\n*NSET, NSET=m\nn\n", "holds itself"),
        (SMALL + "*NSET, NSET=n, GENERATE\n1, 4, 0\n", "1, 4, 0, expected a step >= 1"),
        (SMALL + "*NSET, NSET=n, GENERATE\n1, 4, -1\n", "1, 4, -1, expected a step >= 1"),
        (SMALL + "*NSET, NSET=n, GENERATE\n1\n", "a line of 1 numbers, expected"),
        (SMALL + "*NSET, NSET=n, GENERATE\n5, 1000000000000000, 1\n", "expected some that are in the file"),
        (SMALL + "*NSET\n1\n", "has no NSET"),
        (SMALL + "*SURFACE, NAME=s\ne, S5\n", "face 5 of tetra, expected 1 to 4"),
        (SMALL + '*NSET, NSET="n\n1\n', "a quote without its twin"),
        (SMALL + "*NGEN\n1, 2, 1\n", "NGEN in line 8 makes nodes or elements, expected"),
        (SMALL + "*SYSTEM\n1, 2, 1\n", "SYSTEM in line 8 makes"),
        (SMALL + "*INCLUDE, INPUT=nowhere.inp\n", "includes .*nowhere.inp.*, expected a file that is there"),
        (SMALL + "*INCLUDE\n", "has no INPUT"),
        (SMALL + "*INCLUDE, INPUT=part.inp\n", "includes itself"),
        ("*PART, NAME=p\n" + SMALL, "ends in 'p', expected .END PART"),
        ("*INSTANCE, NAME=p, PART=q\n", "is of part 'q', expected a part that is there"),
        ("*PART, NAME=p\n*END PART\n*PART, NAME=P\n*END PART\n", "has the name 'P' of another"),
        ("*PART, NAME=p\n*END PART\n*PART, NAME=q\n*END PART\n", "parts 'p', 'q' and no .INSTANCE"),
        ("*PART, NAME=p\n*END PART\n*INSTANCE, NAME=i, PART=p\n1, 2, 3, 4\n*END INSTANCE\n", "of a translation"),
        ("*PART, NAME=p\n*END PART\n*INSTANCE, NAME=i, PART=p\n0\n1,1,1,1,1,1,90\n*END INSTANCE\n", "equal points"),
        (SMALL.replace("*NODE", "*NODE, SYSTEM=C").replace("2,1,0,0", "2,1,inf,0"), "node 1 is at .*expected finite"),
        (
            "*PART, NAME=p\n" + SMALL.replace("2,1,0,0", "2,inf,0,0") + "*END PART\n*INSTANCE, NAME=i, PART=p\n0\n"
            "0,0,0,0,0,1,90\n*END INSTANCE\n",
            "node 1 is at .*expected finite",
        ),
        (SMALL.replace("*NODE", "*NODE, SYSTEM=S"), "SYSTEM='S'"),
    ],
)
def test_wrong_files_are_refused(tmp_path, text, said):
    with pytest.raises(ModelError, match=said) as refused:
        read(tmp_path, text)
    assert "part.inp" in str(refused.value)
    assert "expected" in str(refused.value)


def test_a_text_of_two_bytes_a_character_is_refused(tmp_path):
    with pytest.raises(ModelError, match="expected UTF-8"):
        read(tmp_path, SMALL.encode("utf-16"))


def test_ranges_without_end_need_no_memory(tmp_path):
    found = read(tmp_path, SMALL + "*NSET, NSET=n, GENERATE\n2, 1000000000000000000, 2\n")
    assert found.groups["n"].nodes.tolist() == [1, 3]


def test_few_lines_that_ask_for_members_without_end_are_refused(tmp_path):
    """Each of 3000 sets has all of 20000 nodes: less than 200 kB of text would need half a gigabyte."""
    nodes = "*NODE\n" + "".join(f"{k}\n" for k in range(1, 20001))
    sets = "*NSET, NSET=a, GENERATE\n1, 20000\n" + "".join(f"*NSET, NSET=s{k}\na\n" for k in range(3000))
    with pytest.raises(ModelError, match="its sets have more than 20000000 members, expected fewer"):
        read(tmp_path, nodes + sets)
    part = f"*PART, NAME=p\n{nodes}*END PART\n"
    instances = "".join(f"*INSTANCE, NAME=i{k}, PART=p\n*END INSTANCE\n" for k in range(3000))
    with pytest.raises(ModelError, match="its instances have more than 10000000 nodes, expected fewer"):
        read(tmp_path, part + instances)


def test_sets_that_hold_each_other_again_and_again_are_refused(tmp_path):
    """Of 60 sets of which each holds the one before twice, the last has 2^60 members if they are written out."""
    chain = "*NSET, NSET=s0\n1, 2\n" + "".join(f"*NSET, NSET=s{k}\ns{k - 1}, s{k - 1}\n" for k in range(1, 60))
    assert read(tmp_path, SMALL + chain).groups["s59"].nodes.tolist() == [0, 1]
    chain = "*NSET, NSET=s0\n1, 2\n" + "".join(f"*NSET, NSET=s{500 - k}\ns{499 - k}\n" for k in range(499))
    with pytest.raises(ModelError, match="holds itself, expected"):
        read(tmp_path, SMALL + chain)


@pytest.mark.parametrize("text", [TWO, PARTS])
def test_cut_and_changed_files_give_a_mesh_or_a_refusal(tmp_path, text):
    rng = np.random.default_rng(5)
    content = text.encode()
    for k in range(250):
        changed = bytearray(content)
        for at in rng.integers(len(content), size=rng.integers(1, 4)):
            changed[at] = rng.integers(256)
        try:
            read(tmp_path, bytes(changed) if k % 2 else content[: rng.integers(len(content))])
        except ModelError as error:
            assert "expected" in str(error)  # noqa: PT017
