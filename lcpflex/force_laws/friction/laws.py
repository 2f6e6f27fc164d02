"""Friction laws of continuous contact. The coefficient mu is that of the declared contact, the kinetic one.

Written here for the friction force per unit of normal force, f(v) = |lambda_T| / lambda_N at a slip speed v = |gdot_T|;
the force itself opposes the slip, lambda_T = -lambda_N f sgn(gdot_T). No law of these but :class:`LuGre` and
:class:`Bristle` holds anything at rest: under a load that Coulomb's law would hold the others creep. A contact with
mu = 0 has no friction at all, whatever the law: no static and no viscous one.

Laws with a static coefficient mu_s take it as ``static_friction``; None is mu_s = mu, no Stribeck effect.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
import numpy.typing as npt

from lcpflex.basics.options import keep_number, keep_number_or_none
from lcpflex.errors import ModelError, shown
from lcpflex.force_laws import compiled
from lcpflex.force_laws.friction.bristles import Bristle, LuGre
from lcpflex.force_laws.friction.static_friction import (
    check_static_friction,
    common_shape,
    slip_of,
)
from lcpflex.force_laws.layout import FRICTION, PARAMETERS

__all__ = [
    "Ambrosio",
    "ArctangentCoulomb",
    "BengisuAkay",
    "Bristle",
    "BrownMcPhee",
    "LuGre",
    "RampCoulomb",
    "SmoothedCoulomb",
    "Threlfall",
]


class MemorylessFriction:
    """A friction law without states: the force is a function of slip velocity and normal force."""

    __slots__ = ()
    bristles: ClassVar[bool] = False  # it has no states

    if TYPE_CHECKING:
        kind: ClassVar[str]

        @property
        def parameters(self) -> tuple[float, ...]:
            """At most seven."""

    def check(self, mu: float, contact: str) -> None:
        """Any coefficient of friction goes with it."""

    def force(self, slip: npt.ArrayLike, normal: npt.ArrayLike, mu: npt.ArrayLike) -> Any:
        """Tangential force [N] at slip velocities [m/s], under normal forces >= 0 [N], with coefficients mu >= 0.

        Arrays are broadcast; a float for three numbers. Where mu is 0 there is none, as in a run: a contact without
        friction has no static and no viscous part either.

        Raises
        ------
        ModelError
            For what is no finite number, a negative normal force or coefficient, and mu_s < mu.
        """
        given = slip_of(slip, normal, mu)
        shape = common_shape(given)
        flat = [np.broadcast_to(x, shape).ravel() for x in given]
        if flat[2].size > 0:
            self.check(float(flat[2].max()), "mu")
        p = np.zeros(PARAMETERS)
        p[FRICTION : FRICTION + len(self.parameters)] = self.parameters
        kind, out = compiled.FRICTION_KINDS.index(self.kind), np.empty(len(flat[0]))
        compiled.friction_forces(np.array([0, 0, kind, 0]), p, flat[0], flat[1], flat[2], out)
        out[flat[2] == 0.0] = 0.0
        return out.reshape(shape) if shape else float(out[0])


@dataclass(frozen=True, slots=True)
class OneSpeed(MemorylessFriction):
    """Laws whose one parameter is the speed at which friction is about fully developed."""

    slip_speed: float = 1e-3

    def __post_init__(self) -> None:
        keep_number(self, "slip_speed", 0.0, math.inf, open_ends=True)

    @property
    def parameters(self) -> tuple[float, ...]:
        """v_s."""
        return (self.slip_speed,)


@dataclass(frozen=True, slots=True)
class SmoothedCoulomb(OneSpeed):
    """f = mu tanh(v / v_s).

    Attributes
    ----------
    slip_speed
        v_s > 0 [m/s]. Nothing sticks: what Coulomb's law would hold creeps, at up to about v_s.
    """

    kind: ClassVar[str] = "tanh"


@dataclass(frozen=True, slots=True)
class ArctangentCoulomb(OneSpeed):
    """f = mu (2/pi) atan(v / v_s): mu is approached slowly, 0.94 mu at 10 v_s.

    Attributes
    ----------
    slip_speed
        v_s > 0 [m/s], where f = mu/2.
    """

    kind: ClassVar[str] = "arctangent"


@dataclass(frozen=True, slots=True)
class RampCoulomb(OneSpeed):
    """f = mu min(v / v_s, 1).

    Attributes
    ----------
    slip_speed
        v_s > 0 [m/s], from where on f = mu.
    """

    kind: ClassVar[str] = "ramp"


@dataclass(frozen=True, slots=True)
class Threlfall(OneSpeed):
    """f = mu (1 - exp(-3 v / v_r)) up to v_r, and held at its value there, 0.950 mu, beyond.

    Unconfirmed: named after Threlfall 1978, but the formula was not compared with that text; some texts have the force
    jump to mu above v_r. Here it is continuous.

    Attributes
    ----------
    slip_speed
        v_r > 0 [m/s]; 1e-3 to 1e-2 of the typical speed.
    """

    kind: ClassVar[str] = "threlfall"


@dataclass(frozen=True, slots=True)
class Ambrosio(MemorylessFriction):
    """f = 0 below v_0, mu (v - v_0) / (v_1 - v_0) up to v_1, mu beyond: Ambrosio's modified Coulomb law (2003).

    Without any force below v_0 nothing is held at all: a body on an incline slides at v_0 at least.

    Attributes
    ----------
    rest_speed
        v_0 >= 0 [m/s].
    slip_speed
        v_1 > v_0 [m/s].

    Raises
    ------
    ModelError
        For speeds out of their range or order.
    """

    kind: ClassVar[str] = "ambrosio"
    rest_speed: float = 1e-4
    slip_speed: float = 2e-4

    def __post_init__(self) -> None:
        keep_number(self, "rest_speed", 0.0, math.inf)
        keep_number(self, "slip_speed", 0.0, math.inf, open_ends=True)
        if not self.slip_speed > self.rest_speed:
            raise ModelError(f"slip_speed: {shown(self.slip_speed)} was given, expected more than rest_speed")

    @property
    def parameters(self) -> tuple[float, ...]:
        """v_0, v_1."""
        return (self.rest_speed, self.slip_speed)


@dataclass(frozen=True, slots=True)
class BengisuAkay(MemorylessFriction):
    """f = mu_s (1 - (v/v_0 - 1)^2) below v_0, mu + (mu_s - mu) exp(-xi (v - v_0)) above.

    The slope at rest is 2 mu_s / v_0; the force has a kink at v_0. Unconfirmed: named after Bengisu & Akay 1994, but
    the formula was not compared with that text.

    Attributes
    ----------
    slip_speed
        v_0 > 0 [m/s], where friction is largest.
    decay
        xi >= 0 [s/m]: how fast it falls from mu_s to mu.
    static_friction
        mu_s >= mu; None: mu.
    """

    kind: ClassVar[str] = "bengisu_akay"
    slip_speed: float = 1e-3
    decay: float = 1e3
    static_friction: float | None = None

    def __post_init__(self) -> None:
        keep_number(self, "slip_speed", 0.0, math.inf, open_ends=True)
        keep_number(self, "decay", 0.0, math.inf)
        keep_number_or_none(self, "static_friction", 0.0, math.inf)

    @property
    def parameters(self) -> tuple[float, ...]:
        """v_0, mu_s, xi."""
        return (self.slip_speed, self.static_friction or 0.0, self.decay)

    check = check_static_friction


@dataclass(frozen=True, slots=True)
class BrownMcPhee(MemorylessFriction):
    """f = mu tanh(4 x) + (mu_s - mu) x / (x^2/4 + 3/4)^2 + sigma_2 v,   x = v / v_t.

    Smooth of any order, with its peak of about mu_s at v_t (Brown & McPhee 2016). The viscous part is per unit of
    normal force here, so that it begins and ends with the contact.

    Attributes
    ----------
    slip_speed
        v_t > 0 [m/s], the speed of the peak.
    static_friction
        mu_s >= mu; None: mu.
    viscous
        sigma_2 >= 0 [s/m]; a constant in N s/m holds at a load, and is divided by it.
    """

    kind: ClassVar[str] = "brown_mcphee"
    slip_speed: float = 1e-3
    static_friction: float | None = None
    viscous: float = 0.0

    def __post_init__(self) -> None:
        keep_number(self, "slip_speed", 0.0, math.inf, open_ends=True)
        keep_number(self, "viscous", 0.0, math.inf)
        keep_number_or_none(self, "static_friction", 0.0, math.inf)

    @property
    def parameters(self) -> tuple[float, ...]:
        """v_t, mu_s, sigma_2."""
        return (self.slip_speed, self.static_friction or 0.0, self.viscous)

    check = check_static_friction
