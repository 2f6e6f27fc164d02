"""Contacts in words."""

from __future__ import annotations

from collections.abc import Callable

__all__ = ["listed"]

LISTED = 6  # contacts that are named


def listed(contacts: list[int], name: Callable[[int], str]) -> str:
    """Contacts by their names, the first ones where they are many."""
    more = f" and {len(contacts) - LISTED} more" if len(contacts) > LISTED else ""
    return ("contacts " if len(contacts) > 1 else "contact ") + ", ".join(map(name, contacts[:LISTED])) + more
