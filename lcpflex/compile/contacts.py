"""The declared contacts of a scene as arrays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from lcpflex.compile.assembly import Assembly
from lcpflex.compile.contact_surfaces import compile_surfaces
from lcpflex.model.arrays import Contacts, frozen
from lcpflex.scene.contact_rules import KeptRule
from lcpflex.scene.declared import DeclaredContact
from lcpflex.scene.placed_surface import PlacedSurface

__all__ = ["compile_contacts"]


def compile_contacts(
    declared: Mapping[str, DeclaredContact],
    surfaces: Sequence[PlacedSurface],
    assembly: Assembly,
    rule: KeptRule | None = None,
    before: int = 0,
) -> Contacts:
    """Arrays of the contacts, and of all surfaces: those without a contact are drawn, too.

    ``rule``: one that is not listed; its contacts come after so many of the ``declared``.
    """
    used = {s.label: s for s in (*(rule.surfaces if rule else ()), *surfaces)}
    for contact in declared.values():
        used.update((s.label, s) for s in contact.pair)
    number = {label: k for k, label in enumerate(used)}
    contacts = compile_surfaces(
        [(s.body, s.shape) for s in used.values()],
        [
            (number[c.pair[0].label], number[c.pair[1].label], c.friction, c.restitution, c.tangential_restitution)
            for c in declared.values()
        ],
        assembly.points,
        {law: number[c.node_side.label] for law, c in enumerate(declared.values()) if c.node_side is not None},
    )
    return contacts if rule is None else _with_rule(contacts, rule, before)


def _with_rule(contacts: Contacts, rule: KeptRule, before: int) -> Contacts:
    """The arrays with a rule for the first surfaces, whose law is the last one."""
    numbers = rule.rule
    barred = np.array(rule.barred, dtype=np.int64).reshape(-1, 2)
    ranks = [surface.shape.rank for surface in rule.surfaces]
    return contacts._replace(
        friction=frozen([*contacts.friction, numbers.friction]),
        restitution=frozen([*contacts.restitution, numbers.restitution]),
        tangential_restitution=frozen([*contacts.tangential_restitution, numbers.tangential_restitution]),
        rule_rank=frozen(ranks, np.int64),
        rule_law=frozen([len(contacts.friction)], np.int64),
        rule_pass=frozen([np.count_nonzero(contacts.pass_law < before)], np.int64),
        barred_start=frozen(np.searchsorted(barred[:, 0], np.arange(len(ranks) + 1)), np.int64),
        barred=frozen(barred[:, 1], np.int64),
    )
