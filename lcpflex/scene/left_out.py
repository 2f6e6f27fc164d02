"""What "everything against everything" leaves out: pairs of surfaces without a contact, and bodies without a surface.

What the user has left out, by ``exclude`` or by a joint, is never told. Pairs are counted by the kinds of their
surfaces, not one by one: of thousands of surfaces there are millions.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from itertools import islice
from typing import Any, NamedTuple

from lcpflex.basics.arguments import listed
from lcpflex.errors import ModelError
from lcpflex.scene.contact_rules import Pairs, excluded_pairs, pairs_apart
from lcpflex.scene.declared import ContactRule, DeclaredContact
from lcpflex.scene.placed_surface import PlacedSurface

__all__ = ["LeftOut", "pairs_left_out"]

NAMED = 3  # pairs that are named of each two kinds


class LeftOut(NamedTuple):
    """What is said of a scene."""

    warnings: tuple[str, ...] = ()  # what may pass through each other, or fall through everything
    notes: tuple[str, ...] = ()


def pairs_left_out(
    placed: Sequence[Any],
    surfaces: Sequence[PlacedSurface],
    declared: Mapping[str, DeclaredContact],
    rules: Sequence[ContactRule],
    joints: Sequence[Any],
    loads: Sequence[Any],
    weighs: bool,
) -> LeftOut:
    """What rules leave out that may meet, in words.

    surfaces: those that the rules are for. weighs: whether there is gravity.

    Raises
    ------
    ModelError
        For a body that weighs, that no joint and no load holds, and whose surfaces have no contact with any other, so
        that it falls through those that it meets.
    """
    if not rules:
        return LeftOut()
    table = _Table(surfaces, declared, rules, joints)
    free = _unheld(placed, joints, loads) if weighs else []
    for together in free:
        table.refuse_unsupported(together)
    bare = {one.body for one in placed} - {surface.body for surface in surfaces}
    unseen = [together for together in free if bare.issuperset(one.body for one in together)]
    falling = {one.body for together in unseen for one in together}
    warnings = [*table.told()]
    if falling:
        warnings.append(
            f"contact_all: nothing holds and nothing touches {_names(placed, falling)}, without a surface: expected "
            "one of what shall not fall through all others"
        )
    still = bare - falling
    notes = (f"contact_all: nothing touches {_names(placed, still)}, without a surface",) if still else ()
    return LeftOut(tuple(warnings), notes)


def _names(placed: Sequence[Any], bodies: Collection[int]) -> str:
    return listed(one.name for one in placed if one.body in bodies)


def _unheld(placed: Sequence[Any], joints: Sequence[Any], loads: Sequence[Any]) -> list[list[Any]]:
    """Bodies that joints and springs hold together, where neither the ground nor a force holds them."""
    leader = {one.body: one.body for one in placed} | {-1: -1}

    def lead(body: int) -> int:
        while leader[body] != body:
            leader[body] = leader[leader[body]]  # halves the way for those that ask again
            body = leader[body]
        return body

    for part in (*joints, *loads):
        Q = getattr(part, "Q", None)
        first, second = lead(part.P.body), lead(-1 if Q is None else Q.body)  # a force may hold what it acts on
        leader[max(first, second)] = min(first, second)
    together: dict[int, list[Any]] = {}
    for one in placed:
        together.setdefault(lead(one.body), []).append(one)
    return [bodies for leading, bodies in together.items() if leading >= 0]


class _Table:
    """Surfaces by their kinds, and the pairs of them that are the user's own will."""

    def __init__(
        self,
        surfaces: Sequence[PlacedSurface],
        declared: Mapping[str, DeclaredContact],
        rules: Sequence[ContactRule],
        joints: Sequence[Any],
    ) -> None:
        self.surfaces = surfaces
        self.willed: Pairs = pairs_apart(surfaces, declared, joints)
        self.willed |= set.intersection(*(excluded_pairs(rule, surfaces) for rule in rules))
        self.by_declaration = {surface.body for contact in declared.values() for surface in contact.pair}
        self.of_kind: dict[Any, list[int]] = {}
        self.of_body: dict[int, list[int]] = {}
        for k, surface in enumerate(surfaces):
            self.of_kind.setdefault(surface.shape.kind, []).append(k)
            self.of_body.setdefault(surface.body, []).append(k)
        self.per_body = Counter((surface.body, surface.shape.kind) for surface in surfaces)
        self.barred: Counter[tuple[int, Any]] = Counter()  # of a surface, how many of a kind on others it may not meet
        for i, j in self.willed:
            if surfaces[i].body != surfaces[j].body:
                self.barred[i, surfaces[j].shape.kind] += 1
                self.barred[j, surfaces[i].shape.kind] += 1

    def shape(self, kind: Any) -> Any:
        """One of that kind: which kinds touch each other is the same for all."""
        return self.surfaces[self.of_kind[kind][0]].shape

    def partners(self, k: int, kind: Any) -> int:
        """How many surfaces of a kind a surface may meet: on other bodies, and none that the user has left out."""
        own = self.per_body[self.surfaces[k].body, kind]
        return len(self.of_kind[kind]) - own - self.barred[k, kind]

    def pairs(self, firsts: Iterable[int], kind: Any) -> Iterator[tuple[int, int]]:
        """Pairs of one of ``firsts`` and a surface of that kind that the user has not left out."""
        for i in firsts:
            if self.partners(i, kind):
                for j in self.of_kind[kind]:
                    apart = self.surfaces[i].body != self.surfaces[j].body
                    if apart and (min(i, j), max(i, j)) not in self.willed:
                        yield i, j

    def told(self) -> Iterator[str]:
        """A warning for each two kinds that have no contact, and may meet."""
        kinds = list(self.of_kind)
        for n, first in enumerate(kinds):
            for second in kinds[n:]:
                a, b = self.shape(first), self.shape(second)
                if a.can_touch(b) or not a.can_meet(b):
                    continue
                count = sum(self.partners(k, second) for k in self.of_kind[first])
                pairs = self.pairs(self.of_kind[first], second)
                if first is second:  # each has been met from both sides
                    count //= 2
                    pairs = (pair for pair in pairs if pair[0] < pair[1])
                if count:
                    yield (
                        f"contact_all: a {first.value} has no contact with a {second.value} and passes through it: "
                        f"{self._named(pairs, count)}; exclude what may, or give one of them another surface"
                    )

    def refuse_unsupported(self, together: Sequence[Any]) -> None:
        """Raise ModelError for bodies whose surfaces might meet others, and have no contact with any."""
        if any(one.body in self.by_declaration for one in together):
            return
        inside = {one.body for one in together}
        own = [k for body in inside for k in self.of_body.get(body, ())]
        for k in own:
            for kind in self.of_kind:
                if self.surfaces[k].shape.can_touch(self.shape(kind)) and self.partners(k, kind):
                    return
        met = (pair for k in own for kind in self.of_kind for pair in self.pairs([k], kind))
        pairs = [(i, j) for i, j in met if self.surfaces[j].body not in inside]
        if pairs:
            which = listed(one.name for one in together)
            partners = "; ".join(dict.fromkeys(self.surfaces[k].shape.partners() for k in own))
            raise ModelError(
                f"contact_all: {which} would fall through all that there is: nothing holds it, and there is no contact "
                f"between {self._named(iter(pairs), len(pairs))}; expected {partners}; or exclude=[...] of what it may "
                "pass through"
            )

    def _named(self, pairs: Iterator[tuple[int, int]], count: int) -> str:
        """The first of so many pairs of surfaces, by their labels."""
        texts = [f"{self.surfaces[i].label!r} and {self.surfaces[j].label!r}" for i, j in islice(pairs, NAMED)]
        return ", ".join(texts) + (f" and {count - NAMED} more" if count > NAMED else "")
