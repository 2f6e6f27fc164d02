"""The declared contacts of a scene as arrays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from lcpflex.compile.assembly import Assembly
from lcpflex.compile.contact_surfaces import compile_surfaces
from lcpflex.model.arrays import Contacts
from lcpflex.scene.declared import DeclaredContact
from lcpflex.scene.placed_surface import PlacedSurface

__all__ = ["compile_contacts"]


def compile_contacts(
    declared: Mapping[str, DeclaredContact], surfaces: Sequence[PlacedSurface], assembly: Assembly
) -> Contacts:
    """Arrays of the contacts, and of all surfaces: those without a contact are drawn, too."""
    used = {s.label: s for s in surfaces}
    for contact in declared.values():
        used.update((s.label, s) for s in contact.pair)
    number = {label: k for k, label in enumerate(used)}
    return compile_surfaces(
        [(s.body, s.shape) for s in used.values()],
        [
            (number[c.pair[0].label], number[c.pair[1].label], c.friction, c.restitution, c.tangential_restitution)
            for c in declared.values()
        ],
        assembly.points,
        {law: number[c.node_side.label] for law, c in enumerate(declared.values()) if c.node_side is not None},
    )
