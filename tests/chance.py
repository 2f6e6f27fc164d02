"""hypothesis with the same examples in every run: in the whole suite or in a file alone, today or tomorrow.

``pytest --hypothesis-seed=1 tests/property`` tries others. What fails with one of them is wrong, the test or the code.
"""

from __future__ import annotations

from hypothesis import assume, core, given, settings, strategies as st
from hypothesis.internal.conjecture import providers

__all__ = ["assume", "given", "settings", "st"]

# No clock (deadline), and nothing that is kept from an earlier run (database).
settings.register_profile("same", derandomize=core.global_force_seed is None, deadline=None, database=None)
settings.load_profile("same")

# hypothesis mixes in numbers that stand in the source of whichever modules of ours are loaded: other examples for each
# choice and order of tests. To look for them takes a third of a second of each collection besides.
if hasattr(providers, "_get_local_constants"):
    NONE = providers.Constants()
    providers._get_local_constants = lambda: NONE
