"""Names of the parts of a scene: given, or counted."""

from __future__ import annotations

from collections.abc import Mapping

from lcpflex.basics.arguments import listed, text
from lcpflex.errors import ModelError, shown

__all__ = ["free_name"]


def free_name(kind: str, name: str | None, taken: Mapping[str, object]) -> str:
    """``name``, or the first free of kind1, kind2, ... counted from how many there are."""
    if name is None:
        number = 1 + len(taken)
        while f"{kind}{number}" in taken:
            number += 1
        return f"{kind}{number}"
    ground = ("ground",) if kind == "body" else ()
    if text("name", name) in taken or name in ground:
        known = listed([*ground, *taken])
        raise ModelError(f"name: {shown(name)} was given twice, expected a name other than {known}")
    return name
