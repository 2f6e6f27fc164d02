"""What mixed and boxed problems of a few unknowns cost beside the LCP that they are."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from lcpflex.solvers import Auto, BoxedLcp, Lcp, MixedLcp

M = np.array([[2.0, 0.5], [0.5, 1.0]])
q = np.array([-1.0, -0.3])
UPPER = np.array([0.2, np.inf])
KINDS: dict[str, Callable[[], MixedLcp | BoxedLcp]] = {
    "mixed": lambda: MixedLcp(M, q, [0]),
    "one bounded twice": lambda: BoxedLcp(M, q, np.zeros(2), UPPER),
    "both bounded twice": lambda: BoxedLcp(M, q, np.zeros(2), np.array([0.2, 0.9])),
}


@pytest.mark.parametrize("kind", KINDS)
def test_two_unknowns_cost_three_times_the_lcp_at_most(
    per_call: Callable[..., float], report: Callable[[str], None], kind: str
) -> None:
    """From the numbers to the certified answer, each time a new problem; least of several, as the machine is shared."""
    solver, make = Auto(), KINDS[kind]

    def own() -> None:
        solver.solve(make())

    def plain() -> None:
        solver.solve(Lcp(M, q))

    assert solver.solve(make()).solved
    pairs = [(per_call(own), per_call(plain)) for _ in range(9)]
    ratio = min(a for a, _ in pairs) / min(b for _, b in pairs)
    report(f"{kind:20s} {1e6 * min(a for a, _ in pairs):6.1f} us, {ratio:.2f} times the LCP")
    assert ratio <= 3.0
