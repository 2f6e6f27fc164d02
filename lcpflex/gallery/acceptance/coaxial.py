"""Acceptance of impacts between meshed solids of revolution."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lcpflex.gallery.acceptance import measures
from lcpflex.gallery.acceptance.check import Absent, Check, Entry, Quantity
from lcpflex.gallery.mechanisms.coaxial import cases
from lcpflex.steppers.generalized_alpha.stepper import GeneralizedAlpha
from lcpflex.steppers.moreau_jean.stepper import MoreauJean

if TYPE_CHECKING:
    from lcpflex.results.result import Result

__all__ = ["checks"]

SPEED = 0.3  # of the ball at first [m/s]
MODEL = "the reference has a half space and one-dimensional waves in place of a solid rod; the methods differ by 0.1 %"
IMPLICIT = (
    f"{MODEL}; theta = 1/2 fails: modes far faster than the step ring undamped, each contact adds to them, and the run "
    "warns of energy created"
)
STIFF = (
    "compliances of contact nodes as modes of up to some GHz: explicit steps follow them, 190 000 in all; in five "
    "minutes it comes to the rebound of generalised-alpha within 1e-5"
)
LAW = "needs a law of contact stiffness, which is what the meshes replace"


def checks() -> tuple[Check, ...]:
    """Those of this module."""
    (case,) = cases()
    known = case.reference
    return (
        Check(
            case,
            (
                Quantity("contact time", known["contact_time"], "s", measures.contact_end, instant=True),
                Quantity("peak force", known["force"], "N", measures.peak_force),
                Quantity("ball / v0", known["ball"], "", lambda r: _speed(r, "ball") / SPEED),
                Quantity("rod / v0", known["rod"], "", lambda r: _speed(r, "rod") / SPEED),
                Quantity(
                    "restitution", known["restitution"], "", lambda r: (_speed(r, "rod") - _speed(r, "ball")) / SPEED
                ),
            ),
            {
                "Moreau-Jean": Entry(MoreauJean(step=1e-7, theta=0.6), IMPLICIT),
                "event-driven": Absent(STIFF),
                "generalised-alpha": Entry(GeneralizedAlpha(step=5e-7), MODEL),
                "massless boundary": Entry(case.stepper, MODEL),
                "smooth": Absent(LAW),
            },
            record=5e-7,
        ),
    )


def _speed(result: Result, body: str) -> float:
    """Of a body along the axis, on average over its mass, at the end [m/s]."""
    assert result.compiled is not None
    first = int(result.compiled.model.bodies.dof[result.compiled.layout.bodies.index(body)])
    return float(result.u[-1, first])
