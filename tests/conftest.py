"""How tests are shared between processes: file by file, because fixtures are dear; examples one by one."""

from __future__ import annotations

from typing import Any

import pytest


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """``--dist loadfile`` but for the examples, which would be the longest file; the smallest pieces are run last."""
    if config.getvalue("dist") != "loadfile":
        return None
    from xdist.scheduler import LoadFileScheduling

    class Scheduling(LoadFileScheduling):
        def _split_scope(self, nodeid: str) -> str:
            return nodeid if "test_examples.py" in nodeid else super()._split_scope(nodeid)

    return Scheduling(config, log)
