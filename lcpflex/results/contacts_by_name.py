"""What a result holds of each contact, by its name.

It is found once: a scan of all points and events for each name is their square.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

import numpy as np

from lcpflex.basics.arguments import absent
from lcpflex.compile.touched_pairs import pair_of
from lcpflex.errors import ModelError
from lcpflex.results.contact_history import ContactHistory, Event, untouched
from lcpflex.results.stored_instants import impulse_noise, located, tells_of_steps

if TYPE_CHECKING:
    from lcpflex.jit.kernel import IntArray
    from lcpflex.results.result import Result

__all__ = ["ContactsByName", "history_of", "contacts_by_name"]


@dataclass(frozen=True, slots=True, eq=False)
class ContactsByName:
    """Where everything of a contact is."""

    number: dict[str, int]
    events: dict[str, tuple[Event, ...]]  # of contacts that have some, in order of time
    order: IntArray  # (k,) the touching points, contact by contact
    start: IntArray  # (nc + 1,) offsets into it

    def points(self, k: int) -> IntArray:
        """The touching points of contact k, in order of time."""
        return self.order[self.start[k] : self.start[k + 1]]


_found: WeakKeyDictionary[Result, ContactsByName] = WeakKeyDictionary()  # a result is frozen, and its file keeps fields


def contacts_by_name(result: Result) -> ContactsByName:
    """Those of a result, made when they are first asked for."""
    found = _found.get(result)
    if found is None:
        found = _found[result] = _made(result)
    return found


def history_of(result: Result, name: str) -> ContactHistory:
    """See :meth:`lcpflex.results.result.Result.contact`."""
    found = contacts_by_name(result)
    k = found.number.get(name) if isinstance(name, str) else None
    if k is None:
        if isinstance(name, str) and result.compiled and pair_of(result.compiled, name):
            return untouched(name, result.times, result.force.shape[2])
        raise ModelError(f"name: no contact {absent(name, result.contact_names)}")
    events = found.events.get(name, ())
    first, points = min((event.time for event in events), default=float("inf")), found.points(k)
    pressed = points[result.contact_points.force[points, 0] > 0.0]
    pairs = np.bincount(result.contact_points.record[pressed], minlength=len(result.times))
    force, impulse, state, gap = result.force[:, k], result.impulse[:, k], result.state[:, k], result.gap[:, k]
    crept = result.crept[k] if result.crept else 0.0
    noise = impulse_noise(result) * float(np.abs(impulse).max(initial=0.0))
    how = located(result, name), tells_of_steps(result), noise
    of_points = result.contact_points, points
    return ContactHistory(name, result.times, force, impulse, state, gap, pairs, first, crept, events, *how, *of_points)


def _made(result: Result) -> ContactsByName:
    names = result.contact_names
    events: dict[str, list[Event]] = {}
    for event in result.events:
        events.setdefault(event.contact, []).append(event)
    owner = result.contact_points.contact
    small = owner.astype(np.min_scalar_type(len(names)))  # which are sorted in linear time
    order = np.argsort(small, kind="stable")
    return ContactsByName(
        number={name: k for k, name in reversed(list(enumerate(names)))},  # of equal names the first counts
        events={name: tuple(own) for name, own in events.items()},
        order=order,
        start=np.concatenate([[0], np.cumsum(np.bincount(owner, minlength=len(names)))]),
    )
