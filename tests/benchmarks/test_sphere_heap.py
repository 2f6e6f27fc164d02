"""A loose heap of spheres that was laid to rest stays, and each step of it is solved; its costs are in a table."""

from __future__ import annotations

import pytest

from tests.benchmarks.sphere_heap import TOLERANCE, Heap

COUNT, SEED, STEPS = 200, 1, 500


@pytest.mark.slow
def test_a_loose_heap_of_spheres_rests_with_each_step_solved() -> None:
    """Undamped, for half a second: not by a thousandth of the gap that counts as closed does a sphere move."""
    heap = Heap(COUNT, SEED)
    assert heap.stop() > 0
    rest = heap.rest(STEPS)
    assert rest.unsolved == 0
    assert rest.strict <= TOLERANCE
    assert rest.fastest <= 1e-6
    assert rest.moved <= 1e-8
    assert rest.contacts > 2 * COUNT
