"""How methods look in charts: one colour for each family of steppers, wherever it is drawn."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

__all__ = ["FAMILIES", "axis_label", "family_of", "looks_of"]

# Okabe and Ito's colours, told apart with any colour vision; markers say the same without colours.
FAMILIES = {
    "MoreauJean": ("#0072B2", "osvh"),
    "GeneralizedAlpha": ("#D55E00", "D^<d"),
    "EventDriven": ("#009E73", "P>p8"),
    "MasslessBoundary": ("#CC79A7", "X*H^"),
    "Smooth": ("#E69F00", "vPsD"),
}
OTHERS = (("#000000", "*pho"), ("#56B4E9", "hXdp"), ("#7B3294", "d8<v"))  # steppers of the user's own
STYLES = ("-", "--", "-.", ":")


def family_of(stepper: Any) -> str:
    """The name of its class: what schemes that share their equations, and so their mistakes, have in common."""
    return type(stepper).__name__


def looks_of(steppers: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Colour, marker and line style by label, of a stepper for each.

    The colour is that of the family, whatever else is drawn; methods of one family differ in marker and line.
    """
    looks, strangers, counts = {}, list[str](), dict[str, int]()
    for label, stepper in steppers.items():
        family = family_of(stepper)
        if family not in FAMILIES and family not in strangers:
            strangers.append(family)
        known = FAMILIES.get(family)
        colour, markers = known if known is not None else OTHERS[strangers.index(family) % len(OTHERS)]
        k = counts.get(family, 0)
        counts[family] = k + 1
        looks[label] = {"color": colour, "marker": markers[k % len(markers)], "linestyle": STYLES[k % len(STYLES)]}
    return looks


def axis_label(value: Any) -> str:
    """A value of an axis in few characters."""
    if isinstance(value, (float, np.floating)):
        return f"{value:.4g}"
    name = getattr(value, "__name__", None)
    return str(name if name is not None else value)
