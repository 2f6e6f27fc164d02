"""What contacts under continuous laws remember from step to step.

Each node has two places under each law that needs some, for two features of a surface at a time (a hollow corner). A
place is taken when the node touches a feature, and handed on when the node passes on to the next one.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from lcpflex.force_laws.layout import END, LIMIT, NO_LAW, PARAMETERS, LawRow
from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.jit.struct import pack
from lcpflex.model.arrays import Contacts

__all__ = ["ENOUGH", "FREE", "PLACES", "ContactMemory", "contact_memory", "first_place", "place_of"]

PLACES = 2  # for one node under one law
FREE = -1  # feature of a place that nobody has
# columns of touches: steps of the present touch, its impulse, that of the last step, of all touches, of those of fewer
# than ENOUGH steps, the sum of these times their steps, the largest of these; fewest steps of one of them, its impulse
STEPS, OF_TOUCH, OF_STEP, OF_ALL, OF_COARSE, TIMES_STEPS, OF_LARGEST, FEWEST, OF_FEWEST, COLUMNS = range(10)
ENOUGH = 20  # steps of a touch; then the speed of the rebound is right to 2 % under damped laws, to .2 % under springs


class ContactMemory(NamedTuple):
    """Laws of the declared contacts, and the memory of those that touch."""

    kinds: IntArray  # (laws, 4), see layout
    parameters: FloatArray  # (laws, PARAMETERS)
    slip_speed: FloatArray  # (laws,) [m/s]
    stop: FloatArray  # (laws,) indentation beyond which a run must not go on [m]
    turns: IntArray  # (laws,) 1 for laws with an unloading branch of its own, which begins where a contact turns back
    watched: IntArray  # (1,) 1 where a law remembers something or has a range to stay in
    worst: FloatArray  # (laws,) largest indentation of an accepted state [m]
    touches: FloatArray  # (laws + 1, COLUMNS) in steps of one length: :mod:`lcpflex.dynamics.touches`
    ranges: IntArray  # (laws, 2, 3) for each pass of a law: its nodes first..last-1, first place; no nodes: no memory
    feature: IntArray  # (places,) feature that the node touches, or FREE
    seen: IntArray  # (places,) work
    speed: FloatArray  # (places,) impact speed [m/s]
    mass: FloatArray  # (places,) effective mass at the touch [kg]
    deepest: FloatArray  # (places,) largest indentation [m]
    loading: IntArray  # (places,) 1 until the contact turns back from it


def contact_memory(contacts: Contacts, laws: Sequence[LawRow | None]) -> ContactMemory:
    """Empty memory for the declared contacts with these ``laws``; None, for rigid ones, remembers nothing."""
    rows = [law or NO_LAW for law in laws]
    ranges = np.zeros((len(rows), 2, 3), dtype=np.int64)
    taken = np.zeros(len(rows), dtype=np.int64)
    places = 0
    for surface, law in zip(contacts.pass_node, contacts.pass_law, strict=True):
        if rows[law].remembers:
            first, last = contacts.node_start[surface], contacts.node_start[surface + 1]
            ranges[law, taken[law]] = first, last, places
            taken[law] += 1
            places += PLACES * int(last - first)
    for law, row in enumerate(rows):
        if row.remembers and taken[law] == 0:  # of a user's own system: one gap, without any surface
            ranges[law, 0] = law, law + 1, places
            places += PLACES
    parameters = np.array([row.parameters for row in rows], dtype=float).reshape(-1, PARAMETERS)
    memory = ContactMemory(
        kinds=np.array([row.kinds for row in rows], dtype=np.int64).reshape(-1, 4),
        parameters=parameters,
        slip_speed=np.array([row.slip_speed for row in rows], dtype=float),
        stop=np.array([row.parameters[END if row.lenient else LIMIT] for row in rows], dtype=float),
        turns=np.array([row.turns for row in rows], dtype=np.int64),
        watched=np.array([any(row.remembers or row.parameters[LIMIT] < np.inf for row in rows)], dtype=np.int64),
        worst=np.zeros(len(rows)),
        touches=np.zeros((len(rows) + 1 if rows else 0, COLUMNS)),
        ranges=ranges,
        feature=np.full(places, FREE),
        seen=np.zeros(places, dtype=np.int64),
        speed=np.zeros(places),
        mass=np.ones(places),
        deepest=np.zeros(places),
        loading=np.zeros(places, dtype=np.int64),
    )
    return pack(memory)


@kernel
def first_place(memory: ContactMemory, law: int, node: int) -> int:
    """First of the places of a node under a law; -1 if the law remembers nothing."""
    for w in range(2):
        first = memory.ranges[law, w, 0]
        if first <= node < memory.ranges[law, w, 1]:
            return memory.ranges[law, w, 2] + PLACES * (node - first)
    return -1


@kernel
def place_of(memory: ContactMemory, law: int, node: int, feature: int) -> int:
    """Place of a node on a feature; the one it comes from if it has just passed on to it; -1: none."""
    place = first_place(memory, law, node)
    if place < 0:
        return -1
    for i in range(place, place + PLACES):
        if memory.feature[i] == feature:
            return i
    for i in range(place, place + PLACES):
        if memory.feature[i] != FREE:
            return i
    return -1
