"""How fine a mesh and how many modes an impact asks for, before anything is simulated.

A sphere of mass m and radius R that meets an elastic solid at the speed v compresses it, by Hertz and without waves,

    delta = (15 m v^2 / (16 E* sqrt(R)))^(2/5),   F = 4/3 E* sqrt(R) delta^(3/2),   a = (3 F R / (4 E*))^(1/3)
    T = 2.943275 delta / v = 2.868266 (m^2 / (R E*^2 v))^(1/5)

for two bodies with the effective 1/m = 1/m_1 + 1/m_2, 1/R = 1/R_1 + 1/R_2 and 1/E* = (1 - nu_1^2)/E_1 +
(1 - nu_2^2)/E_2. T tells which frequencies f are excited, and these which elements h <= c/(20 f) and which modes are
needed: 20 elements a wavelength, and 9 pairs of nodes and segments in the contact patch.
Sources: Chen, Liu & Hong 2015; Seifried 2003.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from lcpflex.basics import libs
from lcpflex.basics.arguments import flag
from lcpflex.bodies.body import Body
from lcpflex.errors import ModelError, as_number, in_range, shown

if TYPE_CHECKING:
    from lcpflex.bodies.fem.finite_elements import FiniteElements

__all__ = [
    "PAIRS",
    "PER_WAVELENGTH",
    "ContactAdvice",
    "HasMesh",
    "HasModes",
    "contact_advice",
    "contact_pairs",
    "contact_radius",
    "contact_time",
    "effective",
    "effective_modulus",
    "element_size",
    "excited_frequency",
    "modes_needed",
    "wave_speed",
]


def __dir__() -> list[str]:
    return sorted(__all__)


PAIRS = 9  # in the contact patch
MOST_PAIRS = 1e12  # nobody has more
PER_WAVELENGTH = 20  # elements
ALONG_IMPACT = 0.25  # of the size elsewhere, through a part that is thin that way
FRACTION = 0.1  # of the static share of a pulse, below which a frequency counts as not excited


class HasMesh(Protocol):
    """A mesh or set of matrices."""

    def finite_elements(self) -> FiniteElements: ...


class HasModes(Protocol):
    """A beam or bar."""

    def reduce(self, modes: int | None) -> Body: ...


def _positive(name: str, value: float) -> float:
    return in_range(name, value, 0.0, math.inf, open_ends=True)


def wave_speed(youngs_modulus: float, density: float) -> float:
    """c = sqrt(E / rho) of longitudinal waves in a slender rod [m/s]; E [Pa], rho [kg/m^3], both > 0."""
    return math.sqrt(_positive("youngs_modulus", youngs_modulus) / _positive("density", density))


def element_size(frequency: float, wave_speed: float, per_wavelength: float = PER_WAVELENGTH) -> float:
    """Longest element h = c / (n f) [m] with n elements a wavelength at the frequency f [Hz] and wave speed c [m/s].

    With c of :func:`wave_speed`, waves of shear and of surfaces, 0.55 to 0.65 times as fast, get 11 to 13 elements; for
    the bending of thin parts, which is slower still, give c = sqrt(2 pi f) (E I / (rho A))^(1/4).

    Source: Chen, Liu & Hong 2015; Seifried 2003 (n = 20).
    """
    n = in_range("per_wavelength", per_wavelength, 1.0, math.inf)
    return _positive("wave_speed", wave_speed) / (n * _positive("frequency", frequency))


def effective(first: float, second: float) -> float:
    """1 / (1/x + 1/y): effective mass or radius of two bodies, > 0; infinite for a wall or a plane."""
    for name, value in (("first", first), ("second", second)):
        if not as_number(value) > 0.0:
            raise ModelError(f"{name}: {shown(value)} was given, expected a number > 0, infinite for a wall or a plane")
    inverse = 1.0 / as_number(first) + 1.0 / as_number(second)
    return 1.0 / inverse if inverse > 0.0 else math.inf


def effective_modulus(first: tuple[float, float], second: tuple[float, float] | None = None) -> float:
    """E* [Pa] of two solids (Young's modulus [Pa], Poisson's ratio); None: the second is rigid."""
    total = 0.0
    for name, solid in (("first", first), ("second", second)):
        if solid is not None or name == "first":
            if not isinstance(solid, tuple | list) or len(solid) != 2:
                raise ModelError(f"{name}: {shown(solid)} was given, expected (Young's modulus [Pa], Poisson's ratio)")
            nu = in_range(f"{name}: Poisson's ratio", solid[1], -1.0, 0.5)
            total += (1.0 - nu * nu) / _positive(f"{name}: Young's modulus", solid[0])
    return float(1.0 / total)


def _compression(mass: float, radius: float, modulus: float, speed: float) -> float:
    m, r, e, v = (
        _positive(name, value)
        for name, value in (("mass", mass), ("radius", radius), ("modulus", modulus), ("speed", speed))
    )
    return math.pow(15.0 * m * v * v / (16.0 * e * math.sqrt(r)), 0.4)


def contact_time(mass: float, radius: float, modulus: float, speed: float) -> float:
    """T = 2.868266 (m^2 / (R E*^2 v))^(1/5) [s], how long a Hertzian impact lasts.

    Effective ``mass`` [kg], ``radius`` [m] (see :func:`effective`) and ``modulus`` [Pa] (:func:`effective_modulus`) of
    the two bodies, ``speed`` of approach [m/s]; all > 0. It takes the bodies as rigid but for the contact: waves that
    come back during it, as in a short rod, or that carry energy off change T.
    """
    # 2 * integral from 0 to 1 of (1 - x^(5/2))^(-1/2) dx = (4/5) sqrt(pi) Gamma(2/5) / Gamma(9/10)
    shape = 0.8 * math.sqrt(math.pi) * math.gamma(0.4) / math.gamma(0.9)
    return shape * _compression(mass, radius, modulus, speed) / speed


def excited_frequency(contact_time: float, fraction: float = FRACTION) -> float:
    """Highest frequency [Hz] that a contact of duration T excites to more than ``fraction`` of what f = 0 gets.

    The spectrum of a half-sine pulse sin(pi t / T) relative to that at f = 0 is |cos(pi f T)| / |1 - (2 f T)^2|. It has
    zeros, so its envelope 1 / ((2 f T)^2 - 1) is taken: with fraction p,

        f = sqrt(1 + 1/p) / (2 T)

    and no frequency beyond has more than p; 1.66 / T for a tenth. Contacts with steeper fronts than a half sine, such
    as flat ends that meet at once, excite more.
    """
    p = in_range("fraction", fraction, 0.0, 1.0, open_ends=True)
    return math.sqrt(1.0 + 1.0 / p) / (2.0 * _positive("contact_time", contact_time))


def contact_radius(force: float, radius: float, modulus: float) -> float:
    """a = (3 F R / (4 E*))^(1/3) [m] of the Hertzian patch under the force F [N]; R [m] and E* [Pa] effective."""
    load = _positive("force", force) * _positive("radius", radius)
    return float((0.75 * load / _positive("modulus", modulus)) ** (1.0 / 3.0))


def contact_pairs(contact_radius: float, element_size: float, half_section: bool = False) -> int:
    """How many nodes a patch of radius (half width) a holds in a line through its middle, where one is: 2 [a/h] + 1.

    In the half section of a solid of revolution, which ends in the middle, they are [a/h] + 1.
    """
    a, h = _positive("contact_radius", contact_radius), _positive("element_size", element_size)
    if not a / h <= MOST_PAIRS:
        raise ModelError(f"element_size: {h!r} m was given, expected at least {1.0 / MOST_PAIRS:g} of contact_radius")
    beside = math.floor(a / h * (1.0 + 1e-12))
    return beside + 1 if flag("half_section", half_section) else 2 * beside + 1


def modes_needed(body: Body | HasMesh | HasModes, frequency: float) -> int:
    """Number of free elastic modes of a body with natural frequencies up to ``frequency`` [Hz]: ``modes`` of scene.add.

    Of a mesh they are counted without being computed: by Sylvester's law, K - omega^2 M has as many negative pivots as
    there are modes below omega, rigid ones included.

    Raises
    ------
    ModelError
        For a body whose own modes do not reach that far: give the mesh that it was reduced from.
    """
    omega = 2.0 * math.pi * _positive("frequency", frequency)
    if isinstance(body, Body):
        known = body.frequencies()[: body.modes - body.residual_modes]  # residual ones are no vibrations
        highest = float(known.max(initial=0.0))
        if len(known) and highest < omega:
            raise ModelError(
                f"body: its {len(known)} modes end at {highest / (2.0 * math.pi):.4g} Hz, expected some above "
                f"{frequency:g} Hz; give what it was reduced from, which knows all of them"
            )
        return int(np.count_nonzero(known <= omega))
    mesh_of = getattr(body, "finite_elements", None)
    if mesh_of is None:
        reduce = getattr(body, "reduce", None)
        if reduce is None:
            raise ModelError(f"body: {shown(body)} was given, expected a Body, or what can be reduced to one")
        return modes_needed(reduce(modes=None), frequency)
    mesh: FiniteElements = mesh_of()
    return max(_negative_pivots(mesh.stiffness - omega**2 * mesh.mass) - int(mesh.rigid.shape[1]), 0)


def _negative_pivots(matrix: Any) -> int:
    """Negative eigenvalues of a sparse symmetric matrix: pivots of its L D L^T, with pivoting on the diagonal only."""
    factors = libs.splu(
        matrix.tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
    )
    return int(np.count_nonzero(factors.U.diagonal() < 0.0))


@dataclass(frozen=True, slots=True)
class ContactAdvice:
    """What an impact asks of meshes, modes and steps; printed as text.

    Attributes
    ----------
    duration : of the contact, by Hertz [s]
    peak_force : by Hertz [N]
    radius : of the contact patch at the peak [m]
    frequency : highest frequency excited [Hz]; free modes are needed up to it
    size_at_contact : longest element in the contact patch [m]
    size_elsewhere : longest element where the waves go [m], of each wave speed that was given
    step : longest step of a time-stepping scheme [s]: 20 in a period of the highest frequency
    """

    duration: float
    peak_force: float
    radius: float
    frequency: float
    size_at_contact: float
    size_elsewhere: tuple[float, ...]
    step: float

    @property
    def size_along_impact(self) -> tuple[float, ...]:
        """Longest edge along the impact through the part that is struck [m]: a quarter of ``size_elsewhere``.

        Source: Chen, Liu & Hong 2015 (rule 2). In 20 mm of steel, two layers put the velocity behind the contact off
        by 5 % of the speed of approach, ten, of a quarter of 8.5 mm, by 0.3 %; the peak force changes by 0.5 % in both.
        """
        return tuple(ALONG_IMPACT * size for size in self.size_elsewhere)

    def __str__(self) -> str:
        sizes, along = (
            " and ".join(f"{1e3 * size:.3g} mm" for size in wanted)
            for wanted in (self.size_elsewhere, self.size_along_impact)
        )
        return "\n".join([
            f"contact lasts about {1e6 * self.duration:.4g} us with a peak of about {self.peak_force:.4g} N (Hertz)",
            f"it excites frequencies up to about {1e-3 * self.frequency:.3g} kHz: keep free modes up to there, and "
            "residual modes at the contact (scene.add(body, modes=...))",
            f"contact patch: radius {1e3 * self.radius:.3g} mm; elements there of at most "
            f"{1e3 * self.size_at_contact:.2g} mm, for {PAIRS} pairs in contact",
            f"elements elsewhere of at most {sizes}, {PER_WAVELENGTH} to the shortest wave; along the impact, through "
            f"the thickness of what is struck, of at most {along}",
            f"steps of at most {1e6 * self.step:.2g} us",
        ])  # fmt: skip


def contact_advice(
    mass: float,
    radius: float,
    modulus: float,
    speed: float,
    *wave_speeds: float,
    half_section: bool = False,
    fraction: float = FRACTION,
) -> ContactAdvice:
    """What the impact of two bodies asks for; ``wave_speeds`` [m/s] are those of the bodies that deform (at least one).

    The other arguments are those of :func:`contact_time`, :func:`contact_pairs` and :func:`excited_frequency`.
    """
    if not wave_speeds:
        raise ModelError("wave_speeds: none was given, expected that of each body that deforms")
    compression = _compression(mass, radius, modulus, speed)
    in_range("fraction", fraction, 0.0, 1.0, open_ends=True)
    try:
        duration = contact_time(mass, radius, modulus, speed)
        force = 4.0 / 3.0 * modulus * math.sqrt(radius) * compression**1.5
        patch = contact_radius(force, radius, modulus)
        frequency = excited_frequency(duration, fraction)
        _positive("frequency", frequency)
    except (ModelError, ArithmeticError) as error:  # of what was computed from them
        given = f"mass {mass:g}, radius {radius:g}, modulus {modulus:g}, speed {speed:g}, fraction {fraction:g}"
        raise ModelError(f"{given}: {error}, expected an impact whose force and time are numbers") from error
    return ContactAdvice(
        duration=duration,
        peak_force=force,
        radius=patch,
        frequency=frequency,
        size_at_contact=patch / (PAIRS - 1 if flag("half_section", half_section) else (PAIRS - 1) // 2),
        size_elsewhere=tuple(element_size(frequency, c) for c in wave_speeds),
        step=1.0 / (PER_WAVELENGTH * frequency),
    )
