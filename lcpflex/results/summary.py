"""A result in words: what ran, what touched, where the energy went, and how far to trust it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from lcpflex.model.arrays import OPEN
from lcpflex.results.contact_history import CLOSED
from lcpflex.results.doubts import largest, loosest
from lcpflex.results.heading import heading
from lcpflex.results.modal_coordinates import modal_coordinates
from lcpflex.results.words import counted, percent, with_unit

if TYPE_CHECKING:
    from lcpflex.jit.kernel import FloatArray
    from lcpflex.results.contact_history import ContactHistory
    from lcpflex.results.result import Result

__all__ = ["lost_in_contacts", "summary"]

ROUNDING = 1e-12  # tangential impulse below this share of the normal one is none
LISTED = 8  # contacts that are described one by one


def summary(result: Result) -> str:
    """Several short paragraphs; the last one is its verdict."""
    parts = [_run(result), _contacts(result), _energy(result), _checks(result), _warnings(result)]
    parts.append(str(result.verdict))
    return "\n\n".join(part for part in parts if part)


def lost_in_contacts(result: Result) -> str:
    """What ``energies.impact`` is to be called: the damping of compliant contacts takes more time than an impact."""
    if result.all_compliant:
        return "lost in contacts"
    return "lost in impacts, contacts" if result.compliant else "lost in impacts"


def _run(result: Result) -> str:
    reached = float(result.times[-1]) if result.times.size else 0.0
    cost = f", {with_unit(result.wall_time / result.steps, 's')} a step" if result.steps else ""
    lines = [
        heading(result),
        f"simulated {with_unit(reached, 's')} in {result.steps:,} steps "
        f"and {with_unit(result.wall_time, 's')} of computing{cost}; "
        f"compiling or loading the kernels took {with_unit(result.compile_time, 's')}",
    ]
    if result.python_calls:
        lines.append(
            f"Python functions of time: {counted(result.python_calls, 'call')} took "
            f"{with_unit(result.python_time, 's')} of the computing; the rest is slow, too, as the loop runs in Python "
            "for them: it stays compiled with functions under numba.njit"
        )
    if not result.complete:
        lines.append(f"INCOMPLETE: {with_unit(reached, 's')} of {with_unit(result.duration, 's')} - {result.message}")
    lines.extend(result.notes)
    largest = int(result.size.max(initial=0))
    lines.append(
        f"{_coordinates(result)}; {_declared(result)}; "
        f"largest contact problem {counted(largest, 'unknown')}; {counted(len(result.times), 'stored instant')}"
    )
    lines.extend(_reduced(result))
    if result.sensors:
        lines.append("sensors: " + "; ".join(str(sensor) for sensor in result.sensors[:LISTED]) + _more(result.sensors))
    return "\n".join(lines)


def _coordinates(result: Result) -> str:
    """How many there are; in space there are more numbers in q than velocities."""
    numbers, velocities = result.q.shape[1], result.u.shape[1]
    return f"{numbers} coordinates" + ("" if numbers == velocities else f" and {velocities} velocities")


def _more(every: Sequence[object]) -> str:
    return f" and {len(every) - LISTED} more" if len(every) > LISTED else ""


def _declared(result: Result) -> str:
    """How many contacts there are."""
    count = len(result.contact_names)
    surfaces = 0 if result.compiled is None else len(result.compiled.layout.rule_surfaces)
    if not surfaces:
        return counted(count, "declared contact")
    return f"{counted(count, 'contact')}, those by the rule for {surfaces:,} surfaces as far as they touched"


def _reduced(result: Result) -> list[str]:
    """What bodies with residual modes were reduced to."""
    if result.compiled is None:
        return []
    every = [modal_coordinates(result.compiled, b) for b in range(len(result.compiled.layout.bodies))]
    return [str(coordinates) for coordinates in every if coordinates.residual.any()]


def _contacts(result: Result) -> str:
    if not result.contact_names:
        return ""
    struck = {event.contact for event in result.events}
    touched = np.flatnonzero(
        (result.state != OPEN).any(axis=0)
        | result.impulse.any(axis=(0, 2))
        | (result.gap <= CLOSED).any(axis=0)
        | [name in struck for name in result.contact_names]
    )
    if not touched.size:
        return "Contacts\n  none touched"
    # stable: equal impulses keep the order of declaration
    listed = touched[np.argsort(-result.impulse[-1, touched, 0], kind="stable")][:LISTED]
    lines = ["Contacts", *(_contact(result.contact(result.contact_names[k])) for k in listed)]
    if len(touched) > LISTED:
        lines.append(f"  and {len(touched) - LISTED} more with smaller impulses")
    lost = result.energies.impact[-1] > 0.0 and not result.all_compliant
    if lost and not any(event.kind == "impact" for event in result.events):
        lines.append("  peak forces count an impact, which takes no time, as its impulse over one step")
    if len(touched) < len(result.contact_names):
        count = len(result.contact_names)
        lines.append(f"  {count - len(touched)} of {count} never touched")
    return "\n".join(lines)


def _contact(history: ContactHistory) -> str:
    _, stick, slip = history.shares
    closed = stick + slip
    how = "closed at no stored instant"
    if closed > 0.0:
        creep = history.creeping
        kinds = [f"{percent(stick / closed)} sticking", f"{percent((slip - creep) / closed)} slipping"]
        if creep > 0.0:
            kinds.append(f"{percent(creep / closed)} creeping, by {with_unit(history.crept, 'm')} in all")
        how = f"closed {percent(closed)} of the time ({', '.join(kinds)})"
    normal = history.impulse[-1, 0]
    assert history.first_touch is not None
    seen = "first touch" if history.first_touch == history.first_event else "first seen touching"
    return (
        f"  {history.name}: {seen} at {history.first_touch:.6g} s; peak force {with_unit(history.peak_force, 'N')}; "
        f"impulse {with_unit(normal, 'N s')} normal, {_rubbed(history)}; {how}"
    )


def _rubbed(history: ContactHistory) -> str:
    """The impulse of friction in all: along the tangent, in space as large as its vector is."""
    normal, *rest = history.impulse[-1].tolist()
    size = rest[0] if len(rest) == 1 else float(np.linalg.norm(rest))
    size = 0.0 if abs(size) < ROUNDING * abs(normal) else size
    return f"{with_unit(size, 'N s')} {'tangential' if len(rest) == 1 else 'of friction'}"


def _energy(result: Result) -> str:
    energies = result.energies
    if not energies.kinetic.size:
        return ""
    rows = [("", "start", "end")]
    for name in ("kinetic", "elastic", "potential"):
        series = getattr(energies, name)
        rows.append((name, f"{series[0]:.6g}", f"{series[-1]:.6g}"))
    rows.append(("work of loads and drives", "", f"{energies.work[-1]:.6g}"))
    for name, label in (
        ("friction", "lost to friction"),
        ("impact", lost_in_contacts(result)),
        ("damping", "lost to damping"),
    ):
        rows.append((label, "", f"{getattr(energies, name)[-1]:.6g}"))
    rows.append(("unexplained", "", f"{energies.remainder[-1]:.3g}"))
    lines = [f"  {label:<26}{start:>14}{end:>14}" for label, start, end in rows]
    lines.append(
        f"  unexplained at most {with_unit(energies.largest_remainder, 'J')}, "
        f"{energies.relative_remainder:.2g} of the largest stored energy ({with_unit(energies.scale, 'J')})"
    )
    return "\n".join(["Energy [J]", *lines])


def _checks(result: Result) -> str:
    indentation = largest(result.penetration if result.all_compliant else _indentation(result))
    when = "" if result.all_compliant else "at the stored instants "
    by_law = f"largest indentation {when}{with_unit(indentation, 'm')}; " if result.compliant else ""
    others = "" if result.all_compliant else f"largest penetration {with_unit(largest(result.penetration), 'm')}; "
    return (
        "Checks\n"
        f"  {by_law}{others}"
        f"largest joint drift {with_unit(largest(result.joint_drift), 'm')}; "
        f"largest residual of a contact problem {largest(result.residual):.1e} of its terms, "
        f"{loosest(result):.1e} of the free velocity"
    )


def _indentation(result: Result) -> FloatArray:
    """Indentations of the compliant contacts at the stored instants [m], all in one array."""
    indented = result.gap[:, np.isin(result.contact_names, result.compliant)]
    return np.asarray(-indented[indented < 0.0])


def _warnings(result: Result) -> str:
    return "\n".join(["Warnings", *(f"  {text}" for text in result.warnings)]) if result.warnings else ""
