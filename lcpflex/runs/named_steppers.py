"""Names of steppers, for the command line and for ``simulate``: one list of them, and what each of them is."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from lcpflex.basics.names import meant
from lcpflex.errors import ModelError, shown
from lcpflex.runs import later

__all__ = ["NAMES", "kind_named"]

NAMES = {
    "moreau-jean": "MoreauJean",
    "event-driven": "EventDriven",
    "generalized-alpha": "GeneralizedAlpha",
    "massless-boundary": "MasslessBoundary",
    "smooth": "Smooth",
}


def kind_named(name: Any) -> Callable[..., Any]:
    """The class of the stepper of that name; ModelError for a name of none, and for the one that needs a stiffness."""
    if not isinstance(name, str) or name not in NAMES:
        near = meant(name, NAMES) if isinstance(name, str) else ""
        raise ModelError(
            f"stepper: {shown(name)} was given{near}, expected a stepper such as MoreauJean(step=1e-4), None, or one "
            f"of {', '.join(map(repr, NAMES))}"
        )
    if name == "smooth":
        raise ModelError(
            "stepper: 'smooth' was given, and its contacts need a stiffness: expected "
            "lf.Smooth(lf.Penalty(stiffness)), in N/m"
        )
    kind: Callable[..., Any] = getattr(later, NAMES[name])
    return kind
