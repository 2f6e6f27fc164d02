"""The energy audit: where the energy of a simulation is, where it went, and what nobody can explain."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from enum import Enum
from typing import Any

import numpy as np

from lcpflex.basics.alarm import FINER, Alarm
from lcpflex.dynamics.applied_forces import FOLLOWER, FORCE
from lcpflex.dynamics.time_functions import HARMONIC, PIECES
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray

__all__ = [
    "AT_REST",
    "GROWTH",
    "Energies",
    "EnergyGrowth",
    "created",
    "energy_doubts",
    "energy_warnings",
    "held_energy",
    "is_of_energy",
    "load_energy",
]

GROWTH = 1e-4  # created energy, relative to the largest stored one, above which a result warns
REMAINDER = 0.02  # unexplained energy, likewise; and energy that grew without work, above which a result is in doubt
FORCES = FORCE, FOLLOWER  # of the plane and of space; other loads are torques
HALF = 0.5  # of the stored energy, by which none grows where something moves
AT_REST = 1e-3  # of what loads would do over the size of a body: where no more is stored, things rest
ROUNDING = 1e-10  # stored energy below this, relative to the potential energy, cannot be told from rounding


class EnergyGrowth(Enum):
    """What is to be done about contact impulses that create energy, which no real contact does.

    Newton's law of restitution does so with friction in some states (Kane's double pendulum); so may too long a step.
    """

    ERROR = "the run ends with a StepError that says when and how much"
    WARN = "the result has a warning that says when and how much"
    ACCEPT = "nothing: the energies of the result show it"


@dataclass(frozen=True, slots=True, eq=False)
class Energies:
    """Energies at the m stored instants, each (m,) [J].

    ``kinetic``, ``elastic`` (deformation of bodies) and ``potential`` (gravity and springs) are stored now.
    ``friction``, ``impact`` and ``damping`` were dissipated since the start (positive = lost), ``work`` was done by
    loads and drives since the start. What these leave over,

        remainder = (kinetic + elastic + potential) - (the same at the start) - work + friction + impact + damping,

    is unexplained: integration error, projection, and anything that is wrong.
    """

    kinetic: FloatArray
    elastic: FloatArray
    potential: FloatArray
    friction: FloatArray
    impact: FloatArray
    damping: FloatArray
    work: FloatArray
    remainder: FloatArray

    def __post_init__(self) -> None:
        expected = np.shape(self.kinetic)
        for field in fields(self):
            shape = np.shape(getattr(self, field.name))
            if shape != expected or len(shape) != 1:
                raise ModelError(f"energies.{field.name}: shape {shape}; expected that of kinetic, {expected}, (m,)")

    @classmethod
    def audit(
        cls,
        kinetic: FloatArray,
        elastic: FloatArray,
        potential: FloatArray,
        friction: FloatArray,
        impact: FloatArray,
        damping: FloatArray,
        work: FloatArray,
    ) -> Energies:
        """Draw up the balance: the seven measured energies, each (m,) [J], and the remainder they leave."""
        stored = kinetic + elastic + potential
        start = stored[0] if stored.size else 0.0
        with np.errstate(invalid="ignore"):  # a state that is no longer finite leaves a remainder that is not
            remainder = stored - start - work + friction + impact + damping
        return cls(kinetic, elastic, potential, friction, impact, damping, work, remainder)

    @property
    def stored(self) -> FloatArray:
        """Kinetic + elastic + potential energy, (m,) [J]; the zero of the potential is arbitrary."""
        return self.kinetic + self.elastic + self.potential

    @property
    def dissipated(self) -> FloatArray:
        """Lost to friction, impacts and damping since the start, (m,) [J]."""
        return self.friction + self.impact + self.damping

    @property
    def rounding(self) -> float:
        """Stored energy that cannot be told from rounding [J]: ROUNDING times the largest potential energy."""
        return ROUNDING * float(np.max(np.abs(self.potential), initial=0.0))

    @property
    def scale(self) -> float:
        """Largest stored energy [J], with the potential, which has no zero of its own, counted from its lowest value.

        Where nothing moves, ROUNDING times the potential energy stands in: its rounding errors are no motion.
        """
        if not self.kinetic.size:
            return 0.0
        return max(float(np.max(self.stored) - np.min(self.potential)), self.rounding)

    @property
    def growth(self) -> float:
        """By how much the stored energy was above that of the start and the work of loads and drives, at most [J]."""
        if not self.kinetic.size:
            return 0.0
        own = _since_start(self)
        return float(np.max(own) - own[0])

    @property
    def given_back(self) -> float:
        """Energy that contacts have given back beyond what they had taken, and impacts alone, too [J]; 0 if none.

        Their normal and their frictional part may each give where the other takes: what counts is both.
        """
        taken = self.impact + self.friction
        back = float(np.max(np.maximum.accumulate(taken) - taken, initial=0.0))
        return min(back, max(0.0, -float(np.min(self.impact, initial=0.0))))

    @property
    def largest_remainder(self) -> float:
        """Largest absolute unexplained energy [J]; NaN if any is."""
        return float(np.max(np.abs(self.remainder), initial=0.0))

    @property
    def relative_remainder(self) -> float:
        """Largest unexplained energy relative to the largest stored one; 0 where nothing ever moved."""
        unexplained, scale = self.largest_remainder, self.scale
        if unexplained == 0.0:
            return 0.0
        return unexplained / scale if scale > 0.0 else float("inf")


def load_energy(compiled: Any) -> float:
    """What weights and loads do over the size of the largest body [J], torques over a radian; 0 without a scene.

    Of loads that are given in numbers, at their largest; functions of a user's count for nothing.
    """
    if compiled is None:
        return 0.0
    model, size = compiled.model, float(compiled.size)
    loads = model.loads
    total = size * float(model.bodies.mass.sum() * np.linalg.norm(loads.gravity))
    for kind, signals in zip(loads.force_kind.tolist(), loads.force_signal.tolist(), strict=True):
        largest = [_largest(model.signals, signal) for signal in signals if signal >= 0]
        total += math.hypot(*largest) * (size if kind in FORCES else 1.0)
    return total


def held_energy(compiled: Any, times: FloatArray, impulse: FloatArray) -> float:
    """The same, and what the mean forces of contacts would do: from it on down to rounding nothing has moved [J].

    impulse: (m, nc, parts) of contacts since the start.
    """
    if compiled is None or not times.size or not times[-1] > times[0]:
        return load_energy(compiled)
    pressed = float(np.abs(impulse[-1]).sum()) / float(times[-1] - times[0])
    return load_energy(compiled) + float(compiled.size) * pressed


def _largest(signals: Any, index: int) -> float:
    """Largest size of a function of time that is given in numbers."""
    first, last, kind = int(signals.first[index]), int(signals.last[index]), int(signals.kind[index])
    if kind == HARMONIC:
        return float(np.abs(signals.coefficients[first, :2]).sum())
    return float(np.abs(signals.coefficients[first:last, 3]).max(initial=0.0)) if kind == PIECES else 0.0


CREATED, GREW, UNEXPLAINED = "contact impulses created energy", "the energy grew by", "of energy are unexplained"
NOT_FINITE, GAVE = "the energies are no longer finite", ", which only takes energy, gave"


def is_of_energy(text: str) -> bool:
    """Whether a text is a warning of :func:`energy_warnings` about energies, or a clause of :func:`energy_doubts`."""
    return any(words in text for words in (CREATED, GREW, UNEXPLAINED, NOT_FINITE, GAVE))


def created(gain: tuple[float, float, float], cause: str) -> str:
    """How much energy contact impulses created, when, and why."""
    return f"{CREATED}: {gain[0]:.4g} J in all, most at once {gain[1]:.4g} J at t = {gain[2]:.6g} s ({cause})"


def energy_warnings(
    energies: Energies,
    gain: tuple[float, float, float],
    complete: bool,
    energy_growth: EnergyGrowth,
    steps: int,
    cause: str,
    tolerance: float = 0.0,
    held: float = 0.0,
) -> tuple[str, ...]:
    """What a reader must know before trusting the result.

    ``tolerance``: relative error of a step that was asked for; energies, which are squares, may err by twice that.
    ``held``: that of :func:`held_energy`: what rests has no other to compare with.
    """
    warnings = [] if complete else ["the run is incomplete"]
    if not energies.remainder.size:
        return tuple(warnings)
    scale = energies.scale
    if not np.isfinite(energies.remainder).all():
        return (*warnings, NOT_FINITE)
    least = max(energies.rounding, ROUNDING * held)
    rounding = least * math.sqrt(max(steps, 1))  # that of all steps, at random
    accepted = 0.0
    if energy_growth is EnergyGrowth.ACCEPT:
        accepted = float(gain[0])
    elif gain[0] > max(GROWTH * scale, rounding):
        warnings.append(created(gain, cause))
    growth = energies.growth
    allowed = max(GROWTH, min(2.0 * tolerance, REMAINDER))
    if growth - accepted > max(allowed * scale, rounding):
        warnings.append(f"{GREW} {growth:.4g} J ({_part(growth, scale)} of the largest stored) without work of loads")
    if energies.relative_remainder > REMAINDER and energies.largest_remainder > ROUNDING * held:
        warnings.append(
            f"{energies.largest_remainder:.4g} J {UNEXPLAINED} ({energies.relative_remainder:.2g} of the "
            "largest stored): use a shorter step or tighter tolerances"
        )
    return tuple(warnings)


def energy_doubts(
    energies: Energies,
    gain: tuple[float, float, float],
    energy_growth: EnergyGrowth,
    steps: int,
    loads: float = 0.0,
    held: float = 0.0,
    passive: bool = True,
    moved: bool = False,
    growth: float | None = None,
    times: FloatArray | None = None,
) -> tuple[Alarm, ...]:
    """Energy that came from nowhere, so that the result is not to be trusted.

    More than REMAINDER of the largest of what was stored, of the work that was done, and of AT_REST times ``loads``,
    that of :func:`load_energy` [J]: where nothing moves the stored energy is no measure. Where something has ``moved``,
    what grew by HALF of the stored energy is in doubt, too, however much more loads could do. ``held``: as of
    :func:`energy_warnings`. What contact impulses created is no doubt where the user accepts it. ``passive``: dampers
    and bodies only take energy, which those of a user's own system need not. ``growth`` [J]: the part of that of the
    energies that is certain; None: all. ``times`` (m,) [s] of the energies, to say when.
    """
    if not np.isfinite(energies.remainder).all():
        return ()
    rounding = max(energies.rounding, ROUNDING * held) * math.sqrt(max(steps, 1))
    unit = max(energies.scale, AT_REST * loads, float(np.max(np.abs(energies.work), initial=0.0)))
    accepted = float(gain[0]) if energy_growth is EnergyGrowth.ACCEPT else 0.0
    found = []
    fed = max(0.0, -float(np.min(energies.damping, initial=0.0))) if passive else 0.0
    for value, what, of in (
        (energies.growth if growth is None else growth, f"{GREW} {{}} without work of loads", _since_start(energies)),
        (energies.given_back, f"contact{GAVE} {{}}", -energies.impact - energies.friction),
        (fed, f"damping{GAVE} {{}}", -energies.damping),
    ):
        limit = min(REMAINDER * unit, HALF * energies.scale) if moved else REMAINDER * unit
        if value - accepted > max(limit, rounding):
            told = f"{value:.4g} J ({_part(value, unit)} of the largest energy stored or work done)"
            when = None if times is None else float(times[int(np.argmax(of))])
            clause = what.format(told) + ("" if when is None else f" by t = {when:.6g} s")
            found.append(Alarm(clause, "energy", "", when, value, FINER))
    return tuple(found)


def _since_start(energies: Energies) -> FloatArray:
    """Stored energy without the work of loads (m,) [J]."""
    return energies.stored - energies.work


def _part(value: float, scale: float) -> str:
    """One by the other, where there is anything to compare with."""
    return f"{value / scale:.2g}" if scale > 0.0 else "all"
