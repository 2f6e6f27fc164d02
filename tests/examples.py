"""The examples as modules."""

from __future__ import annotations

import importlib.util
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

__all__ = ["EXAMPLES", "Example", "example"]

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


class Example:
    """``examples/NAME.py``, carried out when one of its names is first asked for: collecting tests needs none."""

    def __init__(self, name: str) -> None:
        self._name = name

    def __getattr__(self, attribute: str) -> Any:
        if attribute.startswith("_"):  # pytest asks each name of a module whether it is a fixture
            raise AttributeError(attribute)
        return getattr(example(self._name), attribute)
