"""Contacts of faces: what of a face touches, which of two faces it is, and that no part of a body touches twice.

Of two faces the finer one touches the other with its areas or nodes: areas that are smaller than what they lie on
follow it, larger ones pass over what is between their middles.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import combinations
from typing import TYPE_CHECKING, Any

from lcpflex.basics.arguments import one_of
from lcpflex.errors import ModelError, shown
from lcpflex.scene.face_sizes import face_area, sizes_where_near

if TYPE_CHECKING:
    from lcpflex.scene.declared import DeclaredContact
    from lcpflex.scene.placed_surface import PlacedSurface

__all__ = [
    "check_apart",
    "check_once",
    "doubtful_node_sides",
    "finer_of",
    "is_face",
    "later_choices",
    "touching_points",
]

WHOLE = ".surface"  # what labels of whole surfaces end with
POINTS = ("areas", "nodes")
EQUAL = 1e-6  # of the area of a sub-face: rounding
COARSER = 1.25  # of the areas: with 10 elements an edge on 9 (1.23) stress is as good either way, with 4 on 3 it is not
SIMPLE = ("PLANE", "SPHERE", "HOLE", "CYLINDER", "CAPSULE")  # kinds that nodes of linear facets follow exactly


def is_face(surface: PlacedSurface) -> bool:
    """Whether a surface is a face of a mesh."""
    return bool(getattr(surface.shape, "cells", ()))


def finer_of(a: PlacedSurface, b: PlacedSurface) -> PlacedSurface:
    """The face with the smaller sub-faces, of graded ones where they are near each other; the first of equal ones."""
    own, other = sizes_where_near(a, b)
    return b if other < own * (1.0 - EQUAL) else a


def touching_points(a: PlacedSurface, b: PlacedSurface, node_side: PlacedSurface | None, points: Any) -> str:
    """What a face touches with: "areas" or "nodes"; "" where neither surface is one.

    points: what was chosen, None for nodes of linear facets on planes, spheres and cylinders, and areas of others.

    Raises
    ------
    ModelError
        For other words, and a choice for surfaces that are no faces.
    """
    chosen = None if points is None else one_of("points", points, POINTS)
    faces = [one for one in (a, b) if is_face(one)]
    if not faces:
        if chosen is not None:
            raise ModelError(
                f"points: {shown(points)} was given for {a.label!r} and {b.label!r}, expected it for a face of a body, "
                "body.face(name)"
            )
        return ""
    own = faces[0] if len(faces) == 1 else node_side or finer_of(a, b)
    other = b if own.label == a.label else a
    simple = other.shape.kind.name in SIMPLE and all(len(cell) <= 4 for cell in own.shape.cells)
    return chosen or ("nodes" if simple else "areas")


def doubtful_node_sides(contacts: Mapping[str, DeclaredContact]) -> Iterator[str]:
    """A warning for each contact of two faces that the coarser one touches, or the larger one with its nodes."""
    for name, contact in contacts.items():
        if all(is_face(one) for one in contact.pair) and contact.node_side is not None:
            own = contact.node_side
            other = next(one for one in contact.pair if one.label != own.label)
            coarse, fine = sizes_where_near(own, other)
            if coarse > fine * COARSER:
                yield (
                    f"contact {name!r}: node_side {own.label!r} is the coarser face, with sub-faces of {coarse:.3g} "
                    f"m^2 on those of {fine:.3g} m^2 of {other.label!r}: pressures come out several times less "
                    "accurate than with the finer face as node_side, which is the default"
                )
            if contact.points == "nodes" and face_area(own.shape) > face_area(other.shape) * (1.0 + EQUAL):
                yield (
                    f"contact {name!r}: the nodes of {own.label!r} touch {other.label!r}, which is smaller: what of it "
                    "is between a node on it and one beside it is not felt; expected points='areas', which share it, "
                    "or the smaller face as node_side"
                )


Pair = tuple[int, int]


def later_choices(candidates: Sequence[PlacedSurface], allowed: Callable[[Pair], bool]) -> set[Pair]:
    """Pairs with a face that rules are not for, as the whole surface of its body meets the same partner.

    candidates: the surfaces that rules are for. allowed: whether a contact or a rule is for a pair of them, the earlier
    first. Whole surfaces come first, then two faces, then a face and a whole surface.
    """
    whole = {one.body: k for k, one in enumerate(candidates) if one.label.endswith(WHOLE)}
    faces: dict[int, list[int]] = {one.body: [] for one in candidates}
    for k, one in enumerate(candidates):
        if is_face(one):
            faces[one.body].append(k)

    def meet(i: int | None, j: int | None) -> bool:
        if i is None or j is None or candidates[i].body == candidates[j].body:
            return False
        return candidates[i].shape.can_touch(candidates[j].shape) and allowed((min(i, j), max(i, j)))

    barred: set[Pair] = set()
    for k in (k for own in faces.values() for k in own):
        mine = whole.get(candidates[k].body)
        for j, other in enumerate(candidates):
            theirs = whole.get(other.body)
            if is_face(other):
                covered = meet(mine, theirs)
            elif j == theirs:
                covered = meet(mine, j) or any(meet(k, face) for face in faces[other.body])
            else:
                covered = meet(mine, j)
            if covered:
                barred.add((min(k, j), max(k, j)))
    return barred


def check_once(contacts: Mapping[str, DeclaredContact]) -> None:
    """Raise ModelError where a face touches what a face with the same facets, or its whole body, touches as well."""
    groups: dict[frozenset[int], list[tuple[str, tuple[PlacedSurface, PlacedSurface]]]] = {}
    for name, contact in contacts.items():
        groups.setdefault(frozenset(one.body for one in contact.pair), []).append((name, contact.pair))
    for group in groups.values():
        if any(is_face(one) for _, pair in group for one in pair):
            for (name, pair), (other, second) in combinations(group, 2):
                check_apart(f"contact {name!r}", pair, f"contact {other!r}", second)


def check_apart(
    first: str, pair: tuple[PlacedSurface, PlacedSurface], second: str, other: tuple[PlacedSurface, PlacedSurface]
) -> None:
    """Raise ModelError for two contacts with a face that are for the same facets on both sides."""
    a, b = pair
    c, d = other if other[0].body == a.body else other[::-1]
    if any(map(is_face, (a, b, c, d))) and _share(a, c) and _share(b, d):
        raise ModelError(
            f"contact: {first} of {a.label!r} and {b.label!r} and {second} of {c.label!r} and {d.label!r} are both for "
            "the same facets, expected one of them: what touches would count twice (contact_all takes "
            "exclude=[(body.surface(), other)])"
        )


def _share(a: PlacedSurface, b: PlacedSurface) -> bool:
    """Whether surfaces of one body are one, or have facets in common: with a face, the whole surface has."""
    if a.label == b.label:
        return True
    if is_face(a) and is_face(b):
        return not _facets(a).isdisjoint(_facets(b))
    return any(is_face(one) and other.label.endswith(WHOLE) for one, other in ((a, b), (b, a)))


def _facets(surface: PlacedSurface) -> set[frozenset[int]]:
    """The corners of each facet, by the numbers of nodes of the mesh."""
    nodes = [point.made_at for point in surface.shape.points]
    return {frozenset(nodes[k] for k in cell.tolist()) for cell in surface.shape.cells}
