"""The order in which bodies are eliminated, and the pattern of the factor: minimum degree on the graph of bodies.

Quotient graph: a body that is eliminated becomes an element, tied to all that its neighbours were tied to, and takes
the place of the elements next to it; lists never outgrow the first ones. Sources: George & Liu 1989 (minimum degree),
Duff & Reid 1983 (fronts), Liu 1992 (the order of fronts and their stack).
"""

from __future__ import annotations

from lcpflex.jit.kernel import IntArray, kernel
from lcpflex.solvers.contact.group import Group
from lcpflex.solvers.contact.operators.sparse_factor import Bodies, SparseFactor

__all__ = ["make_pattern"]

WAITING, ELEMENT, ABSORBED = 0, 1, 2  # state of a body
THIN = 48  # unknowns of fronts that are joined though some of their numbers will be zero
WASTE = 0.15  # of a front that may be zero where two are joined


@kernel
def make_pattern(op: Bodies, group: Group, factor: SparseFactor) -> bool:
    """The pattern of ``factor`` for the pairs of bodies of all units; False where ``pool`` is too small.

    A pattern that is known and holds all pairs is kept, unless half of them are gone.
    """
    pairs = list_neighbours(op, group, factor)
    if keeps(op, group, factor, pairs):
        hand_units(op, group, factor)
        return True
    factor.known = 0
    for b in range(op.n_bodies):
        factor.size[b] = op.pos[b + 1] - op.pos[b]
    factor.n_bodies = op.n_bodies
    if not eliminate(factor):
        factor.room_pool = 2 * len(factor.pool) + group.n
        return False
    put_children_first(factor)
    join_nodes(factor)
    measure_nodes(factor)
    factor.pairs = pairs
    factor.known = 1
    hand_units(op, group, factor)
    return True


@kernel
def list_neighbours(op: Bodies, group: Group, factor: SparseFactor) -> int:
    """Neighbours of each body, each once, in compressed form; returns the number of pairs."""
    body, start, length, near, mark = op.body, factor.start, factor.length, factor.near, factor.mark
    n = op.n_bodies
    for b in range(n):
        length[b] = 0
        mark[b] = -1
    for k in range(group.n):
        if body[k, 0] >= 0 and body[k, 1] >= 0:
            length[body[k, 0]] += 1
            length[body[k, 1]] += 1
    start[0] = 0
    for b in range(n):
        start[b + 1] = start[b] + length[b]
        length[b] = 0
    for k in range(group.n):
        a, b = body[k, 0], body[k, 1]
        if a >= 0 and b >= 0:
            near[start[a] + length[a]] = b
            near[start[b] + length[b]] = a
            length[a] += 1
            length[b] += 1
    pairs = 0
    for b in range(n):
        kept = 0
        for e in range(start[b], start[b] + length[b]):
            other = near[e]
            if mark[other] != b:
                mark[other] = b
                near[start[b] + kept] = other
                kept += 1
        length[b] = kept
        pairs += kept
    return pairs // 2


@kernel
def keeps(op: Bodies, group: Group, factor: SparseFactor, pairs: int) -> bool:
    """Whether the pattern known serves: the same bodies, all pairs in it, and not many more."""
    n = op.n_bodies
    if factor.known == 0 or factor.n_bodies != n or 2 * pairs < factor.pairs:
        return False
    for b in range(n):
        if factor.size[b] != op.pos[b + 1] - op.pos[b]:
            return False
    place, pool, pool_start, pool_length = factor.place, factor.pool, factor.pool_start, factor.pool_length
    mark = factor.mark
    for b in range(n):
        mark[b] = -1
    for b in range(n):
        for e in range(pool_start[b], pool_start[b] + pool_length[b]):
            mark[pool[e]] = b
        for e in range(factor.start[b], factor.start[b] + factor.length[b]):
            other = factor.near[e]
            if place[other] > place[b] and mark[other] != b:
                return False
    return True


@kernel
def link(factor: SparseFactor, b: int, degree: int) -> None:
    """Put body b among those of its degree."""
    factor.degree[b] = degree
    first = factor.head[degree]
    factor.following[b], factor.before[b] = first, -1
    if first >= 0:
        factor.before[first] = b
    factor.head[degree] = b


@kernel
def unlink(factor: SparseFactor, b: int) -> None:
    """Take body b from among those of its degree."""
    following, before = factor.following[b], factor.before[b]
    if before >= 0:
        factor.following[before] = following
    else:
        factor.head[factor.degree[b]] = following
    if following >= 0:
        factor.before[following] = before


@kernel
def eliminate(factor: SparseFactor) -> bool:
    """Minimum degree: ``order``, ``parent`` and what each body is tied to, in ``pool``; False where that is full."""
    n = factor.n_bodies
    state, mark, length = factor.state, factor.mark, factor.length
    for b in range(n):
        state[b], mark[b], factor.parent[b], factor.head[b] = WAITING, -1, -1, -1
    factor.head[n] = -1
    for b in range(n - 1, -1, -1):
        link(factor, b, length[b])
    factor.pool_end = 0
    lowest, stamp = 0, 0
    for place in range(n):
        while factor.head[lowest] < 0:
            lowest += 1
        p = factor.head[lowest]
        unlink(factor, p)
        stamp += 1
        if not gather_boundary(factor, p, stamp):
            return False
        state[p] = ELEMENT
        factor.order[place] = p
        stamp = update_neighbours(factor, p, stamp)
        first = factor.pool_start[p]
        for e in range(first, first + factor.pool_length[p]):
            lowest = min(lowest, factor.degree[factor.pool[e]])
    return True


@kernel
def gather_boundary(factor: SparseFactor, p: int, stamp: int) -> bool:
    """What p is tied to, marked; the elements next to it are absorbed. False where the pool is full."""
    pool, mark, state, near = factor.pool, factor.mark, factor.state, factor.near
    room, end = len(pool), factor.pool_end
    first = end
    mark[p] = stamp
    for e in range(factor.start[p], factor.start[p] + factor.length[p]):
        other = near[e]
        if state[other] == WAITING:
            if mark[other] != stamp:
                if end == room:
                    return False
                mark[other] = stamp
                pool[end] = other
                end += 1
        elif state[other] == ELEMENT:
            state[other] = ABSORBED
            factor.parent[other] = p
            for f in range(factor.pool_start[other], factor.pool_start[other] + factor.pool_length[other]):
                tied = pool[f]
                if mark[tied] != stamp:
                    if end == room:
                        return False
                    mark[tied] = stamp
                    pool[end] = tied
                    end += 1
    factor.pool_start[p], factor.pool_length[p], factor.pool_end = first, end - first, end
    return True


@kernel
def update_neighbours(factor: SparseFactor, p: int, stamp: int) -> int:
    """Lists and degrees of all that p is tied to; returns the last mark used."""
    pool, mark, state, near = factor.pool, factor.mark, factor.state, factor.near
    start, length = factor.start, factor.length
    pool_start, pool_length = factor.pool_start, factor.pool_length
    first, tied = pool_start[p], pool_length[p]
    own = stamp
    for e in range(first, first + tied):
        i = pool[e]
        unlink(factor, i)
        kept = start[i]
        for f in range(start[i], start[i] + length[i]):
            other = near[f]
            if (state[other] == WAITING and mark[other] != own) or (state[other] == ELEMENT and other != p):
                near[kept] = other
                kept += 1
        near[kept] = p
        length[i] = kept + 1 - start[i]
    for e in range(first, first + tied):
        i = pool[e]
        degree = tied - 1
        stamp += 1
        for f in range(start[i], start[i] + length[i] - 1):  # the last one is p
            other = near[f]
            if state[other] == WAITING:
                if mark[other] != stamp:
                    mark[other] = stamp
                    degree += 1
            else:
                degree += outside(factor, other, own, stamp)
        link(factor, i, degree)
    return stamp


@kernel
def outside(factor: SparseFactor, element: int, own: int, stamp: int) -> int:
    """Bodies that an element is tied to and that were not counted under this stamp, nor carry the mark ``own``."""
    count = 0
    pool, mark = factor.pool, factor.mark
    for f in range(factor.pool_start[element], factor.pool_start[element] + factor.pool_length[element]):
        tied = pool[f]
        if mark[tied] != own and mark[tied] != stamp:
            mark[tied] = stamp
            count += 1
    return count


@kernel
def put_children_first(factor: SparseFactor) -> None:
    """Order the elimination tree so that each subtree is contiguous, its root last: ``order`` and ``place``."""
    n, parent = factor.n_bodies, factor.parent
    child, sibling, order = factor.head, factor.following, factor.order
    for b in range(n):
        child[b] = -1
    for at in range(n - 1, -1, -1):  # children in the order of their elimination
        b = order[at]
        if parent[b] >= 0:
            sibling[b] = child[parent[b]]
            child[parent[b]] = b
    roots = 0
    for at in range(n):
        if parent[order[at]] < 0:
            factor.before[roots] = order[at]
            roots += 1
    end = 0
    for r in range(roots):
        b = factor.before[r]
        while b >= 0:
            if child[b] >= 0:
                below = child[b]
                child[b] = -1  # all children are reached by way of the first one's siblings
                b = below
                continue
            order[end] = b
            factor.place[b] = end
            end += 1
            up = parent[b]
            b = sibling[b] if up >= 0 and sibling[b] >= 0 else up


@kernel
def tied_unknowns(factor: SparseFactor, b: int) -> int:
    """Unknowns that body b is tied to when it is eliminated."""
    total = 0
    for e in range(factor.pool_start[b], factor.pool_start[b] + factor.pool_length[b]):
        total += factor.size[factor.pool[e]]
    return total


@kernel
def join_nodes(factor: SparseFactor) -> None:
    """Supernodes: bodies one after the other of which each is tied to the next and, nearly, to the same others."""
    n, order, first = factor.n_bodies, factor.order, factor.node_first
    nodes, pivots, tied, wasted = 0, 0, 0, 0
    for at in range(n):
        b = order[at]
        size, rest = factor.size[b], tied_unknowns(factor, b)
        if at > 0 and factor.parent[order[at - 1]] == b:
            zeros = wasted + pivots * (size + rest - tied)
            width = pivots + size + rest
            if zeros <= WASTE * width * (pivots + size) or (width <= THIN and zeros <= 2 * WASTE * width * width):
                pivots, tied, wasted = pivots + size, rest, zeros
                continue
        first[nodes] = at
        nodes += 1
        pivots, tied, wasted = size, rest, 0
    first[nodes] = n
    factor.n_nodes = nodes


@kernel
def measure_nodes(factor: SparseFactor) -> None:
    """Sizes of fronts, of the factor and of the stack, and the children of each supernode."""
    order, first, of_place = factor.order, factor.node_first, factor.mark
    entries, pivot, operations = 0, 0, 0.0
    factor.widest = 0
    for s in range(factor.n_nodes):
        factor.node_children[s] = 0
        for at in range(first[s], first[s + 1]):
            of_place[at] = s
    for s in range(factor.n_nodes):
        pivots = 0
        for at in range(first[s], first[s + 1]):
            pivots += factor.size[order[at]]
        top = order[first[s + 1] - 1]
        rest = tied_unknowns(factor, top)
        factor.node_pivots[s], factor.node_width[s] = pivots, pivots + rest
        factor.node_entry[s], factor.first_pivot[s] = entries, pivot
        entries += pivots * (pivots + 2 * rest)
        pivot += pivots
        operations += pivots * float(pivots + rest) ** 2
        factor.widest = max(factor.widest, pivots + rest)
        if factor.parent[top] >= 0:
            factor.node_children[of_place[factor.place[factor.parent[top]]]] += 1
    factor.entries, factor.work = entries, operations
    factor.highest = stack_height(factor)


@kernel
def stack_height(factor: SparseFactor) -> int:
    """Numbers on the stack at its highest: each front takes those of its children off and leaves its own."""
    height, highest, count = 0, 0, 0
    sizes = factor.following  # heights left on the stack
    for s in range(factor.n_nodes):
        for _ in range(factor.node_children[s]):
            count -= 1
            height -= sizes[count]
        rest = factor.node_width[s] - factor.node_pivots[s]
        if rest > 0:
            sizes[count] = rest * rest
            height += sizes[count]
            count += 1
            highest = max(highest, height)
    return highest


@kernel
def hand_units(op: Bodies, group: Group, factor: SparseFactor) -> None:
    """Units by the first of their bodies that is eliminated."""
    body, place, start, units = op.body, factor.place, factor.unit_start, factor.unit_list
    n = op.n_bodies
    for at in range(n + 1):
        start[at] = 0
    for k in range(group.n):
        if body[k, 0] >= 0 or body[k, 1] >= 0:
            start[earlier(place, body[k, 0], body[k, 1])] += 1
    total = 0
    for at in range(n + 1):
        total += start[at]
        start[at] = total
    for k in range(group.n - 1, -1, -1):
        if body[k, 0] >= 0 or body[k, 1] >= 0:
            at = earlier(place, body[k, 0], body[k, 1])
            start[at] -= 1
            units[start[at]] = k


@kernel
def earlier(place: IntArray, a: int, b: int) -> int:
    """The place of the one of two bodies that is eliminated first; -1 stands for no body, of which there is one."""
    if a < 0:
        return int(place[b])
    return int(min(place[a], place[b])) if b >= 0 else int(place[a])
