"""What a result holds of each contact, found once: a scan of all points and events for each name is their square."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

import numpy as np

if TYPE_CHECKING:
    from lcpflex.jit.kernel import IntArray
    from lcpflex.results.contact_history import Event
    from lcpflex.results.result import Result

__all__ = ["ContactsByName", "contacts_by_name"]


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
