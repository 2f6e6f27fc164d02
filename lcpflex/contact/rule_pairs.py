"""Pairs of surfaces under a rule: which may touch at all, and the law of each that has.

A rule stands in the model once, with the surfaces it is for and the pairs that it leaves out; the pairs that it allows
grow with the square of their number and are never listed. A pair gets a law of its own, and with it a column in what
is recorded, when it first touches: laws are numbered on behind that of the rule, and found by hashing.
"""

from __future__ import annotations

import numpy as np

from lcpflex.bodies.surface import BOTH, NO_NODE, RANK, Kind
from lcpflex.jit.kernel import IntArray, kernel
from lcpflex.jit.struct import allocate, array, put_array, struct
from lcpflex.model.arrays import Contacts, Model, empty, frozen

__all__ = [
    "MORE_LAWS",
    "RulePairs",
    "TOUCHES",
    "is_barred",
    "give_laws",
    "is_node_side",
    "law_of_pair",
    "make_room",
    "may_meet",
    "no_pairs",
    "new_law",
    "rule_pairs",
]

MORE_LAWS = 2**62  # instead of a number of contacts: a pair has touched for which no law is left
FIRST_LAWS = 64  # of pairs that have room at first
FOUND = 32  # near pairs that have room, for each surface: where they are more, all pairs are looked at
LEVELS = 2200  # powers of two that a float may have
FIRST_MULTIPLIER = 73_856_093  # of hashes: large odd numbers
SECOND_MULTIPLIER = 19_349_669
POINT = RANK[Kind.NODE]
TOUCHES = np.array(  # by ranks: whether nodes of the one may touch features of the other, which a point has not
    [[a != NO_NODE and b != POINT for b in range(NO_NODE + 1)] for a in range(NO_NODE + 1)]
)


@struct
class RulePairs:
    """The laws of pairs that have touched, and the memory of the search for near ones; shared by tables of a run."""

    n_laws: int  # given so far: declared contacts, the rule, pairs
    slot: IntArray = array("slots")  # hash table: law of a pair; 0: free
    pair: IntArray = array("laws", 2)  # surfaces of each law of a pair, the earlier first; -1 of others
    # scratch of the search
    level: IntArray = array("surfaces")  # power of two that the surface fits in
    cell: IntArray = array("surfaces", 2)  # where it is, in cells of that size
    after: IntArray = array("surfaces")  # the next one in the same bucket, or -1
    bucket: IntArray = array("buckets")  # the first one in each, or -1
    on_level: IntArray = array("levels")  # how many there are
    found: IntArray = array("found", 2)
    sorted: IntArray = array("found", 2)
    count: IntArray = array("counts")


def rule_pairs(contacts: Contacts) -> RulePairs:
    """Empty memory for the rule of a model; of no size where there is none."""
    n = len(contacts.rule_rank)
    laws = len(contacts.friction) + FIRST_LAWS if n else 0
    sizes = {
        "slots": power_of_two(2 * laws),
        "surfaces": n,
        "buckets": power_of_two(2 * n),
        "found": FOUND * n,
        "counts": n + 1 if n else 0,
        "levels": LEVELS if n else 0,
        "laws": laws,
    }
    return allocate(RulePairs, sizes, pair=np.full((laws, 2), -1, dtype=np.int64), n_laws=len(contacts.friction))


def no_pairs() -> RulePairs:
    """Of a table without a rule."""
    return rule_pairs(empty(Contacts))


def give_laws(contacts: Contacts, laws: int) -> None:
    """Numbers for so many laws, those of pairs that of the rule, in a packed model."""
    for name in ("friction", "restitution", "tangential_restitution"):
        present = getattr(contacts, name)
        if len(present) < laws:
            of_rule = present[contacts.rule_law[0]]
            put_array(contacts, name, frozen(np.concatenate([present, np.full(laws - len(present), of_rule)])))


def make_room(pairs: RulePairs, laws: int) -> None:
    """Room for so many laws; pairs keep theirs."""
    pair = np.full((laws, 2), -1, dtype=np.int64)
    pair[: len(pairs.pair)] = pairs.pair
    slot = np.zeros(power_of_two(2 * laws), dtype=np.int64)
    for law in np.flatnonzero(pair[:, 0] >= 0):
        put(slot, int(pair[law, 0]), int(pair[law, 1]), int(law))
    put_array(pairs, "pair", pair)
    put_array(pairs, "slot", slot)


def power_of_two(least: int) -> int:
    """The next one; 0 for none."""
    return 1 << (least - 1).bit_length() if least else 0


@kernel
def place_in(slot: IntArray, i: int, j: int) -> int:
    """Where the search for a pair begins in a hash table."""
    mixed = i * FIRST_MULTIPLIER ^ j * SECOND_MULTIPLIER
    return (mixed ^ (mixed >> 15)) & (len(slot) - 1)


@kernel
def put(slot: IntArray, i: int, j: int, law: int) -> None:
    """Note the law of a pair in a hash table that has room."""
    at = place_in(slot, i, j)
    while slot[at] != 0:
        at = (at + 1) & (len(slot) - 1)
    slot[at] = law


@kernel
def law_of_pair(pairs: RulePairs, i: int, j: int) -> int:
    """The law of a pair of surfaces, i < j; -1 where it has not touched yet."""
    slot, pair = pairs.slot, pairs.pair
    at = place_in(slot, i, j)
    while slot[at] != 0:
        law = slot[at]
        if pair[law, 0] == i and pair[law, 1] == j:
            return law
        at = (at + 1) & (len(slot) - 1)
    return -1


@kernel
def new_law(pairs: RulePairs, i: int, j: int) -> int:
    """A law for a pair that has none; -1 where there is none left."""
    law = pairs.n_laws
    if law >= len(pairs.pair):
        return -1
    pairs.pair[law, 0] = i
    pairs.pair[law, 1] = j
    put(pairs.slot, i, j, law)
    pairs.n_laws = law + 1
    return law


@kernel
def may_meet(model: Model, i: int, j: int) -> bool:
    """Whether two surfaces of the rule are of two bodies, and of kinds that can touch."""
    c = model.contacts
    a, b = c.rule_rank[i], c.rule_rank[j]
    return c.surface_body[i] != c.surface_body[j] and (TOUCHES[a, b] or TOUCHES[b, a])


@kernel
def is_node_side(model: Model, a: int, b: int) -> bool:
    """Whether nodes of surface a of the rule may touch surface b: each of two chains is the node side of the other."""
    first, second = model.contacts.rule_rank[a], model.contacts.rule_rank[b]
    if BOTH <= first < NO_NODE and BOTH <= second < NO_NODE:
        return True
    return a < b if first == second else first < second


@kernel
def is_barred(model: Model, i: int, j: int) -> bool:
    """Whether the rule leaves a pair of surfaces out, i < j: they are declared by themselves, jointed, or excluded."""
    barred = model.contacts.barred
    low = model.contacts.barred_start[i]
    high = model.contacts.barred_start[i + 1]
    while low < high:
        middle = (low + high) // 2
        if barred[middle] < j:
            low = middle + 1
        else:
            high = middle
    return low < model.contacts.barred_start[i + 1] and barred[low] == j
