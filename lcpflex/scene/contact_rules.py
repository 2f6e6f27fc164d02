"""The contacts of "everything against everything"."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from lcpflex.scene.declared import ContactRule, DeclaredContact
from lcpflex.scene.handles import Placed, PlacedSurface, can_touch
from lcpflex.scene.joints.joint import Joint

__all__ = ["by_rules"]


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
                if apart and pair not in taken and can_touch(a, b) and not _excluded(rule, a, b):
                    taken.add(pair)
                    numbers = (rule.friction, rule.restitution, rule.tangential_restitution)
                    found[f"{a.label}/{b.label}"] = DeclaredContact((a, b), *numbers, law=rule.law)
    return found


def _excluded(rule: ContactRule, a: PlacedSurface, b: PlacedSurface) -> bool:
    def matches(side: Placed | PlacedSurface, surface: PlacedSurface) -> bool:
        return side.body == surface.body if isinstance(side, Placed) else side.label == surface.label

    return any((matches(x, a) and matches(y, b)) or (matches(x, b) and matches(y, a)) for x, y in rule.exclude)
