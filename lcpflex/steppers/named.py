"""Contacts and bodies in words."""

from __future__ import annotations

from collections.abc import Callable

__all__ = ["listed"]

LISTED = 6  # that are named


def listed(numbers: list[int], name: Callable[[int], str], one: str = "contact", several: str = "contacts") -> str:
    """Contacts, or what else is named ``one``, by their names, the first ones where they are many."""
    more = f" and {len(numbers) - LISTED} more" if len(numbers) > LISTED else ""
    return f"{several if len(numbers) > 1 else one} " + ", ".join(map(name, numbers[:LISTED])) + more
