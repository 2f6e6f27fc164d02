"""The declared contacts of a spatial scene as arrays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from lcpflex.bodies.spatial.surface import CODES, RANKS, Pass, SpatialKind
from lcpflex.compile.spatial.assembly import SpatialAssembly
from lcpflex.compile.spatial.contact_sides import Carrying, Side, carrying_of, side_of, sides_of_contact
from lcpflex.compile.spatial.contact_surfaces import bounds_of, boxes_of, deflections, features_of
from lcpflex.compile.spatial.feature_tree import FeatureTree, tree_of
from lcpflex.compile.spatial.features import Feature
from lcpflex.compile.spatial.polygons import Polygon, polygons_of
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.model.arrays import frozen
from lcpflex.model.spatial import SpatialContacts, no_spatial_contacts
from lcpflex.scene.contact_rules import KeptRule
from lcpflex.scene.declared import DeclaredContact
from lcpflex.scene.placed_surface import PlacedSurface

__all__ = ["compile_spatial_contacts"]


def compile_spatial_contacts(
    declared: Mapping[str, DeclaredContact],
    surfaces: Sequence[PlacedSurface],
    assembly: SpatialAssembly,
    rule: KeptRule | None = None,
    before: int = 0,
) -> SpatialContacts:
    """Arrays of the contacts, and of all surfaces: those without a contact are drawn, too.

    ``rule``: one that is not listed; its contacts come after so many of the ``declared``.
    """
    used = {side.key: side for side in map(side_of, (*(rule.surfaces if rule else ()), *surfaces))}
    pairs = [sides_of_contact(contact) for contact in declared.values()]
    used.update((side.key, side) for pair in pairs for side in pair)
    if not used:
        return no_spatial_contacts()
    number = {key: k for k, key in enumerate(used)}
    shapes = [side.surface.shape for side in used.values()]
    parts = _parts(list(used.values()), assembly)
    spheres = np.array([bounds_of(shape) for shape in shapes])
    passes = [
        (number[pair[one.node_side].key], number[pair[one.touched].key], one.mode, law)
        for law, (contact, pair) in enumerate(zip(declared.values(), pairs, strict=True))
        for one in _passes(contact)
    ]
    sides = [[number[side.key] for side in pair] for pair in pairs]
    laws = np.array([(c.friction, c.restitution, c.tangential_restitution) for c in declared.values()]).reshape(-1, 3)
    ints = np.int64
    contacts = no_spatial_contacts()._replace(
        surface_kind=frozen([CODES[shape.kind] for shape in shapes], ints),
        surface_body=frozen([side.surface.body for side in used.values()], ints),
        surface_center=frozen(spheres[:, :3], columns=3),
        surface_extent=frozen(spheres[:, 3]),
        surface_deflection=frozen(deflections(shapes)),
        **parts,
        pass_node=frozen([a for a, _, _, _ in passes], ints),
        pass_feature=frozen([b for _, b, _, _ in passes], ints),
        pass_mode=frozen([mode for _, _, mode, _ in passes], ints),
        pass_law=frozen([law for _, _, _, law in passes], ints),
        friction=frozen(laws[:, 0]),
        restitution=frozen(laws[:, 1]),
        tangential_restitution=frozen(laws[:, 2]),
        law_surface=frozen(sides, ints, columns=2),
    )
    return contacts if rule is None else _with_rule(contacts, rule, before)


def _with_rule(contacts: SpatialContacts, rule: KeptRule, before: int) -> SpatialContacts:
    """The arrays with a rule for the first surfaces, whose law is the last one."""
    numbers, n = rule.rule, len(rule.surfaces)
    barred = np.array(rule.barred, dtype=np.int64).reshape(-1, 2)
    return contacts._replace(
        friction=frozen([*contacts.friction, numbers.friction]),
        restitution=frozen([*contacts.restitution, numbers.restitution]),
        tangential_restitution=frozen([*contacts.tangential_restitution, numbers.tangential_restitution]),
        law_surface=frozen([*contacts.law_surface, (-1, -1)], np.int64, columns=2),
        rule_rank=frozen([RANKS[kind] for kind in contacts.surface_kind[:n]], np.int64),
        rule_law=frozen([len(contacts.friction)], np.int64),
        rule_pass=frozen([np.count_nonzero(contacts.pass_law < before)], np.int64),
        barred_start=frozen(np.searchsorted(barred[:, 0], np.arange(n + 1)), np.int64),
        barred=frozen(barred[:, 1], np.int64),
    )


def _passes(contact: DeclaredContact) -> tuple[Pass, ...]:
    """What is looked at for a declared contact, 0: the first of its surfaces."""
    a, b = contact.pair
    chosen = None if contact.node_side is None else int(contact.node_side.label != a.label)
    passes: tuple[Pass, ...] = a.shape.passes(b.shape, chosen)
    return passes


def _parts(sides: Sequence[Side], assembly: SpatialAssembly) -> dict[str, Any]:
    """Nodes and features of the surfaces, and the boxes about these."""
    nodes: list[Carrying] = []
    features: list[Feature] = []
    trees: list[FeatureTree] = []
    node_start, feature_start = [0], [0]
    faces: list[list[Polygon]] = []  # of each surface
    cells: list[list[int]] = []
    for side in sides:
        surface = side.surface
        indices = [assembly.point(surface.body, point) for point in surface.shape.points]
        own = features_of(surface.shape, indices, len(features))
        place = dict(zip(indices, (point.place for point in surface.shape.points), strict=True))
        trees.append(tree_of(*boxes_of(own, place)))
        features += [f._replace(cell=f.cell + len(cells)) if f.cell >= 0 else f for f in own]
        cells += [[indices[k] for k in cell] for cell in surface.shape.cells]
        faces.append([])
        if surface.shape.kind is SpatialKind.POLYHEDRON:
            more, faces[-1] = polygons_of(surface.shape, indices, own, feature_start[-1], sum(map(len, faces)))
            features += more
        nodes.append(carrying_of(side, indices, assembly))
        node_start.append(node_start[-1] + len(nodes[-1].points))
        feature_start.append(len(features))
    boxes = np.cumsum([0, *(len(tree.skip) for tree in trees)])
    listed = np.cumsum([0, *(len(tree.order) for tree in trees)])  # polygons are in no box
    ints = np.int64
    fans = [f.fan for f in features]
    return {
        "node_start": frozen(node_start, ints),
        "node_point": frozen([point for one in nodes for point in one.points], ints),
        "node_radius": frozen(np.concatenate([one.radii for one in nodes])),
        "node_normal": frozen(np.concatenate([one.normals for one in nodes]), columns=3),
        "node_facing": frozen(np.concatenate([one.facings for one in nodes])),
        "feature_start": frozen(feature_start, ints),
        "feature_kind": frozen([f.kind for f in features], ints),
        "feature_point": frozen([f.points for f in features], ints, columns=3),
        "feature_radius": frozen([f.radius for f in features]),
        "feature_depth": frozen([f.depth for f in features]),
        "feature_neighbour": frozen([f.neighbour for f in features], ints, columns=3),
        "fan_start": frozen(np.cumsum([0, *map(len, fans)]), ints),
        "fan": frozen([point for fan in fans for point in fan], ints),
        "box_start": frozen(boxes, ints),
        "box": frozen(np.concatenate([tree.box for tree in trees]), columns=6),
        "box_skip": frozen(_shifted([tree.skip for tree in trees], boxes), ints),
        "box_leaf": frozen(_shifted([tree.leaf for tree in trees], listed), ints, columns=2),
        "box_feature": frozen(_shifted([tree.order for tree in trees], feature_start), ints),
        **_polygons(faces, node_start),
        **(_faces(nodes, cells, features) if cells else {}),
    }


def _faces(nodes: Sequence[Carrying], cells: Sequence[Sequence[int]], features: Sequence[Feature]) -> dict[str, Any]:
    """Faces of elements, and the samples that nodes and areas of open faces are means of."""
    ints = np.int64
    firsts = np.cumsum([0, *(len(one.samples) for one in nodes)])
    of_nodes = [own + first for one, first in zip(nodes, firsts[:-1], strict=True) for own in one.areas]
    samples = [sample for one in nodes for sample in one.samples]
    return {
        "cell_start": frozen(np.cumsum([0, *map(len, cells)]), ints),
        "cell_point": frozen([point for cell in cells for point in cell], ints),
        "feature_cell": frozen([f.cell for f in features], ints),
        "node_area": frozen(np.concatenate([one.pressed for one in nodes])),
        "node_spread": frozen(np.concatenate([one.spread for one in nodes]), columns=6),
        "node_share": frozen(np.concatenate([_parts_of_face(one) for one in nodes])),
        "area_start": frozen(np.cumsum([0, *map(len, of_nodes)]), ints),
        "area_sample": frozen(np.concatenate([*of_nodes, np.zeros(0, ints)]), ints),
        "area_share": frozen(np.concatenate([*(share for one in nodes for share in one.shares), np.zeros(0)])),
        "sample_start": frozen(np.cumsum([0, *(len(points) for points, _ in samples)]), ints),
        "sample_point": frozen(np.concatenate([*(points for points, _ in samples), np.zeros(0, ints)]), ints),
        "sample_weight": frozen(np.concatenate([*(weights for _, weights in samples), np.zeros(0)])),
        "sample_normal": frozen(np.concatenate([one.outward for one in nodes]), columns=3),
    }


def _parts_of_face(carrying: Carrying) -> FloatArray:
    """What part of a face is about each of its nodes, so that a law is that of all of it; 1 of other nodes."""
    if not carrying.shares:
        return np.ones(len(carrying.points))
    own = np.array([share.sum() for share in carrying.shares])
    return np.asarray(own / own.sum())


def _polygons(faces: Sequence[Sequence[Polygon]], node_start: Sequence[int]) -> dict[str, Any]:
    """The faces of each surface, whose corners are its nodes, in their order."""
    every = [polygon for own in faces for polygon in own]
    nodes = [first + corner for own, first in zip(faces, node_start, strict=False) for p in own for corner in p.corners]
    sides = np.cumsum([0, *(len(polygon.corners) for polygon in every)])
    of_side = np.repeat(np.arange(len(every)), np.diff(sides))
    about = np.argsort(np.array(nodes, dtype=np.int64), kind="stable")
    starts = np.cumsum([0, *(len(own) for own in faces)])
    beside: list[dict[int, list[int]]] = [{} for _ in faces]
    for number, own in enumerate(faces):
        for k, polygon in enumerate(own):
            for edge in polygon.edges:
                beside[number].setdefault(edge, []).append(int(starts[number]) + k)
    ints = np.int64
    return {
        "polygon_start": frozen(starts, ints),
        "polygon_feature": frozen([polygon.feature for polygon in every], ints),
        "polygon_plane": frozen([polygon.plane for polygon in every], columns=4),
        "side_start": frozen(sides, ints),
        "side_node": frozen(nodes, ints),
        "side_edge": frozen([edge for polygon in every for edge in polygon.edges], ints),
        "side_beside": frozen(_beside(every, of_side, beside), ints),
        "side_across": frozen([point for polygon in every for point in polygon.across], ints),
        "corner_start": frozen(np.searchsorted(np.array(nodes)[about], np.arange(node_start[-1] + 1)), ints),
        "corner_polygon": frozen(of_side[about], ints),
        "ridge_start": frozen(np.cumsum([0, *map(len, beside)]), ints),
        "ridge_edge": frozen([edge for own in beside for edge in own], ints),
        "ridge_polygon": frozen([pair for own in beside for pair in own.values()], ints, columns=2),
    }


def _beside(polygons: Sequence[Polygon], of_side: IntArray, beside: Sequence[Mapping[int, Sequence[int]]]) -> list[int]:
    """The polygon on the other side of each side."""
    pairs = {edge: pair for own in beside for edge, pair in own.items()}
    edges = [edge for polygon in polygons for edge in polygon.edges]
    return [sum(pairs[edge]) - own for edge, own in zip(edges, of_side.tolist(), strict=True)]


def _shifted(parts: Sequence[IntArray], offsets: Sequence[int] | IntArray) -> IntArray:
    """All parts, each by its offset."""
    return np.concatenate([part + offset for part, offset in zip(parts, offsets[:-1], strict=True)])
