"""Input files of Abaqus and CalculiX: nodes, elements, sets and surfaces, of a model or an assembly of parts.

Steps, materials, loads and all else are passed over.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from lcpflex.bodies.fem.files.abaqus_model import Model, Scope, model_of
from lcpflex.bodies.fem.files.abaqus_sets import Body, Sets
from lcpflex.bodies.fem.files.abaqus_text import keywords_of
from lcpflex.bodies.fem.files.abaqus_types import ordered
from lcpflex.bodies.fem.files.found import CELLS, FoundMesh, Part, Unreadable, grouped
from lcpflex.bodies.fem.files.numbering import Numbering, joined
from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["read_abaqus"]


def read_abaqus(path: Path, source: str) -> FoundMesh:
    """The mesh in an input file; raises Unreadable for anything else.

    Sets of an instance are called by their own names, or "instance.set" where several have that name; sets that a
    program keeps for itself (INTERNAL) are left out.

    source: what the mesh is called in messages.
    """
    model = model_of(keywords_of(path))
    places, blocks, bodies = _joined(model)
    if not len(places):
        raise Unreadable("it has no *NODE, expected nodes")
    sets = Sets(bodies, blocks)
    mesh_blocks = [(kind, cells) for kind, cells in blocks if kind is not None]
    nodes, sources = _groups(sets)
    groups = grouped(nodes, sources, {kind for kind, cells in mesh_blocks if len(cells)})
    return FoundMesh(places, mesh_blocks, groups, source)


def _joined(model: Model) -> tuple[FloatArray, list[tuple[str | None, IntArray]], dict[str, Body]]:
    """Places and elements of all scopes one after another, and where each begins."""
    places: list[FloatArray] = []
    blocks: list[tuple[str | None, IntArray]] = []
    bodies: dict[str, Body] = {}
    node = element = 0
    for key, scope in (("", model.root), *model.instances.items()):
        of = f" of {scope.name!r}" if scope.name else ""
        nodes = Numbering(joined(scope.numbers), f"node{of}")
        elements = Numbering(joined([block.numbers for block in scope.blocks]), f"element{of}")
        bodies[key] = Body(scope, nodes, elements, node, element)
        own = np.concatenate([np.zeros((0, 3)), *scope.places])
        for block in scope.blocks:
            cells = nodes.known(block.cells, f"*ELEMENT {block.where}{of}")
            if block.kind is not None:
                cells = ordered(block.kind, cells, own, block.where)
            blocks.append((block.kind, cells + node))
        places.append(own)
        node, element = node + nodes.count, element + elements.count
    return np.concatenate(places), blocks, bodies


def _scopes(sets: Sets) -> Iterator[tuple[Body, Scope]]:
    return ((body, body.scope) for body in sets.bodies.values())


def _groups(sets: Sets) -> tuple[dict[str, IntArray], list[list[Part]]]:
    """Sets of nodes by name; and elements and faces, as parts of groups."""
    nodes: dict[str, IntArray] = {}
    elements: list[Part] = []
    faces: list[Part] = []
    of_nodes = Counter(key for _, scope in _scopes(sets) for key in scope.node_sets)
    of_elements = Counter(key for _, scope in _scopes(sets) for key in scope.element_sets)
    of_surfaces = Counter(key for _, scope in _scopes(sets) for key in scope.surfaces)
    for body, scope in _scopes(sets):
        for key, of in scope.node_sets.items():
            if not of.internal:
                nodes.setdefault(_name(scope, of.name, of_nodes[key]), sets.nodes_of(body, of))
    for body, scope in _scopes(sets):
        for key, of in scope.element_sets.items():
            if not of.internal:
                name = _name(scope, of.name, of_elements[key])
                parts = sets.parts_of(name, sets.elements_of(body, of))
                if len({CELLS[kind].dimension for _, kind, _ in parts}) > 1:  # of beams and solids, say
                    nodes.setdefault(name, joined([cells.ravel() for _, _, cells in parts]))
                else:
                    elements.extend(parts)
    for body, scope in _scopes(sets):
        for key, surface in scope.surfaces.items():
            name = _name(scope, surface.name, of_surfaces[key])
            if surface.internal:
                continue
            if surface.of_nodes:
                nodes.setdefault(name, sets.surface_nodes(body, surface))
            else:
                faces.extend(sets.surface_parts(name, body, surface))
    return nodes, [elements, faces]


def _name(scope: Scope, name: str, count: int) -> str:
    return f"{scope.name}.{name}" if scope.name and count > 1 else name
