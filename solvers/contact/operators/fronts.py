"""The sparse factor of H = I + J^T C J, unsymmetric where contacts slide: dense fronts, one for each supernode.

A front holds the equations of the bodies that it eliminates, and what they do to the bodies that these are tied to;
that part is left on a stack for the front of their parent. Rows are exchanged among those that a front eliminates, not
beyond it. Source: Duff & Reid 1984 (unsymmetric sets of linear equations).
"""

from __future__ import annotations

from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.solvers.contact.algebra import Vector
from lcpflex.solvers.contact.operators.sparse_factor import Bodies, SparseFactor
from lcpflex.solvers.contact.unrolled import unrolled
from lcpflex.solvers.semidefinite import dot

__all__ = ["factorise", "has_room", "lacks_room", "solve"]

WEAK = 1e-14  # of the largest entry of its front: a pivot below it ends the factor


@kernel
def has_room(factor: SparseFactor) -> bool:
    """Whether the numbers of the factor fit; what is wanting else, to ``room_values`` and so on."""
    widest = factor.widest * factor.widest
    fits = factor.entries <= len(factor.values) and factor.highest <= len(factor.stack) and widest <= len(factor.front)
    if not fits:
        factor.room_values = factor.entries + factor.entries // 4
        factor.room_stack = factor.highest + factor.highest // 4
        factor.room_front = widest + widest // 4
    return bool(fits)


@kernel
def lacks_room(factor: SparseFactor) -> bool:
    """Whether something was wanting since the memory was made."""
    lacks = factor.room_pool > len(factor.pool) or factor.room_values > len(factor.values)
    return bool(lacks or factor.room_stack > len(factor.stack) or factor.room_front > len(factor.front))


@kernel
def factorise(op: Bodies, C: FloatArray, factor: SparseFactor, like: Vector) -> bool:
    """LU factor of I + J^T C J in the pattern of ``factor``, C (units, S S); False where a pivot is too small."""
    values, front = factor.values, factor.front
    height, count = 0, 0
    sizes = factor.following
    for s in range(factor.n_nodes):
        width, pivots = factor.node_width[s], factor.node_pivots[s]
        begin_front(factor, s)
        for at in range(factor.node_first[s], factor.node_first[s + 1]):
            for e in range(factor.unit_start[at], factor.unit_start[at + 1]):
                add_unit(op, C, factor, factor.unit_list[e], width, like)
        for _ in range(factor.node_children[s]):
            count -= 1
            child = sizes[count]
            rest = factor.node_width[child] - factor.node_pivots[child]
            height -= rest * rest
            add_child(factor, child, height, width)
        if not eliminate_front(factor, width, pivots, factor.first_pivot[s]):
            return False
        entry = factor.node_entry[s]
        for i in range(pivots * width):
            values[entry + i] = front[i]
        entry += pivots * width
        rest = width - pivots
        for i in range(rest):
            row = (pivots + i) * width
            for j in range(pivots):
                values[entry + j * rest + i] = front[row + j]
            row += pivots
            for j in range(rest):
                factor.stack[height + i * rest + j] = front[row + j]
        if rest > 0:
            sizes[count] = s
            count += 1
            height += rest * rest
    return True


@kernel
def begin_front(factor: SparseFactor, s: int) -> None:
    """The front of supernode s with the identity of the bodies it eliminates, and where each body is in it."""
    order, size, offset, pool = factor.order, factor.size, factor.offset, factor.pool
    front, width = factor.front, factor.node_width[s]
    for i in range(width * width):
        front[i] = 0.0
    end = 0
    for at in range(factor.node_first[s], factor.node_first[s + 1]):
        offset[order[at]] = end
        end += size[order[at]]
    for i in range(end):
        front[i * width + i] = 1.0
    top = order[factor.node_first[s + 1] - 1]
    for e in range(factor.pool_start[top], factor.pool_start[top] + factor.pool_length[top]):
        offset[pool[e]] = end
        end += size[pool[e]]


@unrolled
def add_unit(op: Bodies, C: FloatArray, factor: SparseFactor, k: int, width: int, like: Vector) -> None:
    """J_k^T C_k J_k to the front."""
    front, body, size, offset, J = factor.front, op.body, factor.size, factor.offset, op.J
    if sum(abs(C[k, (len(like) + 1) * e]) for e in range(len(like))) == 0.0:
        return
    for g in range(2):
        a = body[k, g]
        if a < 0:
            continue
        for i in range(size[a]):
            left = tuple(
                sum(J[k, g, e, i] * C[k, len(like) * e + f] for e in range(len(like))) for f in range(len(like))
            )
            row = (offset[a] + i) * width
            for h in range(2):
                b = body[k, h]
                if b >= 0:
                    column = row + offset[b]
                    for j in range(size[b]):
                        front[column + j] += sum(left[f] * J[k, h, f, j] for f in range(len(like)))


@kernel
def add_child(factor: SparseFactor, child: int, height: int, width: int) -> None:
    """What the front of a child has left on the stack."""
    pool, size, offset, stack, front = factor.pool, factor.size, factor.offset, factor.stack, factor.front
    top = factor.order[factor.node_first[child + 1] - 1]
    first = factor.pool_start[top]
    last = first + factor.pool_length[top]
    at = height
    for e in range(first, last):
        for i in range(size[pool[e]]):
            row = (offset[pool[e]] + i) * width
            for f in range(first, last):
                column = row + offset[pool[f]]
                for j in range(size[pool[f]]):
                    front[column + j] += stack[at]
                    at += 1


@kernel
def eliminate_front(factor: SparseFactor, width: int, pivots: int, first: int) -> bool:
    """LU of the first ``pivots`` columns of the front, and what is left of the others; four columns at a time."""
    front, swap = factor.front, factor.swap
    start = 0
    while start < pivots:
        panel = min(4, pivots - start)
        for c in range(start, start + panel):
            best, found = 0.0, c
            for i in range(c, pivots):
                if abs(front[i * width + c]) > best:
                    best, found = abs(front[i * width + c]), i
            if not best > WEAK:  # the identity is in it
                return False
            swap[first + c] = found
            if found != c:
                for j in range(width):
                    front[c * width + j], front[found * width + j] = front[found * width + j], front[c * width + j]
            inverse = 1.0 / front[c * width + c]
            for i in range(c + 1, width):
                multiplier = front[i * width + c] * inverse
                front[i * width + c] = multiplier
                for j in range(c + 1, start + panel):  # what is behind the panel waits: its rows may yet be exchanged
                    front[i * width + j] -= multiplier * front[c * width + j]
        update_rest(front, width, start, panel)
        start += panel
    return True


@kernel
def update_rest(front: FloatArray, width: int, start: int, panel: int) -> None:
    """Columns behind a panel of up to four, less what the panel does to them."""
    last = start + panel
    count = width - last
    if count <= 0:
        return
    for c in range(start, last):
        u = front[c * width + last : (c + 1) * width]
        for i in range(c + 1, last):
            multiplier = front[i * width + c]
            row = front[i * width + last : (i + 1) * width]
            for j in range(count):
                row[j] -= multiplier * u[j]
    u0 = front[start * width + last : start * width + width]
    if panel == 4:
        u1 = front[(start + 1) * width + last : (start + 2) * width]
        u2 = front[(start + 2) * width + last : (start + 3) * width]
        u3 = front[(start + 3) * width + last : (start + 4) * width]
        for i in range(last, width):
            base = i * width + start
            a, b, c, d = front[base], front[base + 1], front[base + 2], front[base + 3]
            row = front[i * width + last : (i + 1) * width]
            for j in range(count):
                row[j] -= a * u0[j] + b * u1[j] + c * u2[j] + d * u3[j]
        return
    for c in range(start, last):
        u = front[c * width + last : (c + 1) * width]
        for i in range(last, width):
            multiplier = front[i * width + c]
            row = front[i * width + last : (i + 1) * width]
            for j in range(count):
                row[j] -= multiplier * u[j]


@kernel
def solve(op: Bodies, factor: SparseFactor, x: FloatArray) -> None:
    """x <- H^-1 x in place."""
    pos = op.pos
    order, size, pool, values, swap = factor.order, factor.size, factor.pool, factor.values, factor.swap
    z = factor.gathered
    for turn in range(2):
        for at in range(factor.n_nodes):
            s = at if turn == 0 else factor.n_nodes - 1 - at
            width, pivots = factor.node_width[s], factor.node_pivots[s]
            end = 0
            for e in range(factor.node_first[s], factor.node_first[s + 1]):
                b = order[e]
                for i in range(size[b]):
                    z[end + i] = x[pos[b] + i]
                end += size[b]
            top = order[factor.node_first[s + 1] - 1]
            first, last = factor.pool_start[top], factor.pool_start[top] + factor.pool_length[top]
            for e in range(first, last):
                b = pool[e]
                for i in range(size[b]):
                    z[end + i] = x[pos[b] + i]
                end += size[b]
            entry = factor.node_entry[s]
            if turn == 0:
                forward(values, entry, width, pivots, swap, factor.first_pivot[s], z)
            else:
                for c in range(pivots - 1, -1, -1):
                    row = entry + c * width
                    rest = dot(values[row + c + 1 : row + width], z, c + 1, width - c - 1)
                    z[c] = (z[c] - rest) / values[row + c]
            end = 0
            for e in range(factor.node_first[s], factor.node_first[s + 1]):
                b = order[e]
                for i in range(size[b]):
                    x[pos[b] + i] = z[end + i]
                end += size[b]
            if turn == 0:
                for e in range(first, last):
                    b = pool[e]
                    for i in range(size[b]):
                        x[pos[b] + i] = z[end + i]
                    end += size[b]


@kernel
def forward(values: FloatArray, entry: int, width: int, pivots: int, swap: IntArray, first: int, z: FloatArray) -> None:
    """z <- L^-1 z in a front, rows exchanged."""
    for c in range(pivots):
        other = swap[first + c]
        if other != c:
            z[c], z[other] = z[other], z[c]
    rest = width - pivots
    below = entry + pivots * width
    for c in range(pivots):
        part = z[c]
        if part != 0.0:
            for i in range(c + 1, pivots):
                z[i] -= values[entry + i * width + c] * part
            column = values[below + c * rest : below + (c + 1) * rest]
            for i in range(rest):
                z[pivots + i] -= column[i] * part
