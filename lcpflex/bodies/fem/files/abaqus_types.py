"""Types of elements of Abaqus and CalculiX, by the names of meshio, and their faces.

Local orders of nodes are those of VTK but for C3D27, and for lines, whose node amid comes second.
"""

from __future__ import annotations

import re

import numpy as np

from lcpflex.bodies.fem.files.found import Unreadable
from lcpflex.errors import shown
from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["FACES", "kind_of", "ordered"]

SOLIDS = {
    4: "tetra", 5: "pyramid", 6: "wedge", 8: "hexahedron", 10: "tetra10", 13: "pyramid13", 15: "wedge15",
    20: "hexahedron20", 27: "hexahedron27",
}  # fmt: skip
AREAS = {3: "triangle", 4: "quad", 6: "triangle6", 8: "quad8", 9: "quad9"}
LINES = {1: "line", 2: "line3", 3: "line"}  # by the order of interpolation: a cubic beam has two nodes
SOLID = re.compile(r"(?:A|D|F|Q)?C?3D(\d+)[A-Z]*")
AREA = re.compile(r"(?:CPS|CPEG?|CG?AX|DC2D|DCAX|AC2D|ACAX|S|STRI|DS|M3D|SFM3D|R3D)(\d)(?:[A-Z][A-Z0-9]*)?")
BEAM = re.compile(r"(?:B|PIPE|ELBOW)[23]([123])[A-Z]*|(?:S|M|D)AX([12])[A-Z]*")
TRUSS = re.compile(r"(?:T[23]D|R2D|RAX|RB2D|RB3D|DC1D)([23])[A-Z]*")
NO_MESH = re.compile(
    r"MASS|ROTARYI|HEATCAP|POINT|SPRING[A12]|DASHPOT[A12]|CONN[23]D2|GAP\w+|JOINT\w+|DCOUP[23]D|ITS\w+|DGAP|FRAME[23]D|"
    r"D|TRACER|LS\d\w*|DISTRIBUTING|PC3D|PD3D"
)
ORDERS_27 = (  # where the nodes of VTK stand among those of C3D27: of Abaqus, of Gmsh, of VTK
    [*range(20), 26, 24, 23, 25, 21, 22, 20],
    [0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15, 22, 23, 21, 24, 20, 25, 26],
    [*range(27)],
)
MIDDLES_27 = (
    *((0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)),
    *((0, 4, 7, 3), (1, 2, 6, 5), (0, 1, 5, 4), (3, 7, 6, 2), (0, 3, 2, 1), (4, 5, 6, 7), tuple(range(8))),
)  # corners amid which the nodes of VTK lie
AMID = 0.35  # of its largest extent that a node of a curved element lies beside the middle of its corners, at most
Faces = dict[int, tuple[int, ...]]  # nodes by the numbers of faces
_TETRA: Faces = {1: (0, 1, 2, 4, 5, 6), 2: (0, 3, 1, 7, 8, 4), 3: (1, 3, 2, 8, 9, 5), 4: (2, 3, 0, 9, 7, 6)}
_HEXAHEDRON: Faces = {  # corners, edges, and the middle of the face in the order of VTK
    1: (0, 1, 2, 3, 8, 9, 10, 11, 24),
    2: (4, 7, 6, 5, 15, 14, 13, 12, 25),
    3: (0, 4, 5, 1, 16, 12, 17, 8, 22),
    4: (1, 5, 6, 2, 17, 13, 18, 9, 21),
    5: (2, 6, 7, 3, 18, 14, 19, 10, 23),
    6: (3, 7, 4, 0, 19, 15, 16, 11, 20),
}


def _edges(corners: int, quadratic: bool) -> tuple[str, Faces]:
    ends: Faces = {k + 1: (k, (k + 1) % corners) for k in range(corners)}
    if not quadratic:
        return "line", ends
    return "line3", {k: (*nodes, corners + k - 1) for k, nodes in ends.items()}


# Kinds of the faces of each kind of element, and their nodes by their numbers: "S1" is face 1.
FACES: dict[str, tuple[str, Faces]] = {
    "tetra": ("triangle", {k: nodes[:3] for k, nodes in _TETRA.items()}),
    "tetra10": ("triangle6", _TETRA),
    "hexahedron": ("quad", {k: nodes[:4] for k, nodes in _HEXAHEDRON.items()}),
    "hexahedron20": ("quad8", {k: nodes[:8] for k, nodes in _HEXAHEDRON.items()}),
    "hexahedron27": ("quad9", _HEXAHEDRON),
    "triangle": _edges(3, False),
    "triangle6": _edges(3, True),
    "quad": _edges(4, False),
    "quad8": _edges(4, True),
    "quad9": _edges(4, True),
}


def kind_of(name: str, where: str) -> str | None:
    """The kind of element of a type of Abaqus; None for masses, springs and the like; raises Unreadable for others."""
    upper = name.upper()
    if upper in ("STRI65", "DS6", "S6"):
        return "triangle6"
    if (found := SOLID.fullmatch(upper)) is not None and int(found[1][:3]) in SOLIDS:
        return SOLIDS[int(found[1])]
    if (found := AREA.fullmatch(upper)) is not None and int(found[1]) in AREAS:
        return AREAS[int(found[1])]
    if (found := BEAM.fullmatch(upper)) is not None:
        return LINES[int(found[1] or found[2])]
    if (found := TRUSS.fullmatch(upper)) is not None:
        return "line" if found[1] == "2" else "line3"
    if NO_MESH.fullmatch(upper):
        return None
    raise Unreadable(
        f"elements of type {shown(name)} {where}, expected solids (C3D4, C3D8, C3D10, C3D20, C3D27 ...), plane or "
        "axisymmetric elements (CPS, CPE, CAX), shells, membranes, beams or trusses"
    )


def ordered(kind: str, cells: IntArray, places: FloatArray, where: str) -> IntArray:
    """Nodes of elements of Abaqus in the order of meshio.

    Programs write the nodes of C3D27 amid edges and faces in orders of their own: that one is taken in which they lie
    amid their corners; raises Unreadable where there is none. places: (N, 3), of all nodes.
    """
    if kind == "line3":
        return cells[:, [0, 2, 1]]  # the node amid comes second
    if kind != "hexahedron27" or not len(cells):
        return cells
    size = np.ptp(places[cells[:, :8]], axis=1).max()
    beside = [_beside(places[cells[:, order]]) for order in ORDERS_27]
    best = int(np.argmin(beside))
    if not beside[best] <= AMID * size:
        raise Unreadable(f"C3D27 {where} with nodes in an order that is not known, expected that of Abaqus")
    return cells[:, ORDERS_27[best]]


def _beside(places: FloatArray) -> float:
    """How far nodes are from the middle of their corners at most."""
    middles = np.stack([places[:, corners].mean(axis=1) for corners in map(list, MIDDLES_27)], axis=1)
    return float(np.abs(places[:, 8:] - middles).max())
