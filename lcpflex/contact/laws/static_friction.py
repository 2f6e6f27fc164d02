"""The static coefficient of friction laws that have one."""

from __future__ import annotations

import math

from lcpflex.errors import ModelError, in_range

__all__ = ["check_static_friction", "static_coefficient"]


def check_static_friction(static: float | None, mu: float = 0.0, contact: str = "") -> None:
    """Raise ModelError for a static coefficient that is no number >= 0, or less than the ``mu`` of ``contact``."""
    if static is None:
        return
    in_range("static_friction", static, 0.0, math.inf)
    if static < mu:
        raise ModelError(
            f"static_friction: {static!r} was given, expected at least the friction {mu!r} of contact {contact!r}"
        )


def static_coefficient(static: float | None) -> float:
    """As kernels take it: they use the larger of it and mu."""
    return 0.0 if static is None else float(static)
