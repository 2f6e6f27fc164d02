"""Contacts under continuous laws: their forces with what they remember, and what they take note of after a step.

A contact that begins notes the speed at which it would have met its indentation from the touch, without loss,

    v_0 = (rate^2 + 2 E(delta) G_NN)^(1/2),

which at the touch itself is the rate of approach, and its effective mass 1/G_NN. The memory is changed between steps
only: within one, forces are smooth functions of the state.
"""

from __future__ import annotations

import math

from lcpflex.contact.detection import ContactTable
from lcpflex.force_laws.elastic.kernels import stored_energy
from lcpflex.force_laws.history import FREE, PLACES, ContactMemory, first_place, place_of
from lcpflex.force_laws.normal_kernels import contact_energy, contact_stiffness, normal_force
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.model.arrays import Model

__all__ = ["pair_energy", "pair_force", "pair_place", "pair_stiffness", "settle", "unsettled"]

WITHIN = -1  # law whose indentation is beyond its range: none


@kernel
def pair_place(model: Model, memory: ContactMemory, table: ContactTable, k: int) -> int:
    """Place of entry k of the table in the memory, -1: none."""
    if len(memory.feature) == 0:
        return -1
    count = max(len(model.contacts.feature_kind), 1)
    return place_of(memory, table.law[k], table.key[k] // count, table.key[k] % count)


@kernel
def pair_force(memory: ContactMemory, law: int, place: int, depth: float, rate: float) -> tuple[float, float]:
    """Normal force and its part that stores energy [N], at an indentation > 0 [m] growing with ``rate`` [m/s].

    A contact that is not remembered yet, in a trial state of a step, has the present rate as its impact speed.
    """
    speed = abs(rate)
    mass = 1.0
    deepest = 0.0
    loading = True
    if place >= 0:
        speed = memory.speed[place]
        mass = memory.mass[place]
        deepest = memory.deepest[place]
        loading = memory.loading[place] == 1
    return normal_force(memory.kinds[law], memory.parameters[law], depth, rate, speed, mass, deepest, loading)


@kernel
def pair_energy(memory: ContactMemory, law: int, place: int, depth: float) -> float:
    """Energy that a contact can give back [J]."""
    deepest = memory.deepest[place] if place >= 0 else 0.0
    loading = place < 0 or memory.loading[place] == 1
    return contact_energy(memory.kinds[law], memory.parameters[law], depth, deepest, loading)


@kernel
def pair_stiffness(memory: ContactMemory, law: int, place: int, depth: float) -> float:
    """Slope of the elastic part [N/m]."""
    deepest = memory.deepest[place] if place >= 0 else 0.0
    loading = place < 0 or memory.loading[place] == 1
    return contact_stiffness(memory.kinds[law], memory.parameters[law], depth, deepest, loading)


@kernel
def mark(model: Model, memory: ContactMemory, table: ContactTable, n: int) -> None:
    """Mark as seen the places whose slave touches their feature, among the first n entries of the table."""
    count = max(len(model.contacts.feature_kind), 1)
    for i in range(len(memory.seen)):
        memory.seen[i] = 0
    for k in range(n):
        place = first_place(memory, table.law[k], table.key[k] // count)
        if place >= 0 and table.gap[k] <= 0.0:
            for i in range(place, place + PLACES):
                if memory.feature[i] == table.key[k] % count:
                    memory.seen[i] = 1


@kernel
def left_place(memory: ContactMemory, place: int) -> int:
    """Of the places of a slave, one that it has left and may take along to another feature; -1: none."""
    for i in range(place, place + PLACES):
        if memory.feature[i] != FREE and memory.seen[i] == 0:
            return i
    return -1


@kernel
def holds(memory: ContactMemory, place: int, feature: int) -> int:
    """Of the places of a slave, the one for ``feature``; -1: none."""
    for i in range(place, place + PLACES):
        if memory.feature[i] == feature:
            return i
    return -1


@kernel
def unsettled(model: Model, memory: ContactMemory, table: ContactTable, n: int, rates: FloatArray) -> bool:
    """Whether a step should have ended before: a contact has begun, turned back from its largest indentation, or
    come back to it.

    ``rates``: of the gaps of the first n entries [m/s].
    """
    count = max(len(model.contacts.feature_kind), 1)
    mark(model, memory, table, n)
    for k in range(n):
        place = first_place(memory, table.law[k], table.key[k] // count)
        if place < 0 or table.gap[k] > 0.0:
            continue
        own = holds(memory, place, table.key[k] % count)
        if own < 0:
            own = left_place(memory, place)
            if own < 0:
                if holds(memory, place, FREE) >= 0:
                    return True
                continue  # a third feature at once: nobody would take note of it
            memory.seen[own] = 1
        if memory.turns[table.law[k]] == 1:
            turned = rates[k] > 0.0 if memory.loading[own] == 1 else -table.gap[k] > memory.deepest[own]
            if turned:
                return True
    return False


@kernel
def settle(
    model: Model,
    memory: ContactMemory,
    table: ContactTable,
    n: int,
    rates: FloatArray,
    G: FloatArray,
    states: FloatArray,
) -> int:
    """Take note of the first n entries of the table, in an accepted state.

    ``rates`` (n,): of their gaps [m/s]. ``G`` (., .): Delassus operator, with G_NN of the entries on its diagonal, read
    where a contact begins. ``states`` (places, 2): of friction, reset there. Returns the law whose indentation is out
    of its range, or -1.
    """
    count = max(len(model.contacts.feature_kind), 1)
    mark(model, memory, table, n)
    outside = WITHIN
    for k in range(n):
        law = table.law[k]
        depth = max(-table.gap[k], 0.0)
        memory.worst[law] = max(memory.worst[law], depth)
        if depth > memory.stop[law]:
            outside = law
        place = first_place(memory, law, table.key[k] // count)
        if place < 0 or table.gap[k] > 0.0:
            continue
        own = holds(memory, place, table.key[k] % count)
        if own < 0:
            own = left_place(memory, place)
        if own < 0:
            own = holds(memory, place, FREE)
            if own < 0:
                continue  # a third feature at once: it has the memory of the first
            energy = stored_energy(memory.kinds[law], memory.parameters[law], depth)  # work done, given back or not
            memory.speed[own] = math.sqrt(rates[k] * rates[k] + 2.0 * energy * G[k, k])
            memory.mass[own] = 1.0 / G[k, k] if G[k, k] > 0.0 else math.inf
            memory.deepest[own] = 0.0
            memory.loading[own] = 1
            for j in range(2 if own < len(states) else 0):
                states[own, j] = 0.0
        memory.feature[own] = table.key[k] % count
        memory.seen[own] = 1
        if depth >= memory.deepest[own]:
            memory.deepest[own] = depth
            memory.loading[own] = 1
        if rates[k] > 0.0:
            memory.loading[own] = 0
    for i in range(len(memory.seen)):
        if memory.seen[i] == 0:
            memory.feature[i] = FREE
    return outside
