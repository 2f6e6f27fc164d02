"""The declared contacts of a spatial scene as arrays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from lcpflex.bodies.spatial.surface import CODES
from lcpflex.compile.spatial.assembly import SpatialAssembly
from lcpflex.compile.spatial.contact_surfaces import Feature, bounds_of, deflections, features_of, nodes_of
from lcpflex.model.arrays import frozen
from lcpflex.model.spatial import SpatialContacts, no_spatial_contacts
from lcpflex.scene.declared import DeclaredContact
from lcpflex.scene.placed_surface import PlacedSurface

__all__ = ["compile_spatial_contacts"]


def compile_spatial_contacts(
    declared: Mapping[str, DeclaredContact], surfaces: Sequence[PlacedSurface], assembly: SpatialAssembly
) -> SpatialContacts:
    """Arrays of the contacts, and of all surfaces: those without a contact are drawn, too."""
    used = {s.label: s for s in surfaces}
    for contact in declared.values():
        used.update((s.label, s) for s in contact.pair)
    if not used:
        return no_spatial_contacts()
    number = {label: k for k, label in enumerate(used)}
    shapes = [surface.shape for surface in used.values()]
    nodes: list[tuple[int, float]] = []
    features: list[Feature] = []
    node_start, feature_start = [0], [0]
    for surface in used.values():
        indices = [assembly.point(surface.body, point) for point in surface.shape.points]
        nodes += nodes_of(surface.shape, indices)
        features += features_of(surface.shape, indices)
        node_start.append(len(nodes))
        feature_start.append(len(features))
    spheres = np.array([bounds_of(shape) for shape in shapes])
    passes = [
        (number[a.label], number[b.label], law)
        for law, contact in enumerate(declared.values())
        for a, b in _passes(contact)
    ]
    sides = [[number[side.label] for side in contact.pair] for contact in declared.values()]
    laws = np.array([(c.friction, c.restitution, c.tangential_restitution) for c in declared.values()]).reshape(-1, 3)
    ints = np.int64
    return no_spatial_contacts()._replace(
        surface_kind=frozen([CODES[shape.kind] for shape in shapes], ints),
        surface_body=frozen([surface.body for surface in used.values()], ints),
        surface_center=frozen(spheres[:, :3], columns=3),
        surface_extent=frozen(spheres[:, 3]),
        surface_deflection=frozen(deflections(shapes)),
        node_start=frozen(node_start, ints),
        node_point=frozen([point for point, _ in nodes], ints),
        node_radius=frozen([radius for _, radius in nodes]),
        feature_start=frozen(feature_start, ints),
        feature_kind=frozen([f.kind for f in features], ints),
        feature_point=frozen([f.points for f in features], ints, columns=3),
        feature_radius=frozen([f.radius for f in features]),
        feature_depth=frozen([f.depth for f in features]),
        feature_neighbour=frozen([f.neighbour for f in features], ints, columns=3),
        pass_node=frozen([a for a, _, _ in passes], ints),
        pass_feature=frozen([b for _, b, _ in passes], ints),
        pass_law=frozen([law for _, _, law in passes], ints),
        friction=frozen(laws[:, 0]),
        restitution=frozen(laws[:, 1]),
        tangential_restitution=frozen(laws[:, 2]),
        law_surface=frozen(sides, ints, columns=2),
    )


def _passes(contact: DeclaredContact) -> list[tuple[PlacedSurface, PlacedSurface]]:
    """(node surface, feature surface) pairs of a declared contact; one only where a node side is chosen."""
    a, b = contact.pair
    if contact.node_side is not None:
        return [(a, b) if contact.node_side.label == a.label else (b, a)]
    return [(contact.pair[i], contact.pair[j]) for i, j in a.shape.passes(b.shape)]
