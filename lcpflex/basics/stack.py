"""Where a warning belongs: the line of the user, however deep in lcpflex it is given."""

from __future__ import annotations

import sys

__all__ = ["outside"]


def outside() -> int:
    """The stack level of the caller's caller that is none of lcpflex, for :func:`warnings.warn`."""
    level, frame = 1, sys._getframe(1)
    while frame.f_back is not None and str(frame.f_globals.get("__name__", "")).startswith("lcpflex."):
        level, frame = level + 1, frame.f_back
    return level
