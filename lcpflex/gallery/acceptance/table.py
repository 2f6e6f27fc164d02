"""What every stepper reaches on the reference cases: one table, checked by the tests.

    python -m lcpflex.gallery.acceptance.table          # runs everything and writes ACCURACY.md anew

An error is |measured - reference| divided by the scale of the quantity. Each stepper has its step or tolerance, and
for each quantity a bound on its error (:mod:`lcpflex.gallery.acceptance.bounds`), at most three times what the table
shows.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from lcpflex.accuracy.refinement import brief
from lcpflex.gallery.acceptance import bars, coaxial, plates, rigid, space, space_contact, stops
from lcpflex.gallery.acceptance.check import ROUNDING, Check, Entry, Quantity
from lcpflex.results.result import Result

__all__ = ["LABELS", "Row", "checks", "document", "rows"]

LABELS = ("Moreau-Jean", "event-driven", "generalised-alpha", "massless boundary", "smooth")
CAMPAIGN = "## Random scenes"  # what tests.property.campaign writes begins here
HEAD = """# Accuracy of the steppers on the reference cases

Each number is an error |computed - reference| / scale (scale: |reference|, or what the column says), reached with the
step or tolerance that the line "with" names; a reference with few digits, and the time resolution of a method that
locates no events (one step), limit what can be seen. Moreau-Jean and generalised-alpha are of order one across impacts
and changes of stick, event-driven stepping meets its tolerances; elastic bars have the error of their mesh besides.
"0" is below 1e-9, "-" a method that does not apply, with the reason below the table; seconds are those of one run on
the machine that wrote the file.
Written by `python -m lcpflex.gallery.acceptance.table`; the bounds that the tests hold are in
`lcpflex/gallery/acceptance/bounds.py`.
"""


@dataclass(frozen=True, slots=True)
class Row:
    """One line of the table: a quantity of a check."""

    check: str
    quantity: str
    reference: str
    cells: tuple[str, ...]

    def line(self) -> str:
        """In Markdown."""
        return f"| {' | '.join((self.check, self.quantity, self.reference, *self.cells))} |"


def checks() -> tuple[Check, ...]:
    """All of them."""
    return tuple(
        check for module in (bars, rigid, stops, coaxial, space, space_contact, plates) for check in module.checks()
    )


def rows(check: Check, measure: bool = True) -> list[Row]:
    """The lines of a check; without ``measure`` nothing is run and the cells are those of methods that do not apply."""
    results = {
        label: check.run(entry.stepper)
        for label, entry in check.entries.items()
        if measure and isinstance(entry, Entry)
    }
    lines = [
        Row(check.label, quantity.name, _reference(quantity), tuple(_cell(quantity, results.get(k)) for k in LABELS))
        for quantity in check.quantities
    ]
    steppers = tuple(brief(e.stepper) if isinstance(e := check.entries[k], Entry) else "-" for k in LABELS)
    times = tuple(f"{r.wall_time:.2g} s" if (r := results.get(k)) else "-" for k in LABELS)
    return [*lines, Row(check.label, "with", "", steppers), Row(check.label, "time", "", times)]


def _reference(quantity: Quantity) -> str:
    scale = "" if quantity.scale is None else f" (scale {quantity.scale:.3g})"
    return f"{quantity.reference:.6g} {quantity.unit}".strip() + scale


def _cell(quantity: Quantity, result: Result | None) -> str:
    if result is None:
        return "-"
    error = quantity.error(result)
    return "0" if error < ROUNDING else f"{error:.1e}"


def document(tell: Callable[[str], object] = lambda line: None) -> str:
    """The whole of ACCURACY.md; runs every entry."""
    lines = [HEAD, f"| {' | '.join(('case', 'quantity', 'reference', *LABELS))} |", "|---" * (3 + len(LABELS)) + "|"]
    reasons = []
    for check in checks():
        tell(check.label)
        lines += [row.line() for row in rows(check)]
        reasons += [f"- {check.label}, {k}: {e.why}" for k in LABELS if (e := check.entries[k]).why]
    return "\n".join([*lines, "", "## Why", "", *reasons, ""])


def main() -> None:
    """Write ACCURACY.md into the package; what the campaign over random scenes has written there stays."""
    path = Path(__file__).parents[2] / "ACCURACY.md"
    _, found, campaign = path.read_text(encoding="utf-8").partition(CAMPAIGN)
    path.write_text(document(print) + (f"\n{found}{campaign}" if found else ""), encoding="utf-8")


if __name__ == "__main__":
    main()
