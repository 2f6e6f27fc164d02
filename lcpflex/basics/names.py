"""The name that was meant where a known one is mistyped. It imports no numpy: ``import lcpflex`` comes by here."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches
from typing import Any

__all__ = ["meant", "nearest"]

LONGEST = 100  # characters of a word that is compared


def nearest(value: Any, known: Iterable[str]) -> str:
    """``: did you mean 'x'?`` where a known name is near; else empty."""
    found = _closest(value, known)
    return f": did you mean {found!r}?" if found else ""


def meant(word: str, known: Iterable[str]) -> str:
    """``" (did you mean 'pendulum'?)"`` for 'pendulm' among known names; empty where none is near."""
    found = _closest(word, known)
    return f" (did you mean {found!r}?)" if found else ""


def _closest(value: Any, known: Iterable[str]) -> str:
    """The known name that is nearest, without regard to case and to hyphen or underscore; empty where none is near."""
    if not isinstance(value, str) or len(value) > LONGEST:
        return ""
    plain = {_plain(name): name for name in known if isinstance(name, str)}
    found = get_close_matches(_plain(value), plain, n=1)
    return plain[found[0]] if found else ""


def _plain(name: str) -> str:
    return name.casefold().replace("_", "-")
