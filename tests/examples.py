"""The examples as modules."""

from __future__ import annotations

import importlib.util
from functools import cache
from pathlib import Path
from types import ModuleType

__all__ = ["EXAMPLES", "example"]

EXAMPLES = sorted((Path(__file__).parents[1] / "examples").glob("*.py"))


@cache
def example(name: str) -> ModuleType:
    """``examples/NAME.py``, which is no package."""
    (path,) = (path for path in EXAMPLES if path.stem == name)
    specification = importlib.util.spec_from_file_location(name, path)
    assert specification is not None
    assert specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module
