"""What collecting the tests costs: every process of a parallel run collects all of them."""

from __future__ import annotations

DEAR = {"matplotlib", "PIL", "skfem", "meshio", "h5py", "pandas", "xarray"}


def test_no_library_is_loaded_that_few_tests_need(loaded_by_collecting: set[str]) -> None:
    """They come from tests.libs, when a test first uses them."""
    assert not DEAR & loaded_by_collecting
