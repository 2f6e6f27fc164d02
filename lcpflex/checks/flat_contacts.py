"""Flat and curved contacts of a run of bodies with modes, and the stepper that suits them better than its own.

Counted are the points that touch at stored instants of the push that transfers most impulse. Where most of those that
ever touch in it do so at once, the contact is flat (:mod:`lcpflex.checks.first_touch`). At once must be no more than a
sixteenth of the push, in which the force of a ball or a roller grows to a fifth, and its points to less than half:
where modes answer no faster, or less was stored, nothing is told.

A massless boundary keeps the energy that the inertia of a face would take as it closes, and its force rings with it. It
has no such energy where points close one by one, and takes longer steps there than schemes that meet each as an impact.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from lcpflex.checks.first_touch import AT_ONCE, half_period, is_flat
from lcpflex.checks.resolution import bodies_of, hardest_push, held_modes, surfaces_of
from lcpflex.checks.resolution_rules import PAIRS
from lcpflex.compile.compiled_scene import CompiledScene
from lcpflex.results.result import Result

__all__ = ["with_flat_contacts"]

SOON = 1.0 / 16.0  # of a push
BY_IMPACTS = ("MoreauJean", "GeneralizedAlpha")  # take what closes in a step as an impact


class Closing(NamedTuple):
    """Points of a contact that touched at once as a push began, and the most that ever did in it."""

    at_once: int
    points: int
    within: float  # [s] of the first
    flat: bool


def with_flat_contacts(result: Result) -> Result:
    """The same with what is to be said of its contacts, where another stepper suits them better."""
    warned, told = _flat_and_massless(result), _pointwise_and_massive(result)
    return replace(result, warnings=(*result.warnings, *warned), notes=(*result.notes, *told))


def _flat_and_massless(result: Result) -> tuple[str, ...]:
    """A warning of each flat contact of a run with a massless boundary: what its force is, and what to take instead."""
    if not result.stepper.startswith("MasslessBoundary"):
        return ()
    return tuple(
        f"contact {name!r} is flat ({closing.at_once} of its {closing.points} points closed within "
        f"{closing.within:.2g} s): over a massless boundary its force rings, by as much as its mean; keep the "
        "displacements of its nodes (boundary=, Craig and Bampton; without friction those along the normal alone) and "
        "take MoreauJean(step, theta=0.55), or GeneralizedAlpha(step, rho_inf=0.5)"
        for name, closing in _closings(result)
        if closing.flat
    )


def _pointwise_and_massive(result: Result) -> tuple[str, ...]:
    """A note where contacts whose points close one by one were stepped with the inertia of many residual modes."""
    compiled = result.compiled
    if compiled is None or not result.stepper.startswith(BY_IMPACTS) or not _takes_massless(compiled):
        return ()
    many = {b for b, (_, of_contacts) in enumerate(compiled.layout.residual) if of_contacts >= PAIRS}
    found = [
        name
        for name, closing in (_closings(result) if many else ())
        if not closing.flat and closing.points > 1 and many & set(_touching(result, compiled, name))
    ]
    if not found:
        return ()
    return (
        f"contact {found[0]!r}{f' and {len(found) - 1} more' if len(found) > 1 else ''}: points close one by one, on "
        "residual modes: MasslessBoundary takes such contacts as accurately in steps two to ten times as long",
    )


def _takes_massless(compiled: CompiledScene) -> bool:
    """Whether the contacts of a scene are such that a massless boundary may carry them."""
    contacts = compiled.model.contacts
    bounces = contacts.restitution.any() or contacts.tangential_restitution.any()
    return not bounces and not any(compiled.laws)


def _touching(result: Result, compiled: CompiledScene, name: str) -> list[int]:
    """The bodies of a contact."""
    return bodies_of(compiled, surfaces_of(compiled, result.contact_names.index(name)))


def _closings(result: Result) -> list[tuple[str, Closing]]:
    """How the contacts that took an impulse closed, of bodies with modes, as far as that is known."""
    compiled = result.compiled
    if compiled is None or not len(result.times):
        return []
    found = []
    for law in np.flatnonzero(result.impulse[-1, :, 0]).tolist():
        bodies = bodies_of(compiled, surfaces_of(compiled, law))
        quick = max((_half_period(result, compiled, b) for b in bodies), default=0.0)
        if quick > 0.0 and (closing := _closing(result, compiled.size, law, quick)) is not None:
            found.append((result.contact_names[law], closing))
    return found


def _half_period(result: Result, compiled: CompiledScene, b: int) -> float:
    """Of the highest mode of a body that is free and has mass [s]; 0 of a rigid one."""
    own, held, _ = held_modes(result, compiled, b)
    return half_period(own[held], np.max)


def _closing(result: Result, size: float, law: int, quick: float) -> Closing | None:
    """Of the hardest push of a contact; None where what was stored does not tell."""
    begin, end = hardest_push(result.times, result.impulse[:, law, 0])
    points = result.contact_points
    rows = np.flatnonzero(points.contact == law)
    at = result.times[points.record[rows]]
    rows, at = rows[(at > begin) & (at <= end)], at[(at > begin) & (at <= end)]
    within = AT_ONCE * quick
    if not len(rows) or max(within, at[0] - begin) > SOON * (end - begin):
        return None
    records, counts = np.unique(points.record[rows], return_counts=True)
    early = counts[result.times[records] <= at[0] + within]
    places = points.place[rows[points.record[rows] == records[np.argmax(early)]]]
    most = int(counts.max())
    return Closing(len(places), most, within, is_flat(places, most, size))
