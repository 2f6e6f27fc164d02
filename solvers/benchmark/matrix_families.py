"""Complementarity problems given by a matrix: worst cases of pivoting, random classes, and the failures of solvers.

Each family is a function of a random generator and of a size; it yields a few examples of about that many unknowns.
Those that name no source are built here.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from lcpflex.jit.kernel import FloatArray
from lcpflex.solvers.benchmark.example import Example, planted
from lcpflex.solvers.problem import Lcp, Status

__all__ = [
    "badly_scaled",
    "bimatrix",
    "csizmadia",
    "cycling",
    "degenerate",
    "fathi",
    "full_rank",
    "hilbert",
    "infeasible",
    "kkt",
    "murty",
    "obstacle",
    "random_general",
    "random_p",
    "rank_deficient",
    "skew",
    "ties",
    "trivial",
    "unsolvable",
]

Rng = np.random.Generator


def _murty_matrix(n: int) -> FloatArray:
    return np.eye(n) + 2.0 * np.tril(np.ones((n, n)), -1)


def _substituted(M: FloatArray, q: FloatArray) -> FloatArray:
    """The one solution where M is lower triangular with a positive diagonal: row after row in closed form."""
    z = np.zeros(len(q))
    for i in range(len(q)):
        z[i] = max(-(q[i] + M[i, :i] @ z[:i]) / M[i, i], 0.0)
    return z


def _planted(name: str, rng: Rng, M: FloatArray, kind: str, unique: str, degenerate: float = 0.1) -> Example:
    q, z = planted(rng, M, degenerate=degenerate)
    return Example(name, Lcp(M, q), kind, Status.SOLVED, z, unique)


def trivial(rng: Rng, n: int) -> Iterator[Example]:
    """What needs no algorithm: no unknowns, q >= 0, a diagonal matrix, the zero matrix."""
    free = np.abs(rng.standard_normal(n))
    B = rng.standard_normal((n, n))
    scale = rng.uniform(0.5, 2.0, n)
    q = rng.standard_normal(n)
    yield Example("trivial: empty", Lcp(np.zeros((0, 0)), np.zeros(0)), "symmetric", Status.SOLVED, np.zeros(0), "z")
    yield Example(f"trivial: q >= 0, {n}", Lcp(B @ B.T, free), "symmetric", Status.SOLVED, np.zeros(n), "motion")
    yield Example(f"trivial: q = 0, {n}", Lcp(B @ B.T, np.zeros(n)), "symmetric", Status.SOLVED, np.zeros(n), "motion")
    yield Example(
        f"trivial: diagonal {n}", Lcp(np.diag(scale), q), "symmetric", Status.SOLVED, np.maximum(-q, 0.0) / scale, "z"
    )
    yield Example(
        f"trivial: zero matrix {n}", Lcp(np.zeros((n, n)), free), "symmetric", Status.SOLVED, np.zeros(n), "motion"
    )


def murty(rng: Rng, n: int) -> Iterator[Example]:
    """Murty 1978 (Math. Programming Study 7): 1 on the diagonal, 2 below; Lemke's textbook path takes 2^n pivots."""
    M = _murty_matrix(n)
    geometric = -np.cumsum(np.exp2(np.arange(min(n, 40))[::-1]))  # of more terms, rounding would leave too few digits
    for name, block, q in (
        ("q = -1", M, -np.ones(n)),
        ("geometric q", M[: len(geometric), : len(geometric)], geometric),
    ):
        yield Example(f"murty {len(q)}, {name}", Lcp(block, q), "P", Status.SOLVED, _substituted(block, q), "z")
    q = rng.standard_normal(n)
    yield Example(f"murty {n}, random q", Lcp(M, q), "P", Status.SOLVED, _substituted(M, q), "z")


def fathi(rng: Rng, n: int) -> Iterator[Example]:
    """Fathi 1979 (Math. Programming 17): the symmetric product L L^T of Murty's matrix with as long a path."""
    L = _murty_matrix(n)
    M = L @ L.T
    first = np.zeros(n)
    first[0] = 1.0  # M e_1 = (1, 2, 2, ...)
    yield Example(f"fathi {n}, q = -1", Lcp(M, -np.ones(n), L), "symmetric", Status.SOLVED, first, "z")
    yield Example(f"fathi {n}, geometric q", Lcp(M, -np.exp2(np.arange(n))), "symmetric", Status.SOLVED)
    yield _planted(f"fathi {n}, planted", rng, M, "symmetric", "z")


def csizmadia(rng: Rng, n: int) -> Iterator[Example]:
    """Csizmadia's matrix (de Klerk & E.-Nagy 2011): 1 on the diagonal, -1 below; its handicap grows like 4^n."""
    n = min(n, 30)  # for q = -1 the solution is 2^i
    M = np.eye(n) - np.tril(np.ones((n, n)), -1)
    for name, q in (("q = -1", -np.ones(n)), ("random q", rng.standard_normal(n))):
        z = _substituted(M, q)
        yield Example(f"csizmadia {n}, {name}", Lcp(M, q), "P", Status.SOLVED, z, "z")
        upper = np.ascontiguousarray(M[::-1, ::-1])
        yield Example(f"csizmadia upper {n}, {name}", Lcp(upper, q[::-1]), "P", Status.SOLVED, z[::-1].copy(), "z")
    yield _planted(f"csizmadia transposed {n}", rng, M.T, "P", "z")


def cycling(rng: Rng, n: int) -> Iterator[Example]:
    """Circulants I + a S, S the cyclic shift (after Kostreva 1979, Math. Programming 16): unprotected pivoting and
    sweeps run in circles.

    Proper principal blocks are triangular and the determinant is 1 + a^n for odd n: a P-matrix.
    """
    n |= 1
    shift = np.roll(np.eye(n), 1, axis=1)
    M = np.eye(n) + 2.0 * shift
    yield Example(f"cycling {n}", Lcp(M, -np.ones(n)), "P", Status.SOLVED, np.full(n, 1.0 / 3.0), "z")
    yield _planted(f"cycling {n}, planted", rng, np.eye(n) + 1.9 * shift, "P", "z", 0.0)
    q = -np.ones(n)
    q[int(rng.integers(n))] = -1.1
    yield Example(f"cycling {n}, no symmetry", Lcp(M, q), "P", Status.SOLVED)


def random_p(rng: Rng, n: int) -> Iterator[Example]:
    """P-matrices (Cottle, Pang & Stone 1992, 3.3): definite and not symmetric, rows and columns scaled, dominant."""
    B = rng.standard_normal((n, n))
    definite = B @ B.T / n + 0.1 * np.eye(n) + B - B.T
    rows, columns = 10.0 ** rng.uniform(-2, 2, (2, n))
    yield _planted(f"random P: definite {n}", rng, definite, "P", "z")
    # Positive factors on rows and columns leave the signs of all principal minors as they are.
    yield _planted(f"random P: scaled {n}", rng, definite * np.outer(rows, columns), "P", "z")
    rest = rng.standard_normal((n, n))
    np.fill_diagonal(rest, 0.0)
    dominant = rest + np.diag(np.abs(rest).sum(axis=1) + 0.1)
    yield _planted(f"random P: dominant {n}", rng, dominant, "P", "z")


def full_rank(rng: Rng, n: int) -> Iterator[Example]:
    """Symmetric definite matrices J J^T as of contacts on many bodies, with and without a known solution."""
    J = rng.standard_normal((n, n + 3))
    M = J @ J.T
    q, z = planted(rng, M)
    yield Example(f"full rank {n}, planted", Lcp(M, q, J), "symmetric", Status.SOLVED, z, "z")
    yield Example(f"full rank {n}, random q", Lcp(M, rng.standard_normal(n)), "symmetric", Status.SOLVED)


def rank_deficient(rng: Rng, n: int) -> Iterator[Example]:
    """J J^T with J (n, k), k < n: contacts that are redundant. M z is unique, z is not (Cottle, Pang & Stone 3.1.7)."""
    for rank in sorted({max(1, n // 4), max(1, n // 2)}):
        J = rng.standard_normal((n, rank))
        M = J @ J.T
        q, z = planted(rng, M)
        yield Example(f"rank {rank} of {n}, planted", Lcp(M, q, J), "symmetric", Status.SOLVED, z, "motion")
        # q = J v is orthogonal to the null space of J^T: no vector can prove the problem infeasible.
        yield Example(f"rank {rank} of {n}, q = J v", Lcp(M, J @ rng.standard_normal(rank)), "symmetric", Status.SOLVED)
    copies = rng.integers(max(1, n // 3), size=n)
    J = rng.standard_normal((max(1, n // 3), n + 2))[copies]
    q, z = planted(rng, J @ J.T)
    yield Example(f"copies of rows {n}", Lcp(J @ J.T, q), "symmetric", Status.SOLVED, z, "motion")


def degenerate(rng: Rng, n: int) -> Iterator[Example]:
    """Half of the pairs have z = w = 0: every ratio test of a pivoting method is a tie."""
    J = rng.standard_normal((n, n + 2))
    yield _planted(f"degenerate {n}", rng, J @ J.T, "symmetric", "z", 0.5)
    J = rng.standard_normal((n, max(1, (2 * n) // 3)))
    yield _planted(f"degenerate and rank-deficient {n}", rng, J @ J.T, "symmetric", "motion", 0.5)
    J = rng.integers(-2, 3, (n, n)).astype(float)
    integer = J @ J.T + np.eye(n)
    z = rng.integers(0, 2, n).astype(float)
    yield Example(f"degenerate integers {n}", Lcp(integer, -integer @ z), "symmetric", Status.SOLVED, z, "z")


def ties(rng: Rng, n: int) -> Iterator[Example]:
    """All entries equal: every row is the same candidate to leave the basis."""
    for extra in (0.0, 1.0):
        M = np.ones((n, n)) + extra * np.eye(n)
        q = np.where(rng.random(n) < 0.3, 0.0, -1.0)
        loaded = q < 0.0
        z = loaded / max(loaded.sum() + extra, 1.0)
        yield Example(
            f"ties {n}, diagonal {1 + extra:g}", Lcp(M, q), "symmetric", Status.SOLVED, z, "z" if extra else "motion"
        )


def hilbert(rng: Rng, n: int) -> Iterator[Example]:
    """Hilbert's matrix 1 / (i + j - 1): definite, yet singular to rounding from n = 12 on."""
    n = min(n, 12)
    i = np.arange(1.0, n + 1.0)
    M = 1.0 / (i[:, None] + i[None, :] - 1.0)
    yield _planted(f"hilbert {n}", rng, M, "symmetric", "motion", 0.0)
    yield Example(f"hilbert {n}, q = -1", Lcp(M, -np.ones(n)), "symmetric", Status.SOLVED)


def badly_scaled(rng: Rng, n: int) -> Iterator[Example]:
    """A definite problem in units from 1e-6 to 1e6, one for each unknown: D M D, D q and z / D."""
    J = rng.standard_normal((n, n + 2))
    M = J @ J.T
    q, z = planted(rng, M)
    D = 10.0 ** rng.uniform(-6, 6, n)
    yield Example(f"badly scaled {n}", Lcp(M * np.outer(D, D), q * D), "symmetric", Status.SOLVED, z / D, "motion")


def obstacle(rng: Rng, n: int) -> Iterator[Example]:
    """A string over an obstacle (Cottle, Pang & Stone 1992): second differences, and their inverse."""
    M = 2.0 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    yield _planted(f"obstacle {n}", rng, M, "symmetric", "z")
    yield _planted(f"obstacle {n}, inverse", rng, np.asarray(np.linalg.inv(M), dtype=float), "symmetric", "z")
    i = np.arange(1.0, n + 1.0)
    yield Example(f"obstacle {n}, lifted", Lcp(M, -np.ones(n)), "symmetric", Status.SOLVED, 0.5 * i * (n + 1 - i), "z")
    yield Example(f"obstacle {n}, waves", Lcp(M, 0.05 * np.cos(6 * np.pi * i / n)), "symmetric", Status.SOLVED)


def kkt(rng: Rng, n: int) -> Iterator[Example]:
    """Optimality conditions of a convex quadratic program, [[H, -A^T], [A, 0]]: semidefinite, zeros on the diagonal."""
    k = max(1, n // 2)
    A = rng.standard_normal((max(1, n - k), k)).round(1)
    for rank in sorted({max(1, k // 2), k}):
        B = rng.standard_normal((k, rank))
        M = np.block([[B @ B.T, -A.T], [A, np.zeros((len(A), len(A)))]])
        yield _planted(f"kkt {len(M)}, H of rank {rank}", rng, M, "semidefinite", "")


def skew(rng: Rng, n: int) -> Iterator[Example]:
    """B B^T plus a skew part: semidefinite and far from symmetric."""
    for rank in sorted({0, max(1, n // 2)}):
        B, K = rng.standard_normal((n, rank)), rng.standard_normal((n, n))
        yield _planted(f"skew {n}, symmetric part of rank {rank}", rng, B @ B.T + K - K.T, "semidefinite", "")


def bimatrix(rng: Rng, n: int) -> Iterator[Example]:
    """Games with positive costs, [[0, A], [B^T, 0]] and q = -1: an equilibrium exists (Nash), ties are many."""
    k = max(1, n // 2)
    Z = np.zeros((k, k))
    A, B = rng.integers(1, 6, (2, k, k)).astype(float)
    yield Example(
        f"bimatrix {2 * k}, integers", Lcp(np.block([[Z, A], [B.T, Z]]), -np.ones(2 * k)), "general", Status.SOLVED
    )
    A, B = rng.uniform(1.0, 2.0, (2, k, k))
    yield Example(f"bimatrix {2 * k}", Lcp(np.block([[Z, A], [B.T, Z]]), -np.ones(2 * k)), "general", Status.SOLVED)


def random_general(rng: Rng, n: int) -> Iterator[Example]:
    """No class at all: a planted solution that no method is bound to find, and problems of unknown outcome."""
    n = min(n, 12)
    yield _planted(f"random planted {n}", rng, rng.standard_normal((n, n)), "general", "")
    yield Example(f"random {n}", Lcp(rng.standard_normal((n, n)), rng.standard_normal(n)), "general", None)
    near = np.diag(rng.uniform(-1, 1, n)) + 0.3 * rng.standard_normal((n, n))
    yield Example(f"signs of the diagonal {n}", Lcp(near, rng.standard_normal(n)), "general", None)


def infeasible(rng: Rng, n: int) -> Iterator[Example]:
    """Semidefinite without solution: u >= 0 with M u = 0 and q.u < 0, a body squeezed from both sides."""
    k = max(1, n // 2)
    half = rng.standard_normal((k, k + 1))
    J = np.vstack([half, -half])
    G = half @ half.T
    M = np.block([[G, -G], [-G, G]])  # J J^T of which M u = 0 holds in floats, however BLAS sums
    q = J @ rng.standard_normal(k + 1) - 1.0  # rows i and k + i ask for opposite velocities of at least 1
    yield Example(f"squeeze {2 * k}", Lcp(M, q), "symmetric", Status.INFEASIBLE, certificate=np.ones(2 * k))
    one = np.zeros(2 * k)
    one[[0, k]] = 1.0
    q = J @ rng.standard_normal(k + 1) + 1.0
    q[[0, k]] -= 2.0  # one pair squeezes, all others leave room
    yield Example(f"squeeze of one pair {2 * k}", Lcp(M, q), "symmetric", Status.INFEASIBLE, certificate=one)
    last = np.zeros(n)
    last[-1] = 1.0
    yield Example(
        f"zero matrix {n}", Lcp(np.zeros((n, n)), 1.0 - 2.0 * last), "symmetric", Status.INFEASIBLE, certificate=last
    )


def unsolvable(rng: Rng, n: int) -> Iterator[Example]:
    """Feasible, but not by complementary z and w: w_2 > 0 forces z_2 = 0, and then w_1 = -z_1 - 1 < 0."""
    M, q = np.array([[-1.0, 2.0], [1.0, 1.0]]), np.array([-1.0, 1.0])
    yield Example("unsolvable 2", Lcp(M, q), "general", Status.NO_SOLUTION)
    n = min(max(n, 3), 12)
    rest = rng.standard_normal((n - 2, n - 2))
    larger = np.block([[M, np.zeros((2, n - 2))], [np.zeros((n - 2, 2)), rest @ rest.T + np.eye(n - 2)]])
    load = np.concatenate([q, rng.standard_normal(n - 2)])
    order = rng.permutation(n)
    yield Example(f"unsolvable {n}", Lcp(larger[np.ix_(order, order)], load[order]), "general", Status.NO_SOLUTION)
