"""Contacts as they are declared, checked; and those of "everything against everything"."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from lcpflex.bodies.surface import can_be_node_side, can_touch
from lcpflex.errors import ModelError, in_range, shown
from lcpflex.force_laws.law import Law
from lcpflex.scene.declared import ContactRule, DeclaredContact
from lcpflex.scene.handles import Placed
from lcpflex.scene.joints.joint import Joint
from lcpflex.scene.placed_surface import PlacedSurface, check_own

__all__ = ["by_rules", "contact_between", "rule_of"]


def by_rules(
    placed: Sequence[Placed],
    surfaces: Sequence[PlacedSurface],
    declared: Mapping[str, DeclaredContact],
    rules: Sequence[ContactRule],
    joints: Sequence[Joint],
) -> dict[str, DeclaredContact]:
    """The contacts that "everything against everything" adds, by name; an earlier rule has precedence."""
    if not rules:
        return {}
    outlines = [p.surface() for p in placed if p.source and "outline" in p.source.surfaces]
    candidates = [*outlines, *surfaces]
    taken = {frozenset(surface.label for surface in contact.pair) for contact in declared.values()}
    jointed = {frozenset((joint.P.body, joint.Q.body)) for joint in joints if joint.P.body >= 0 and joint.Q.body >= 0}
    found = {}
    for rule in rules:
        for i, a in enumerate(candidates):
            for b in candidates[i + 1 :]:
                pair = frozenset((a.label, b.label))
                apart = a.body != b.body and frozenset((a.body, b.body)) not in jointed
                if apart and pair not in taken and can_touch(a.shape, b.shape) and not _excluded(rule, a, b):
                    taken.add(pair)
                    numbers = (rule.friction, rule.restitution, rule.tangential_restitution)
                    found[f"{a.label}/{b.label}"] = DeclaredContact((a, b), *numbers, law=rule.law)
    return found


def _excluded(rule: ContactRule, a: PlacedSurface, b: PlacedSurface) -> bool:
    def matches(side: Placed | PlacedSurface, surface: PlacedSurface) -> bool:
        return side.body == surface.body if isinstance(side, Placed) else side.label == surface.label

    return any((matches(x, a) and matches(y, b)) or (matches(x, b) and matches(y, a)) for x, y in rule.exclude)


def contact_between(
    scene: object,
    contacts: Mapping[str, DeclaredContact],
    a: PlacedSurface,
    b: PlacedSurface,
    friction: float,
    restitution: float,
    tangential_restitution: float,
    node_side: PlacedSurface | None,
    law: Law | None,
) -> DeclaredContact:
    """What :meth:`lcpflex.scene.scene.Scene.contact` declares beside the ``contacts`` of the scene; or ModelError."""
    for argument, surface in (("a", a), ("b", b)):
        if not isinstance(surface, PlacedSurface):
            raise ModelError(
                f"{argument}: {shown(surface)} was given, expected a surface such as body.surface() or "
                "scene.ground.half_plane((0, 0), (0, 1))"
            )
        check_own(scene, argument, surface)
    if a.label == b.label:
        raise ModelError(f"contact: {a.label!r} was given twice, expected two surfaces")
    if a.body == b.body:
        where = "on the ground" if a.body < 0 else "on the same body"
        raise ModelError(f"contact: {a.label!r} and {b.label!r} are both {where}, expected surfaces of two bodies")
    if not can_touch(a.shape, b.shape):
        raise ModelError(
            f"contact: {a.label!r} (a {a.shape.kind.value}) and {b.label!r} (a {b.shape.kind.value}) were given, "
            "which cannot touch each other, expected a node, disc or chain on one side"
        )
    for other, declared in contacts.items():
        if {a.label, b.label} == {surface.label for surface in declared.pair}:
            raise ModelError(f"contact: {a.label!r} and {b.label!r} were given twice, {shown(other)} is between them")
    numbers = _numbers(friction, restitution, tangential_restitution, law)
    _check_node_side(node_side, a, b)
    return DeclaredContact((a, b), *numbers, node_side, law)


def rule_of(
    scene: object,
    friction: float,
    restitution: float,
    tangential_restitution: float,
    exclude: Sequence[tuple[Placed | PlacedSurface, Placed | PlacedSurface]],
    law: Law | None,
) -> ContactRule:
    """What :meth:`lcpflex.scene.scene.Scene.contact_all` declares; or ModelError."""
    if not isinstance(exclude, list | tuple):
        raise ModelError(f"exclude: {shown(exclude)} was given, expected a list of pairs of bodies or surfaces")
    for pair in exclude:
        sides = pair if isinstance(pair, tuple | list) else ()
        if len(sides) != 2 or not all(isinstance(side, Placed | PlacedSurface) for side in sides):
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
    if not can_be_node_side(node_side.shape, other.shape):
        raise ModelError(
            f"node_side: {node_side.label!r} (a {node_side.shape.kind.value}) was given for {other.label!r} (a "
            f"{other.shape.kind.value}), expected a node, disc, solid arc or chain, and no node for the other one"
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
