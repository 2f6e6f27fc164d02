"""Contacts as they are declared, checked; and those of "everything against everything"."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any, NamedTuple

from lcpflex.errors import ModelError, in_range, shown
from lcpflex.force_laws.law import Law
from lcpflex.scene.declared import ContactRule, DeclaredContact
from lcpflex.scene.face_contacts import check_apart, check_once, finer_of, is_face, later_choices, touching_points
from lcpflex.scene.placed_body import PlacedBody
from lcpflex.scene.placed_surface import PlacedSurface, check_own

__all__ = ["ByRules", "KeptRule", "Pairs", "by_rules", "contact_between", "excluded_pairs", "pairs_apart", "rule_of"]

LISTED = (
    32  # surfaces up to which the pairs of a rule are listed: to look at each costs less than to look for near ones
)


@dataclass(frozen=True, slots=True, eq=False)
class KeptRule:
    """A rule that is not listed pair by pair."""

    rule: ContactRule
    surfaces: tuple[PlacedSurface, ...]  # that it is for
    barred: tuple[tuple[int, int], ...]  # pairs of them that it is not for, the earlier surface first, ascending

    def first_contacts(self, bodies: Collection[int]) -> dict[str, DeclaredContact]:
        """One contact of each surface of these bodies, by name: what tells how the surface may be touched."""
        barred = set(self.barred)
        found = {}
        for i, a in enumerate(self.surfaces):
            if a.body not in bodies:
                continue
            for j, b in enumerate(self.surfaces):
                pair = (i, j) if i < j else (j, i)
                if a.body != b.body and a.shape.can_touch(b.shape) and pair not in barred:
                    name, contact = _by_rule(self.rule, *(self.surfaces[k] for k in pair))
                    found[name] = contact
                    break
        return found

    def check_faces(self, declared: Mapping[str, DeclaredContact]) -> None:
        """Raise ModelError where the rule is for the whole surface of a body whose face touches the same partner."""
        barred = set(self.barred)
        for name, contact in declared.items():
            if not any(map(is_face, contact.pair)):
                continue
            mine, theirs = ([k for k, s in enumerate(self.surfaces) if s.body == one.body] for one in contact.pair)
            for i, j in product(mine, theirs):
                pair = self.surfaces[i], self.surfaces[j]
                if pair[0].shape.can_touch(pair[1].shape) and (min(i, j), max(i, j)) not in barred:
                    check_apart(f"contact {name!r}", contact.pair, "that of contact_all", pair)


class ByRules(NamedTuple):
    """What rules make of a scene."""

    contacts: dict[str, DeclaredContact]  # by name
    kept: KeptRule | None  # the first rule, where its pairs are not listed
    surfaces: tuple[PlacedSurface, ...]  # that rules are for; none without rules


def by_rules(
    placed: Sequence[Any],
    surfaces: Sequence[PlacedSurface],
    declared: Mapping[str, DeclaredContact],
    rules: Sequence[ContactRule],
    joints: Sequence[Any],
    listed: bool = True,
) -> ByRules:
    """The contacts that "everything against everything" adds, by name; an earlier rule has precedence.

    Where they are many, and not to be ``listed``, the first rule is not: its contacts are those between all surfaces
    but for some pairs. Contacts by a force law remember what they went through, each one for itself: they are listed.
    """
    check_once(declared)
    if not rules:
        return ByRules({}, None, ())
    outlines = [p.surface() for p in placed if p.has_outline]
    candidates = (*outlines, *surfaces)
    kept = rules[0].law is None and len(candidates) > LISTED and not listed
    taken = pairs_apart(candidates, declared, joints)
    excluded = [excluded_pairs(rule, candidates) for rule in rules]
    faces = {k for k, one in enumerate(candidates) if is_face(one)}
    if faces:
        own = pairs_apart(candidates, declared, ())
        taken |= later_choices(
            candidates, lambda pair: pair in own or (pair not in taken and any(pair not in one for one in excluded))
        )
    first: KeptRule | None = None
    if kept:
        first = _kept(rules[0], candidates, taken | excluded[0], faces)
        pairs: Iterable[tuple[int, int]] = sorted(excluded[0] | _between(faces, range(len(candidates))))
    else:
        pairs = [(i, j) for i in range(len(candidates)) for j in range(i + 1, len(candidates))]
    found = {}
    for rule, left_out in zip(rules, excluded, strict=True):
        for pair in pairs:
            a, b = (candidates[k] for k in pair)
            if a.body != b.body and pair not in taken and a.shape.can_touch(b.shape) and pair not in left_out:
                taken.add(pair)
                name, contact = _by_rule(rule, a, b)
                found[name] = contact
    if faces:
        check_once({**declared, **found})
        if first is not None:
            first.check_faces(declared)
    whole = {surface.body for surface in outlines}
    told = tuple(one for k, one in enumerate(candidates) if k not in faces or one.body not in whole)
    return ByRules(found, first, told)


def _kept(rule: ContactRule, candidates: Sequence[PlacedSurface], barred: Pairs, faces: Collection[int]) -> KeptRule:
    """The rule for all candidates but faces, whose pairs are listed."""
    plain = [k for k in range(len(candidates)) if k not in faces]
    number = dict(zip(plain, range(len(plain)), strict=True))
    pairs = sorted((number[i], number[j]) for i, j in barred if i in number and j in number)
    return KeptRule(rule, tuple(candidates[k] for k in plain), tuple(pairs))


def _by_rule(rule: ContactRule, a: PlacedSurface, b: PlacedSurface) -> tuple[str, DeclaredContact]:
    numbers = (rule.friction, rule.restitution, rule.tangential_restitution)
    node_side = finer_of(a, b) if is_face(a) and is_face(b) else None
    points = touching_points(a, b, node_side, None)
    return f"{a.label}/{b.label}", DeclaredContact((a, b), *numbers, node_side, rule.law, points)


Pairs = set[tuple[int, int]]


def _between(a: Iterable[int], b: Collection[int]) -> Pairs:
    """All pairs of one of each, the earlier first."""
    return {(min(i, j), max(i, j)) for i in a for j in b if i != j}


def pairs_apart(
    candidates: Sequence[PlacedSurface], declared: Mapping[str, DeclaredContact], joints: Sequence[Any]
) -> Pairs:
    """Pairs that no rule is for: declared by themselves, or of two bodies with a joint between them."""
    number = {surface.label: k for k, surface in enumerate(candidates)}
    pairs = ([number.get(surface.label, -1) for surface in contact.pair] for contact in declared.values())
    found = {(min(pair), max(pair)) for pair in pairs if min(pair) >= 0}
    of_body = _of_bodies(candidates)
    for joint in joints:
        if joint.P.body >= 0 and joint.Q.body >= 0:
            found |= _between(of_body.get(joint.P.body, ()), of_body.get(joint.Q.body, ()))
    return found


def _of_bodies(candidates: Sequence[PlacedSurface]) -> dict[int, list[int]]:
    of_body: dict[int, list[int]] = {}
    for k, surface in enumerate(candidates):
        of_body.setdefault(surface.body, []).append(k)
    return of_body


def excluded_pairs(rule: ContactRule, candidates: Sequence[PlacedSurface]) -> Pairs:
    """Pairs that a rule excludes."""
    number = {surface.label: k for k, surface in enumerate(candidates)}
    of_body = _of_bodies(candidates)

    def meant(side: PlacedBody | PlacedSurface) -> Collection[int]:
        if isinstance(side, PlacedBody):
            return of_body.get(side.body, ())
        return [number[side.label]] if side.label in number else ()

    found: Pairs = set()
    for x, y in rule.exclude:
        found |= _between(meant(x), meant(y))
    return found


def contact_between(
    scene: object,
    between: Mapping[frozenset[str], str],
    a: PlacedSurface,
    b: PlacedSurface,
    friction: float,
    restitution: float,
    tangential_restitution: float,
    node_side: PlacedSurface | None,
    law: Law | None,
    points: str | None = None,
) -> DeclaredContact:
    """What :meth:`lcpflex.scene.scene.Scene.contact` declares; or ModelError.

    between: names of the contacts of the scene, by the labels of their two surfaces. points: what a face touches with,
    see :func:`touching_points`. Of two faces the node side is known, chosen or not.
    """
    for argument, surface in (("a", a), ("b", b)):
        if not isinstance(surface, PlacedSurface):
            raise ModelError(
                f"{argument}: {shown(surface)} was given, expected a surface such as body.surface() or a method of "
                "scene.ground"
            )
        check_own(scene, argument, surface)
    if a.label == b.label:
        raise ModelError(f"contact: {a.label!r} was given twice, expected two surfaces")
    if a.body == b.body:
        where = "on the ground" if a.body < 0 else "on the same body"
        raise ModelError(f"contact: {a.label!r} and {b.label!r} are both {where}, expected surfaces of two bodies")
    if not a.shape.can_touch(b.shape):
        raise ModelError(
            f"contact: {a.label!r} (a {a.shape.kind.value}) and {b.label!r} (a {b.shape.kind.value}) were given, "
            f"which cannot touch each other, expected {a.shape.partners()}"
        )
    other = between.get(frozenset((a.label, b.label)))
    if other is not None:
        raise ModelError(f"contact: {a.label!r} and {b.label!r} were given twice, {shown(other)} is between them")
    numbers = _numbers(friction, restitution, tangential_restitution, law)
    _check_node_side(node_side, a, b)
    chosen = touching_points(a, b, node_side, points)
    if node_side is None and is_face(a) and is_face(b):
        node_side = finer_of(a, b)
    return DeclaredContact((a, b), *numbers, node_side, law, chosen)


def rule_of(
    scene: object,
    friction: float,
    restitution: float,
    tangential_restitution: float,
    exclude: Sequence[tuple[Any, Any]],  # of bodies and surfaces
    law: Law | None,
) -> ContactRule:
    """What :meth:`lcpflex.scene.scene.Scene.contact_all` declares; or ModelError."""
    if not isinstance(exclude, list | tuple):
        raise ModelError(f"exclude: {shown(exclude)} was given, expected a list of pairs of bodies or surfaces")
    for pair in exclude:
        sides = pair if isinstance(pair, tuple | list) else ()
        if len(sides) != 2 or not all(isinstance(side, PlacedBody | PlacedSurface) for side in sides):
            raise ModelError(f"exclude: {shown(pair)} was given, expected pairs of bodies or surfaces")
        for side in pair:
            check_own(scene, "exclude", side)
    numbers = _numbers(friction, restitution, tangential_restitution, law)
    return ContactRule(*numbers, tuple((x, y) for x, y in exclude), law)


def _check_node_side(node_side: PlacedSurface | None, a: PlacedSurface, b: PlacedSurface) -> None:
    """Raise ModelError for a node side that is neither a nor b, or that cannot be that of the other one."""
    if node_side is None:
        return
    chosen = node_side.label if isinstance(node_side, PlacedSurface) and node_side.scene is a.scene else ""
    if chosen not in (a.label, b.label):
        given = repr(node_side.label) if isinstance(node_side, PlacedSurface) else shown(node_side)
        raise ModelError(f"node_side: {given} was given, expected one of the two surfaces, {a.label!r} or {b.label!r}")
    other = b if chosen == a.label else a
    if not node_side.shape.can_be_node_side(other.shape):
        raise ModelError(
            f"node_side: {node_side.label!r} (a {node_side.shape.kind.value}) was given for {other.label!r} (a "
            f"{other.shape.kind.value}), expected {node_side.shape.node_sides()}"
        )


def _numbers(
    friction: float, restitution: float, tangential_restitution: float, law: Law | None
) -> tuple[float, float, float]:
    """Friction and restitution, checked, with ``law``."""
    if not isinstance(law, Law | None):
        raise ModelError(f"law: {shown(law)} was given, expected a force law such as Penalty(stiffness=1e6), or None")
    for name, value in (("restitution", restitution), ("tangential_restitution", tangential_restitution)):
        if law is not None and value != 0.0:
            raise ModelError(f"{name}: {shown(value)} was given with a law, expected 0: its damping makes the rebound")
    return (
        in_range("friction", friction, 0.0, math.inf),
        in_range("restitution", restitution, 0.0, 1.0),
        in_range("tangential_restitution", tangential_restitution, 0.0, 1.0),
    )
