"""Names that a module loads when they are first used: those that it imports for type checkers.

    if TYPE_CHECKING:
        from lcpflex.bodies.beam import Beam as Beam

    __getattr__, __dir__ = attach(__name__)

``as Beam`` tells type checkers that the name is public; ``import *``, all that ``__all__`` of that module lists.
``__all__``, where it is not written, is all of the block. So each name is written once, with its home: type checkers
and the import linter read the lines that are carried out later (PEP 562; packages of scientific Python do the same with
stub files, SPEC 1). ``import lcpflex`` comes by here, and loads neither numpy nor what only the first use needs.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from functools import cache
from importlib import import_module
from typing import Any

from lcpflex.basics.garbage import without_collections
from lcpflex.basics.renamed import renamed_name

__all__ = ["attach"]


def attach(
    module: str, label: str | None = None, renamed: Mapping[str, str] | None = None
) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """``__getattr__`` and ``__dir__`` of the module of that name.

    Parameters
    ----------
    module
        ``__name__`` of a module with a block ``if TYPE_CHECKING:`` of imports, each ``from home import name``,
        ``from home import *`` or ``import home as name``.
    label
        What messages call the module, its name if omitted.
    renamed
        New names by old ones, which are loaded with a warning (:mod:`lcpflex.basics.renamed`).

    Returns
    -------
    tuple
        ``__getattr__``, which loads a name of the block at its first use, and raises AttributeError with the nearest
        public name for any other; and ``__dir__``, the names of the block and of ``__all__`` where that is written.
    """

    @cache
    def homes() -> dict[str, tuple[str, str]]:
        return _homes(module)

    def names() -> list[str]:
        return sorted({*homes(), *vars(sys.modules[module]).get("__all__", ())})

    def load(name: str) -> Any:
        if renamed and name in renamed:
            return renamed_name(module, name, renamed, label or module)
        if name == "__all__":
            return names()
        if name.startswith("__") or name not in homes():
            from lcpflex.basics.names import nearest

            told = "" if name.startswith("_") else nearest(name, names())  # tools ask for __path__, _mock_name ...
            raise AttributeError(f"module {label or module!r} has no attribute {name!r}{told}")
        home, there = homes()[name]
        with without_collections():
            value = getattr(import_module(home), there) if there else import_module(home)
        setattr(sys.modules[module], name, value)
        return value

    return load, names


def _homes(module: str) -> dict[str, tuple[str, str]]:
    """Module, and name in it, of each name that the block for type checkers imports; no name for a whole module."""
    import ast

    found: dict[str, tuple[str, str]] = {}
    for block in _statements(module):
        if isinstance(block, ast.If) and ast.unparse(block.test) == "TYPE_CHECKING":
            for line in block.body:
                if isinstance(line, ast.ImportFrom) and line.module:
                    names = _listed(line.module) if line.names[0].name == "*" else ()
                    found |= {name: (line.module, name) for name in names}
                    found |= {one.asname or one.name: (line.module, one.name) for one in line.names if not names}
                elif isinstance(line, ast.Import):
                    found |= {one.asname or one.name: (one.name, "") for one in line.names}
    return found


def _listed(module: str) -> list[str]:
    """What ``__all__`` holds where it is written, of a module that is not loaded for it."""
    import ast

    lines = (line for line in _statements(module) if isinstance(line, ast.Assign))
    return next(ast.literal_eval(line.value) for line in lines if ast.unparse(line.targets[0]) == "__all__")


def _statements(module: str) -> list[Any]:
    """The source of a module, as its parser has it."""
    import ast
    from importlib.util import find_spec

    spec = find_spec(module)
    source = getattr(spec.loader, "get_source", lambda _: None)(spec.name) if spec is not None else None
    return ast.parse(source or "").body
