"""Acceptance of cases whose contacts give way: for force laws alone."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from lcpflex.basics import libs
from lcpflex.gallery.acceptance import measures
from lcpflex.gallery.acceptance.check import Absent, Check, Entry, Quantity
from lcpflex.gallery.mechanisms.stops import cases

if TYPE_CHECKING:
    from lcpflex.results.result import Result

__all__ = ["checks"]

RIGID = Absent("the contact of this stepper is rigid: the compliance of the stop is no part of its law")
OTHERS = dict.fromkeys(("Moreau-Jean", "event-driven", "generalised-alpha", "massless boundary"), RIGID)


def checks() -> tuple[Check, ...]:
    """Those of this module."""
    known = {case.name: case for case in cases()}
    stop, hinged, beam, rod = (known[k] for k in ("elastic_stop", "hinged_beam", "sphere_on_beam", "sphere_on_rod"))
    return (
        Check(
            stop,
            (
                Quantity("contact time", stop.reference["contact_time"], "s", lambda r: _passages(r)[0]),
                Quantity("flight", stop.reference["flight"], "s", lambda r: np.diff(_passages(r))[0]),
                Quantity("peak force", stop.reference["force"], "N", measures.peak_force),
            ),
            {**OTHERS, "smooth": Entry(stop.stepper)},
            record=1e-5,
        ),
        Check(
            hinged,
            (
                Quantity("contact end", hinged.reference["contact_end"], "s", measures.contact_end, instant=True),
                Quantity("deepest", hinged.reference["deepest"], "m", lambda r: float(r.gap[:, 0].min())),
                Quantity("time of it", hinged.reference["deepest_time"], "s", _deepest_time, instant=True),
                Quantity("peak force", hinged.reference["force"], "N", measures.peak_force),
                Quantity("rigid rate", hinged.reference["rigid_rate"], "rad/s", _rigid_rate),
            ),
            {**OTHERS, "smooth": Entry(hinged.stepper)},
            record=1e-6,
        ),
        Check(
            beam,
            (
                Quantity("contact time", beam.reference["contact_time"], "s", measures.contact_end, instant=True),
                Quantity("peak force", beam.reference["force"], "N", measures.peak_force),
                Quantity(
                    "rebound / v0",
                    beam.reference["rebound"],
                    "",
                    lambda r: float(r.velocity("ball", "center")[-1, 1]) / -0.01,
                ),
                Quantity("energy in mode 1", beam.reference["mode_1"], "", lambda r: _mode_share(r, 1)),
                Quantity("energy in mode 3", beam.reference["mode_3"], "", lambda r: _mode_share(r, 3)),
            ),
            {**OTHERS, "smooth": Entry(beam.stepper)},
            record=1e-8,
        ),
        Check(
            rod,
            (
                Quantity("contact time", rod.reference["contact_time"], "s", measures.contact_end, instant=True),
                Quantity("peak force", rod.reference["force"], "N", measures.peak_force),
                Quantity(
                    "ball / v0", rod.reference["ball"], "", lambda r: float(r.velocity("ball", "center")[-1, 0]) / 0.3
                ),
                Quantity("rod / v0", rod.reference["rod"], "", lambda r: float(r.u[-1, 0]) / 0.3),
                Quantity(
                    "restitution",
                    rod.reference["restitution"],
                    "",
                    lambda r: float(r.u[-1, 0] - r.velocity("ball", "center")[-1, 0]) / 0.3,
                ),
            ),
            {**OTHERS, "smooth": Entry(rod.stepper)},
            record=1e-8,
        ),
    )


def _passages(result: Result) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Times at which the mass passes the stop, by cubics through its places and speeds [s]."""
    roots = libs.CubicHermiteSpline(result.times, result.q[:, 1] - 0.1, result.u[:, 1]).roots(extrapolate=False)
    return np.asarray(roots[roots > 1e-3])


def _deepest_time(result: Result) -> float:
    return float(result.times[np.argmax(result.force[:, 0, 0])])


def _rigid_rate(result: Result) -> float:
    """Angular momentum about the hinge, from the impulse at the tip, over the rigid inertia [rad/s]."""
    length = 0.783
    mass = 2400.0 * 0.014**2 * length
    return -3.8 + measures.total_impulse(result) * length / (mass * length**2 / 3.0)


def _mode_share(result: Result, k: int) -> float:
    """Energy in mode k of the simply supported beam over the initial energy of the ball, at the end."""
    length, side, density, modulus = 0.1535, 0.01, 7960.0, 2.157463e11
    x = np.linspace(0.0, length, 61)
    w, v = (np.array([of("beam", (s, 0.5 * side))[-1, 1] for s in x]) for of in (result.point, result.velocity))
    shape = np.sin(k * math.pi * x / length)
    amplitude, rate = (2.0 * float(np.mean((y * shape)[:-1])) for y in (w - 0.5 * side, v))
    omega = (k * math.pi / length) ** 2 * math.sqrt(modulus * side**2 / 12.0 / density)
    energy = 0.25 * density * side**2 * length * (rate**2 + (omega * amplitude) ** 2)
    return energy / float(result.energies.kinetic[0])
