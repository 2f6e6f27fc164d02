"""How tests are shared between processes: file by file, because fixtures are dear; examples one by one."""

from __future__ import annotations

import pytest


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Name the group of each test for ``pytest --dist loadgroup``: the smallest groups are run last."""
    for item in items:
        if item.path.name != "test_examples.py":
            item.add_marker(
                pytest.mark.xdist_group(item.path.relative_to(item.config.rootpath).with_suffix("").as_posix())
            )
