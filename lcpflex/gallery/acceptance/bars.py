"""Acceptance of elastic bars."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from lcpflex.bodies.bar import Bar
from lcpflex.force_laws.penalty import Penalty
from lcpflex.gallery.acceptance import measures
from lcpflex.gallery.acceptance.check import Absent, Check, Entries, Entry, Quantity, Refused
from lcpflex.gallery.mechanisms.bars import LENGTH, cases, courant_step
from lcpflex.gallery.mechanisms.user_systems import cases as user_cases
from lcpflex.steppers.event_driven.stepper import EventDriven
from lcpflex.steppers.generalized_alpha.stepper import GeneralizedAlpha
from lcpflex.steppers.massless_boundary.stepper import MasslessBoundary
from lcpflex.steppers.moreau_jean.stepper import MoreauJean
from lcpflex.steppers.smooth.stepper import ExplicitRungeKutta, Smooth

if TYPE_CHECKING:
    from lcpflex.jit.kernel import FloatArray
    from lcpflex.results.result import Result
    from lcpflex.runs.case import Case

__all__ = ["checks", "prestressed_error"]

TRANSIT = 2.0 * LENGTH / 30.0  # time of a wave there and back [s]
MANY = "the mass at the contact bounces: many small impacts, each with a loss"
LOOSE = ExplicitRungeKutta(rtol=1e-6, atol=1e-8)
MASSLESS = Entry(MasslessBoundary())


def checks() -> tuple[Check, ...]:
    """Those of this module."""
    known = {case.name: case for case in (*cases(), *user_cases())}
    return (
        _wall(known["elastic_bar"]),
        *(_modal(known[f"modal_bar_{n}"]) for n in (1, 2, 3)),
        _nodal(known["impacting_bar"]),
        _pair(known["two_bars"]),
        _prestressed(known["prestressed_bar"]),
        _foot(known["bar_with_foot"]),
    )


def _wall(case: Case) -> Check:
    reference = case.reference
    return Check(
        case,
        (
            Quantity("force", reference["force"], "N", measures.mean_force(0.55, 1.1)),
            Quantity("contact end", reference["last_contact"], "s", measures.contact_end, instant=True),
            Quantity("rebound", reference["rebound"], "m/s", measures.last_speed(0)),
            Quantity("impulse", reference["impulse"], "N s", measures.total_impulse),
            Quantity("energy kept", 1.0, "", measures.energy_kept),
        ),
        _entries(case, courant_step(LENGTH / 400, 30.0), Entry(_law(3e5), slow=True)),
        record=1e-4,
    )


def _entries(case: Case, step: float, smooth: Entry | Absent, massless: Entry | Refused = MASSLESS) -> Entries:
    """What the steppers make of a bar in nodal coordinates; ``step`` [s]: of generalised-alpha."""
    return {
        "Moreau-Jean": Entry(case.stepper),
        "event-driven": Entry(EventDriven(rtol=1e-6), MANY, slow=True),
        "generalised-alpha": Entry(GeneralizedAlpha(step=step)),
        "massless boundary": massless,
        "smooth": smooth,
    }


def _law(stiffness: float) -> Smooth:
    """A penalty [N/m] in place of the contact."""
    return Smooth(Penalty(stiffness), integrator=LOOSE)


def _modal(case: Case) -> Check:
    reference = case.reference
    step = 1e-4 * TRANSIT
    keeps = Absent("the law is that of a mass at the contact, which an impact stops; this stepper keeps that energy")
    return Check(
        case,
        (
            Quantity("energy loss", reference["energy_loss"], "", lambda r: 1.0 - measures.energy_kept(r)),
            Quantity("rebound", reference["rebound"], "m/s", measures.last_speed(0)),
            Quantity("contact end", reference["last_contact"], "s", measures.contact_end, instant=True),
        ),
        {
            "Moreau-Jean": Entry(MoreauJean(step=step)),
            "event-driven": Entry(EventDriven()),
            "generalised-alpha": Entry(GeneralizedAlpha(step=step)),
            "massless boundary": keeps,
            "smooth": keeps,
        },
        duration=1.3,
        record=step,
    )


def _nodal(case: Case) -> Check:
    reference = case.reference
    own = Absent("the numbers are those of the Moreau-Jean scheme with this step, not of the bar")
    weight = np.asarray(case.build().mass).sum(axis=1)  # type: ignore[union-attr]

    def rebound(result: Result) -> float:
        return float(weight @ result.u[-1] / weight.sum())

    return Check(
        case,
        (
            Quantity(
                "impulse / m v0",
                reference["relative_impulse"],
                "",
                lambda r: measures.total_impulse(r) / weight.sum() / 0.1,
            ),
            Quantity("rebound", reference["rebound"], "m/s", rebound),
            Quantity("energy kept", 0.99400, "", measures.energy_kept),
        ),
        {
            "Moreau-Jean": Entry(case.stepper),
            "event-driven": own,
            "generalised-alpha": own,
            "massless boundary": Refused(
                MasslessBoundary(), "user's own system", "a user's own system has no modes that could be massless"
            ),
            "smooth": own,
        },
    )


def _pair(case: Case) -> Check:
    reference = case.reference

    def interface(result: Result) -> float:
        middle = (result.times > 0.2) & (result.times < 0.7)
        return float(result.velocity("struck", "left")[middle, 0].mean())

    return Check(
        case,
        (
            Quantity("force", reference["force"], "N", measures.mean_force(0.15, 0.7)),
            Quantity("interface speed", reference["interface_speed"], "m/s", interface),
            Quantity("contact end", 0.1 + reference["contact_time"], "s", measures.contact_end, instant=True),
            Quantity("struck bar", reference["struck"], "m/s", measures.last_speed(203)),
            Quantity("striker", 0.0, "m/s", measures.last_speed(0), scale=10.0),
        ),
        _entries(case, courant_step(LENGTH / 200, 30.0), Entry(_law(1e5), slow=True)),
        record=1e-4,
    )


def _prestressed(case: Case) -> Check:
    return Check(
        case,
        (
            Quantity("displacement, r.m.s.", 0.0, "m", prestressed_error, scale=0.5),
            Quantity("energy", case.reference["energy"], "J", lambda r: float(r.energies.stored[-1])),
            Quantity("force", case.reference["force"], "N", measures.mean_force(1.1, 1.9)),  # at rest, first period
        ),
        _entries(case, courant_step(0.01, 1.0), Entry(_law(1e3))),
        record=0.02,
    )


def _foot(case: Case) -> Check:
    return Check(
        case,
        (
            Quantity("slow", case.reference["slow"], "m/s", lambda r: float(_foot_speeds(r)[::2].mean())),
            Quantity("fast", case.reference["fast"], "m/s", lambda r: float(_foot_speeds(r)[1::2].mean())),
        ),
        _entries(
            case,
            courant_step(LENGTH / 400, 30.0),
            Absent("a creep far below the speed of the pull takes millions of explicit steps on this mesh"),
            Refused(MasslessBoundary(), "compliance", "the bar does not give way across itself"),
        ),
        record=1e-3,
    )


def prestressed_motion(x: FloatArray, t: FloatArray) -> FloatArray:
    """Displacement (instants, places) of the bar of period 3 [m], by d'Alembert's formula on each third of it."""
    phase, place = (t % 3.0)[:, None], x[None, :]
    falling = 0.5 * (1.0 - np.maximum(place, phase))
    since = phase - 1.0
    resting = -0.5 * np.minimum(np.minimum(place, 1.0 - place), np.minimum(since, 1.0 - since))
    rising = 0.5 * np.minimum(phase - 2.0, 1.0 - place)
    return np.asarray(np.where(phase < 1.0, falling, np.where(phase < 2.0, resting, rising)))


def prestressed_error(result: Result) -> float:
    """Root of the mean square of the displacement error over places and times [m]."""
    elements = result.q.shape[1] - 3
    body = Bar(length=1.0, area=1.0, density=1.0, youngs_modulus=1.0, elements=elements).reduce(modes=None)
    x = np.linspace(0.0, 1.0, elements + 1)
    shapes = np.array([body.locate(place, 0.0).phi[:, 0] for place in x])
    error = result.q[:, :1] + result.q[:, 3:] @ shapes.T - prestressed_motion(x, result.times)
    return float(np.sqrt(np.mean(error**2)))


def _foot_speeds(result: Result) -> FloatArray:
    """Mean speeds of the foot between arrivals of waves [m/s]."""
    arrivals = (2.0 * np.arange(5) + 1.0) * LENGTH / math.sqrt(900.0)
    foot = np.interp(arrivals, result.times, result.point("bar", "left")[:, 0])
    return np.asarray(np.diff(foot) / TRANSIT)
