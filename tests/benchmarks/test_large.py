"""Large contact problems in body velocities: how their time grows."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from lcpflex.solvers.contact.algebra import PLANAR
from lcpflex.solvers.contact.large.memory import LargeMemory, grown, large_memory
from lcpflex.solvers.contact.large.solving import ROOM, solve_large
from lcpflex.solvers.status import SOLVED
from tests.islands import Island, brick_wall


def next_step(wall: Island) -> tuple[Callable[[], LargeMemory], LargeMemory]:
    """The problem of a pile at rest once more, from its impulses, with free velocities a little different."""
    bodies = len(wall.size)
    status, memory = wall.solve(large_memory(bodies, len(wall.friction), bodies, 3, 2))
    assert status == SOLVED
    start = wall.p.copy()
    shake = 1e-3 * np.abs(wall.free).max() * np.random.default_rng(0).normal(size=(bodies, 3))
    wall.free += wall.jacobian @ shake.ravel() / np.abs(wall.white).max()
    problem = wall.problem()

    def solve() -> LargeMemory:
        wall.p[:] = start
        assert solve_large(problem, memory, PLANAR) == SOLVED
        return memory

    while solve_large(problem, memory, PLANAR) == ROOM:
        memory = grown(memory, {})
    return solve, memory


@pytest.mark.parametrize(("columns", "most"), [(1, 1.2), (0, 1.6)], ids=["towers", "walls"])
def test_time_of_a_factor_grows_little_faster_than_the_pile(
    per_call: Callable[..., float], report: Callable[[str], None], columns: int, most: float
) -> None:
    """Piles that are shaken, to 1e-8 of the free velocities; exponent over the number of contacts.

    Eliminating a grid of n bodies takes n^1.5 operations in any order. How many factors a wall takes grows with it.
    """
    contacts, seconds = [], []
    for size in (64, 144, 324):
        side = round(size**0.5)
        solve, memory = next_step(brick_wall(size, 1) if columns else brick_wall(side, side))
        contacts.append(memory.group.n)
        seconds.append(per_call(solve) / memory.newton.factors)
        assert memory.judged.strict <= 1e-8
        name, factors = "tower" if columns else "wall", memory.newton.factors
        report(f"{name}, {contacts[-1]:5d} contacts: {factors:4d} factors, {1e3 * seconds[-1]:8.4f} ms each")
    exponent = np.polyfit(np.log(contacts), np.log(seconds), 1)[0]
    report(f"exponent {exponent:.2f}")
    assert exponent < most
