"""A compiled scene with the pairs of its rule listed that have touched in a run: what results and checks read."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from lcpflex.bodies.surface import BOTH, NO_NODE
from lcpflex.compile.compiled_scene import CompiledScene
from lcpflex.contact.rule_pairs import TOUCHES
from lcpflex.jit.kernel import IntArray
from lcpflex.model.arrays import frozen

__all__ = ["pair_of", "with_pairs"]

Pair = tuple[int, int]  # surfaces, the earlier first


def with_pairs(compiled: CompiledScene, pairs: Sequence[Pair]) -> tuple[CompiledScene, IntArray]:
    """The scene with ``pairs`` (ascending) as declared contacts, where the rule stands among them.

    Besides, of each contact of the new scene, its number among the old ones; of pairs -1 - their place in ``pairs``.
    The rule holds for the others still.
    """
    model, layout = compiled.model, compiled.layout
    contacts = model.contacts
    before = 1 + int(contacts.pass_law[: contacts.rule_pass[0]].max(initial=-1))
    old = np.concatenate([np.arange(before), -1 - np.arange(len(pairs)), np.arange(before, len(layout.contacts))])
    names = [layout.pair_name(*pair) for pair in pairs]
    listed = replace(layout, contacts=(*layout.contacts[:before], *names, *layout.contacts[before:]))
    laws = (*compiled.laws[:before], *(None for _ in pairs), *compiled.laws[before:])
    model = model._replace(contacts=_with_passes(contacts, pairs, before))
    return replace(compiled, model=model, layout=listed, laws=laws), old


def _with_passes(contacts: Any, pairs: Sequence[Pair], before: int) -> Any:
    rank, count = contacts.rule_rank, len(pairs)
    passes = [(a, b, mode, law) for law, pair in enumerate(pairs, before) for a, b, mode in _passes(contacts, *pair)]
    added = np.array(passes, dtype=np.int64).reshape(-1, 4)
    at = int(contacts.rule_pass[0])
    shifted = np.where(contacts.pass_law >= before, contacts.pass_law + count, contacts.pass_law)
    in_space = hasattr(contacts, "pass_mode")
    mode = contacts.pass_mode if in_space else np.zeros_like(shifted)
    old = (contacts.pass_node, contacts.pass_feature, mode, shifted)
    columns = [np.concatenate([one[:at], more, one[at:]]) for one, more in zip(old, added.T, strict=True)]
    start = contacts.barred_start
    owners = np.concatenate([np.repeat(np.arange(len(rank)), np.diff(start)), [i for i, _ in pairs]]).astype(np.int64)
    others = np.concatenate([contacts.barred, [j for _, j in pairs]]).astype(np.int64)
    order = np.lexsort((others, owners))
    numbers = {
        name: frozen(np.insert(values, before, np.full(count, values[contacts.rule_law[0]])))
        for name in ("friction", "restitution", "tangential_restitution")
        for values in (getattr(contacts, name),)
    }
    if in_space:
        numbers["pass_mode"] = frozen(columns[2], np.int64)
        sides = np.array(pairs, dtype=np.int64).reshape(-1, 2)
        numbers["law_surface"] = frozen(np.insert(contacts.law_surface, before, sides, axis=0), np.int64)
    return contacts._replace(
        pass_node=frozen(columns[0], np.int64),
        pass_feature=frozen(columns[1], np.int64),
        pass_law=frozen(columns[3], np.int64),
        rule_law=frozen(contacts.rule_law + count, np.int64),
        rule_pass=frozen(contacts.rule_pass + len(passes), np.int64),
        barred_start=frozen(np.searchsorted(owners[order], np.arange(len(rank) + 1)), np.int64),
        barred=frozen(others[order], np.int64),
        **numbers,
    )


def _passes(contacts: Any, i: int, j: int) -> list[tuple[int, int, int]]:
    """(node side, touched side, mode) of a pair of surfaces of the rule."""
    rank = contacts.rule_rank
    if hasattr(contacts, "pass_mode"):  # in space
        from lcpflex.bodies.spatial.surface import passes_of

        kinds = int(contacts.surface_kind[i]), int(contacts.surface_kind[j])
        sizes = [int(contacts.node_start[s + 1] - contacts.node_start[s]) for s in (i, j)]
        deform = bool(contacts.surface_deflection[[i, j]].any())
        found = passes_of(kinds, deform, (sizes[0], sizes[1]))
        return [((i, j)[one.node_side], (i, j)[one.touched], one.mode) for one in found]
    first = (i, j, 0) if rank[i] <= rank[j] else (j, i, 0)
    both = BOTH <= rank[i] < NO_NODE and BOTH <= rank[j] < NO_NODE
    return [first, (j, i, 0)] if both else [first]


def _can_touch(contacts: Any, i: int, j: int) -> bool:
    """Whether surfaces of these kinds can touch."""
    if hasattr(contacts, "pass_mode"):
        from lcpflex.bodies.spatial.surface import TOUCHES as IN_SPACE

        kinds, touches = contacts.surface_kind, IN_SPACE
    else:
        kinds, touches = contacts.rule_rank, TOUCHES
    return bool(touches[kinds[i], kinds[j]] or touches[kinds[j], kinds[i]])


def pair_of(compiled: CompiledScene, name: str) -> Pair | None:
    """The surfaces of a pair that the rule of a scene is for, by the name of their contact; None for other names."""
    number = {label: k for k, label in enumerate(compiled.layout.rule_surfaces)}
    contacts = compiled.model.contacts
    for k, letter in enumerate(name):
        i, j = (number.get(label, -1) for label in (name[:k], name[k + 1 :])) if letter == "/" else (-1, -1)
        if i < 0 or not i < j:
            continue
        barred = contacts.barred[contacts.barred_start[i] : contacts.barred_start[i + 1]]
        apart = contacts.surface_body[i] != contacts.surface_body[j]
        if apart and _can_touch(contacts, i, j) and j not in barred:
            return i, j
    return None
