"""Sets and surfaces of an Abaqus model as nodes, elements and faces of the whole mesh."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from lcpflex.bodies.fem.files.abaqus_data import Member, member_of
from lcpflex.bodies.fem.files.abaqus_model import MemberSet, Scope, Surface
from lcpflex.bodies.fem.files.abaqus_types import FACES
from lcpflex.bodies.fem.files.found import CELLS, Part, Unreadable, distinct
from lcpflex.bodies.fem.files.numbering import Numbering, joined
from lcpflex.errors import shown
from lcpflex.jit.kernel import IntArray

__all__ = ["Body", "Sets"]

DEPTH = 100  # of sets in sets
MOST = 20_000_000  # members of all sets: a few lines may ask for any number
SIDES = ("", "SPOS", "SNEG")  # names of whole shells


@dataclass(slots=True)
class Body:
    """A scope with its place in the mesh: its nodes and elements count from ``first_node`` and ``first_element``."""

    scope: Scope
    nodes: Numbering
    elements: Numbering
    first_node: int
    first_element: int


@dataclass(slots=True)
class Sets:
    """What names stand for.

    Attributes
    ----------
    bodies : by the names of instances in capitals; "" is the model itself
    blocks : kind (None: no part of a mesh) and (m, nodes) nodes of all elements, which are counted through them
    """

    bodies: dict[str, Body]
    blocks: list[tuple[str | None, IntArray]]
    _known: dict[tuple[int, str, bool], IntArray] = field(default_factory=dict)
    _open: set[tuple[int, str, bool]] = field(default_factory=set)
    _count: int = 0
    _free: list[IntArray] | None = None

    def nodes_of(self, body: Body, of: MemberSet) -> IntArray:
        """Nodes of a set of nodes."""
        return self._resolved(body, of, of_nodes=True)

    def elements_of(self, body: Body, of: MemberSet) -> IntArray:
        """Elements of a set of elements."""
        return self._resolved(body, of, of_nodes=False)

    def parts_of(self, name: str, elements: IntArray) -> list[Part]:
        """Elements as parts of a group."""
        return [(name, kind, cells) for kind, cells in self._cells(elements)]

    def surface_nodes(self, body: Body, surface: Surface) -> IntArray:
        """Nodes of a surface of nodes."""
        words = (member_of(word, "", f"*SURFACE {shown(surface.name)}") for word, _ in surface.members)
        return joined([self._member(body, member, of_nodes=True) for member in words])

    def surface_parts(self, name: str, body: Body, surface: Surface) -> list[Part]:
        """Faces of a surface of elements, as parts of a group."""
        parts: list[Part] = []
        for word, face in surface.members:
            where = f"*SURFACE {shown(surface.name)}"
            elements = self._member(body, member_of(word, "", where), of_nodes=False)
            if face == "" and self._solid(elements):
                parts.extend((name, kind, cells) for kind, cells in self._free_faces(elements))
            elif face in SIDES:
                parts.extend((name, kind, cells) for kind, cells in self._cells(elements))
            elif face[:1] in "SE" and face[1:].isdecimal() and len(face) == 2:
                parts.extend(self._faces(name, elements, int(face[1]), where))
            # others are ends of beams and the like
        return parts

    def _resolved(self, body: Body, of: MemberSet, of_nodes: bool) -> IntArray:
        key = body.first_node if of_nodes else body.first_element, f"{body.scope.name}.{of.name.upper()}", of_nodes
        if key in self._known:
            return self._known[key]
        if key in self._open or len(self._open) > DEPTH:
            raise Unreadable(f"set {shown(of.name)} holds itself, expected sets that do not")
        self._open.add(key)
        found = distinct(joined([self._member(body, member, of_nodes) for member in of.members]))
        self._open.discard(key)
        self._known[key] = found
        return found

    def _member(self, body: Body, member: Member, of_nodes: bool) -> IntArray:
        """Nodes or elements that a member of a set stands for."""
        owner = self.bodies.get(member.instance.upper()) if member.instance else body
        name = member.name
        if owner is None:  # a name with a dot of its own
            owner, name = body, f"{member.instance}.{member.name}" if member.name else ""
        if owner is body and member.instance and not name:
            raise Unreadable(f"a set names the instance {shown(member.instance)}, expected one that is there")
        numbering, first = (owner.nodes, owner.first_node) if of_nodes else (owner.elements, owner.first_element)
        if member.numbers is not None:
            found = first + numbering.known(member.numbers, "a set")
        elif member.range is not None:
            found = first + numbering.within(*member.range)
        elif member.of_elements:
            elements = self._resolved(owner, _named(owner.scope.element_sets, name), of_nodes=False)
            found = distinct(joined([cells.ravel() for _, cells in self._cells(elements)]))
        else:
            sets = owner.scope.node_sets if of_nodes else owner.scope.element_sets
            found = self._resolved(owner, _named(sets, name), of_nodes)
        self._count += len(found)
        if self._count > MOST:
            raise Unreadable(f"its sets have more than {MOST} members, expected fewer")
        return found

    def _bounds(self) -> IntArray:
        return np.cumsum([0, *(len(cells) for _, cells in self.blocks)])

    def _split(self, elements: IntArray) -> list[tuple[int, IntArray]]:
        """Blocks, and which of their elements are meant. elements: in any order."""
        rising = np.sort(elements)
        bounds = self._bounds()
        which = np.unique(np.searchsorted(bounds, rising, side="right") - 1)
        ends = np.searchsorted(rising, bounds)
        return [(int(k), rising[ends[k] : ends[k + 1]] - bounds[k]) for k in which]

    def _cells(self, elements: IntArray) -> list[tuple[str, IntArray]]:
        found = ((self.blocks[k][0], self.blocks[k][1][rows]) for k, rows in self._split(elements))
        return [(kind, cells) for kind, cells in found if kind is not None]

    def _solid(self, elements: IntArray) -> bool:
        return any(CELLS[kind].dimension == 3 for kind, _ in self._cells(elements))

    def _faces(self, name: str, elements: IntArray, number: int, where: str) -> list[Part]:
        parts: list[Part] = []
        for kind, cells in self._cells(elements):
            if kind in FACES:
                face, faces = FACES[kind]
                if number not in faces:
                    raise Unreadable(f"{where} has face {number} of {kind}, expected 1 to {len(faces)}")
                parts.append((name, face, cells[:, list(faces[number])]))
        return parts

    def _free_faces(self, elements: IntArray) -> list[tuple[str, IntArray]]:
        """Faces of solid elements that no other element has."""
        if self._free is None:
            self._free = self._lone_faces()
        found: list[tuple[str, IntArray]] = []
        for k, rows in self._split(elements):
            kind, cells = self.blocks[k]
            if kind in FACES and CELLS[kind].dimension == 3:
                face, faces = FACES[kind]
                for column, nodes in enumerate(faces.values()):
                    chosen = rows[self._free[k][rows, column] == 1]
                    found.append((face, cells[chosen][:, list(nodes)]))
        return found

    def _lone_faces(self) -> list[IntArray]:
        """How many elements have each face of the elements of each block."""
        keys, shapes = [], []
        for kind, cells in self.blocks:
            faces = FACES[kind][1] if kind in FACES and CELLS[kind].dimension == 3 else {}
            corners = 3 if kind in ("tetra", "tetra10") else 4
            shapes.append((len(cells), len(faces)))
            if faces:
                nodes = np.array([list(face[:corners]) for face in faces.values()])
                every = np.sort(cells[:, nodes].reshape(-1, corners), axis=1)
                keys.append(np.pad(every, ((0, 0), (0, 4 - corners)), constant_values=-1))
        if not keys:
            return [np.zeros(shape, dtype=np.int64) for shape in shapes]
        _, inverse, counts = np.unique(np.concatenate(keys), axis=0, return_inverse=True, return_counts=True)
        every_count = counts[inverse.ravel()]
        ends = np.cumsum([rows * columns for rows, columns in shapes])[:-1]
        return [part.reshape(shape) for part, shape in zip(np.split(every_count, ends), shapes, strict=True)]


def _named(sets: dict[str, MemberSet], name: str) -> MemberSet:
    if name.upper() not in sets:
        raise Unreadable(f"a set holds {shown(name)}, expected a set that is there")
    return sets[name.upper()]
