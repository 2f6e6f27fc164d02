"""Contacts by a continuous force law in runs of steppers whose other contacts are rigid: what is refused and said.

Such a stepper takes them as forces (:mod:`lcpflex.dynamics.contact_forces`). Their history is that of the impact.
"""

from __future__ import annotations

from collections.abc import Sequence

from lcpflex.dynamics.contact_forces_history import update_history
from lcpflex.dynamics.workspace import Workspace
from lcpflex.errors import ModelError, shown
from lcpflex.force_laws.history import ContactMemory
from lcpflex.force_laws.layout import LIMIT
from lcpflex.jit.kernel import FloatArray
from lcpflex.steppers.system import System

__all__ = [
    "begin_laws",
    "friction_warnings",
    "law_trouble",
    "law_warnings",
    "refuse_laws",
    "refuse_states",
    "too_deep",
]

LASTING = 0.1  # share of the run in which a contact is closed: a shorter one is an impact
MISSED = 0.05  # of mu times the normal force: mean error of friction from which a run warns


def refuse_laws(system: System, stepper: str, instead: str) -> None:
    """Raise ModelError for compliant contacts, which ``stepper`` has no place for."""
    for name, law in zip(system.names, system.laws, strict=False):
        if law is not None:
            raise ModelError(
                f"stepper: {stepper} was given for contact {name!r} with a force law, expected EventDriven, MoreauJean "
                f"or Smooth: {instead}"
            )


def refuse_states(system: System) -> None:
    """Raise ModelError for laws with states that only ``Smooth`` advances."""
    for name, law in zip(system.names, system.laws, strict=False):
        if law is None:
            continue
        row = law.row()
        if row.bristles:
            what = "friction with states of its own"
        elif row.turns:
            what = "a permanent indentation, which turns back within steps"
        else:
            continue
        raise ModelError(
            f"law: {shown(law)} of contact {name!r} has {what}, expected a law without it beside rigid contacts: "
            "Smooth takes it, with a law for every contact"
        )


def begin_laws(system: System, work: Workspace) -> None:
    """The history of compliant contacts at the start."""
    if system.is_compliant:
        update_history(system.model, 0.0, system.q, system.u, 0.0, True, work.compliant.states, work)


def law_warnings(names: Sequence[str], memory: ContactMemory) -> list[str]:
    """A warning for each contact that has left the range of its law with the consent of the user."""
    limits = memory.parameters[:, LIMIT]
    return [
        f"the indentation of contact {name!r} has reached {worst:.4g} m, beyond the {limit:.4g} m up to which its "
        "law is valid"
        for name, worst, limit, stop in zip(names, memory.worst, limits, memory.stop, strict=False)
        if stop > limit and worst > limit
    ]


def friction_warnings(names: Sequence[str], impulses: FloatArray | None, pressed: FloatArray) -> list[str]:
    """A warning for each lasting compliant contact whose friction was not that of its slip at the end of the steps.

    ``impulses``: ``missed`` of :class:`lcpflex.dynamics.compliant_contacts.CompliantContacts`; ``pressed``: share of
    the run that each contact was closed. In an impact the slip adapts within a few steps, and its friction is right
    where it counts.
    """
    if impulses is None:
        return []
    return [
        f"the friction of contact {name!r} is off by {100.0 * missed / most:.3g} % of mu times its normal force, on "
        "the mean: steps of Moreau-Jean balance it contact by contact, without the rigid contacts that "
        "hold the same bodies; take shorter steps, or EventDriven, which takes them all together"
        for name, (missed, most), share in zip(names, impulses.tolist(), pressed.tolist(), strict=False)
        if missed > MISSED * most and share > LASTING
    ]


def law_trouble(names: Sequence[str], work: Workspace) -> str:
    """Why a run cannot go on after compliant contacts have taken note."""
    contacts = work.compliant
    if contacts.needed:
        return f"more than {len(contacts.rows.table.key)} pairs of compliant contacts are near at once"
    return too_deep(names, contacts.history, contacts.out_of_range)


def too_deep(names: Sequence[str], memory: ContactMemory, law: int) -> str:
    """That a contact is deeper than its law is valid, or exists."""
    return (
        f"the indentation of contact {names[law]!r} is {memory.worst[law]:.4g} m, its law is valid up to "
        f"{memory.stop[law]:.4g} m: see the range of validity of its elastic law"
    )
