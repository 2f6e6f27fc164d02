"""Numbers that are written in a caller, for its callees the same as any other numbers."""

from __future__ import annotations

from typing import Any

from numba import types

__all__ = ["without_literals"]


def without_literals(args: Any, kws: Any) -> tuple[Any, Any]:
    """Argument types of a call, those of literals replaced by the types of their values.

    Numba would compile a callee once more for each literal it is given.
    """
    return tuple(map(types.unliteral, args)), {name: types.unliteral(kind) for name, kind in kws.items()}
