"""How laws are told to kernels: numbers of their kinds, and where their parameters stand in one row.

A contact law is an elastic law, a damping and a friction law. Each has the name of its kind, which kernels know by its
place in ``KINDS`` of :mod:`.elastic.kernels`, :mod:`.damping.kernels` or :mod:`.friction.kernels`. ``kinds`` (4,) are
these three and, for a user's law, the address of its compiled function; ``p`` (PARAMETERS,) all their parameters.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

__all__ = [
    "ADDRESS",
    "DAMPING",
    "DAMPING_KIND",
    "ELASTIC",
    "ELASTIC_KIND",
    "END",
    "FRICTION",
    "FRICTION_KIND",
    "GUARD",
    "LIMIT",
    "NO_LAW",
    "PARAMETERS",
    "Damping",
    "ElasticLaw",
    "FrictionLaw",
    "LawRow",
    "Part",
    "UserLaw",
]

# columns of kinds
ELASTIC_KIND, DAMPING_KIND, FRICTION_KIND, ADDRESS = range(4)

# where the parameters of each part begin in p
ELASTIC = 0  # six at most
DAMPING = 6  # four at most
FRICTION = 10  # seven at most
GUARD = 17  # least impact speed [m/s]
LIMIT = 18  # indentation up to which the elastic law is valid [m]
END = 19  # indentation at which it ends, to be extended by its tangent for trial states of a step [m]
PARAMETERS = 20


class UserLaw(Protocol):
    """A user's own function behind an address."""

    def begin(self) -> None:
        """Forget what went wrong."""

    def complaint(self) -> str:
        """What went wrong since then, empty if nothing did; raises what the function raised."""


@dataclass(frozen=True, slots=True)
class LawRow:
    """One law of a declared contact as kernels take it."""

    kinds: tuple[int, int, int, int]
    parameters: tuple[float, ...]  # PARAMETERS of them
    slip_speed: float  # below which a contact counts as sticking in records [m/s]
    remembers: bool  # whether its force depends on the impact speed, or on what has been before
    bristles: bool  # whether its friction has states of its own
    turns: bool  # whether it unloads along a curve of its own, which begins where a contact turns back
    lenient: bool  # whether an indentation beyond LIMIT is a warning instead of an error
    own: UserLaw | None = None  # a user's law: what stands at the ADDRESS, and says what went wrong there


# stands for the law of a rigid contact, which is never asked for a force
NO_LAW = LawRow(
    kinds=(0, 0, 0, 0),
    parameters=(0.0,) * LIMIT + (math.inf, math.inf),
    slip_speed=0.0,
    remembers=False,
    bristles=False,
    turns=False,
    lenient=False,
)


class LawPart(Protocol):
    """What all three parts of a contact law offer to kernels."""

    @property
    def kind(self) -> str:
        """Name among the ``KINDS`` of its part."""

    @property
    def parameters(self) -> tuple[float, ...]:
        """At most six of an elastic law, four of a damping, seven of friction."""


class ElasticLaw(LawPart, Protocol):
    """What an elastic law offers to kernels; its public face is in :mod:`lcpflex.force_laws.elastic.law`."""

    @property
    def limit(self) -> float:
        """Indentation up to which it is valid [m]."""

    @property
    def end(self) -> float:
        """Indentation beyond which it does not exist [m]; infinite for most."""

    @property
    def lenient(self) -> bool:
        """Whether leaving the range of validity is a warning instead of an error."""


@dataclass(frozen=True, slots=True)
class Part:
    """An elastic law or a damping that nobody asks for more than a row."""

    kind: str
    parameters: tuple[float, ...]
    limit: float = math.inf
    end: float = math.inf
    lenient: bool = False
    guard_speed: float = 0.0
    remembers: bool = False


class Damping(LawPart, Protocol):
    """What a dissipative law offers to kernels."""

    @property
    def guard_speed(self) -> float:
        """Least impact speed [m/s] that is divided by."""

    @property
    def remembers(self) -> bool:
        """Whether it needs the impact speed, the mass or the largest indentation of a contact."""

    def check(self, elastic: ElasticLaw) -> None:
        """Raise ModelError where it cannot go with that elastic law."""


class FrictionLaw(LawPart, Protocol):
    """What a friction law offers to kernels; mu is that of the declared contact."""

    @property
    def slip_speed(self) -> float:
        """Speed [m/s] below which a contact counts as sticking in records."""

    @property
    def bristles(self) -> bool:
        """Whether it has states of its own."""

    def check(self, mu: float, contact: str) -> None:
        """Raise ModelError where it cannot go with the coefficient mu of a declared contact."""
