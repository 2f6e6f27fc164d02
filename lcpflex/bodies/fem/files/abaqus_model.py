"""Nodes, elements, sets and surfaces of an Abaqus model: of parts, of their instances, of the assembly."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from lcpflex.bodies.fem.files.abaqus_data import (
    Member,
    element_table,
    first_numbers,
    instance_motion,
    members,
    node_table,
    pairs,
)
from lcpflex.bodies.fem.files.abaqus_text import Keyword
from lcpflex.bodies.fem.files.abaqus_types import kind_of
from lcpflex.bodies.fem.files.found import Unreadable
from lcpflex.errors import shown
from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["ElementBlock", "MemberSet", "Model", "Scope", "Surface", "model_of"]

MAKERS = ("NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY")  # keywords that make nodes or elements of others
INSTANCES = 100_000
NODES = 10_000_000  # of all instances: a few lines may ask for any number


@dataclass(slots=True)
class MemberSet:
    """A set of nodes or elements by what it holds. internal: a name of the program's, not of the user's."""

    name: str
    internal: bool = False
    members: list[Member] = field(default_factory=list)


@dataclass(slots=True)
class Surface:
    """Sets, elements or nodes with the names of their faces. of_nodes: the members are nodes."""

    name: str
    internal: bool = False
    of_nodes: bool = False
    members: list[tuple[str, str]] = field(default_factory=list)


@dataclass(frozen=True, slots=True, eq=False)
class ElementBlock:
    """Elements of one kind (None: no part of a mesh), their numbers, and the numbers of their nodes."""

    kind: str | None
    numbers: IntArray
    cells: IntArray
    where: str


@dataclass(slots=True)
class Scope:
    """What has numbers and names of its own: the model, a part, an instance. Names are found by their capitals."""

    name: str = ""
    numbers: list[IntArray] = field(default_factory=list)
    places: list[FloatArray] = field(default_factory=list)
    blocks: list[ElementBlock] = field(default_factory=list)
    node_sets: dict[str, MemberSet] = field(default_factory=dict)
    element_sets: dict[str, MemberSet] = field(default_factory=dict)
    surfaces: dict[str, Surface] = field(default_factory=dict)

    def copy(self, name: str) -> Scope:
        """A scope of that name with all of this one, to which more can be added."""
        return Scope(
            name,
            list(self.numbers),
            list(self.places),
            list(self.blocks),
            {key: MemberSet(s.name, s.internal, list(s.members)) for key, s in self.node_sets.items()},
            {key: MemberSet(s.name, s.internal, list(s.members)) for key, s in self.element_sets.items()},
            {key: Surface(s.name, s.internal, s.of_nodes, list(s.members)) for key, s in self.surfaces.items()},
        )

    def move(self, rotation: FloatArray, shift: FloatArray) -> None:
        """Put all nodes elsewhere."""
        self.places = [places @ rotation.T + shift for places in self.places]


@dataclass(slots=True)
class Model:
    """The model itself, its parts and their instances by their names in capitals."""

    root: Scope = field(default_factory=Scope)
    parts: dict[str, Scope] = field(default_factory=dict)
    instances: dict[str, Scope] = field(default_factory=dict)
    copied: int = 0  # nodes of parts in all instances


def model_of(keywords: Iterable[Keyword]) -> Model:
    """The model that the keywords describe; raises Unreadable for what is none, or has no mesh of its own."""
    model = Model()
    scope, motion = model.root, None
    for keyword in keywords:
        if keyword.name == "PART":
            scope = _new(model.parts, keyword.option("NAME"), keyword)
        elif keyword.name == "INSTANCE":
            scope, motion = _instance(model, keyword), instance_motion(keyword)
        elif keyword.name in ("END PART", "END INSTANCE"):
            if motion is not None:
                scope.move(*motion)
            scope, motion = model.root, None
        else:
            _add(scope, keyword)
    if scope is not model.root:
        raise Unreadable(f"it ends in {shown(scope.name)}, expected *END PART or *END INSTANCE")
    if not model.instances and model.parts:
        if len(model.parts) > 1 or model.root.numbers:
            names = ", ".join(shown(part.name) for part in list(model.parts.values())[:4])
            raise Unreadable(f"it has parts {names} and no *INSTANCE of them, expected an assembly")
        model.instances = dict(model.parts)
    return model


def _new(scopes: dict[str, Scope], name: str, keyword: Keyword) -> Scope:
    if name.upper() in scopes:
        raise Unreadable(f"*{keyword.name} {keyword.where} has the name {shown(name)} of another, expected its own")
    scopes[name.upper()] = Scope(name)
    return scopes[name.upper()]


def _instance(model: Model, keyword: Keyword) -> Scope:
    name, part = keyword.option("NAME"), keyword.options.get("PART", "")
    if part.upper() not in model.parts:
        raise Unreadable(f"*INSTANCE {keyword.where} is of part {shown(part)}, expected a part that is there")
    if len(model.instances) >= INSTANCES:
        raise Unreadable(f"it has more than {INSTANCES} instances, expected fewer")
    _new(model.instances, name, keyword)
    model.instances[name.upper()] = model.parts[part.upper()].copy(name)
    model.copied += sum(len(numbers) for numbers in model.parts[part.upper()].numbers)
    if model.copied > NODES:
        raise Unreadable(f"its instances have more than {NODES} nodes, expected fewer")
    return model.instances[name.upper()]


def _add(scope: Scope, keyword: Keyword) -> None:
    if keyword.name == "NODE":
        numbers, places = node_table(keyword)
        scope.numbers.append(numbers)
        scope.places.append(places)
        if keyword.options.get("NSET"):
            _set(scope.node_sets, keyword.options["NSET"], keyword).append(Member(numbers=numbers))
    elif keyword.name == "ELEMENT":
        _add_elements(scope, keyword)
    elif keyword.name == "NSET":
        of = _set(scope.node_sets, keyword.option("NSET"), keyword)
        of.extend(members(keyword))
        if keyword.options.get("ELSET"):
            instance = keyword.options.get("INSTANCE", "")
            of.append(Member(name=keyword.options["ELSET"], instance=instance, of_elements=True))
    elif keyword.name == "ELSET":
        _set(scope.element_sets, keyword.option("ELSET"), keyword).extend(members(keyword))
    elif keyword.name == "SURFACE":
        _add_surface(scope, keyword)
    elif keyword.name in MAKERS or (keyword.name == "SYSTEM" and keyword.data):
        raise Unreadable(f"*{keyword.name} {keyword.where} makes nodes or elements, expected them written out")


def _add_elements(scope: Scope, keyword: Keyword) -> None:
    kind = kind_of(keyword.option("TYPE"), keyword.where)
    if kind is None:
        numbers = first_numbers(keyword)
        cells = np.zeros((len(numbers), 0), dtype=np.int64)
    else:
        numbers, cells = element_table(keyword, kind)
    scope.blocks.append(ElementBlock(kind, numbers, cells, keyword.where))
    if keyword.options.get("ELSET"):
        _set(scope.element_sets, keyword.options["ELSET"], keyword).append(Member(numbers=numbers))


def _set(sets: dict[str, MemberSet], name: str, keyword: Keyword) -> list[Member]:
    return sets.setdefault(name.upper(), MemberSet(name, "INTERNAL" in keyword.options)).members


def _add_surface(scope: Scope, keyword: Keyword) -> None:
    kind = keyword.options.get("TYPE", "ELEMENT").upper()
    if kind not in ("ELEMENT", "NODE") or "COMBINE" in keyword.options:
        return  # analytical surfaces, cuts, and sums and differences of others: no group
    name = keyword.option("NAME")
    key = f"{kind} {name.upper()}"  # one of nodes and one of faces may have the same name
    surface = scope.surfaces.setdefault(key, Surface(name, "INTERNAL" in keyword.options, kind == "NODE"))
    surface.members.extend(pairs(keyword))
