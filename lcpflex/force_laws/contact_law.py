"""A contact law: an elastic law, what it dissipates, and friction."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

from lcpflex.errors import ModelError, shown
from lcpflex.force_laws import compiled
from lcpflex.force_laws.friction.laws import SmoothedCoulomb
from lcpflex.force_laws.layout import (
    DAMPING,
    ELASTIC,
    END,
    FRICTION,
    GUARD,
    LIMIT,
    PARAMETERS,
    Damping,
    ElasticLaw,
    FrictionLaw,
    LawRow,
    Part,
)

__all__ = ["ContactLaw", "law_row"]


@dataclass(frozen=True, slots=True)
class ContactLaw:
    """Continuous contact force: lambda_N = max(0, F(delta) + damping), lambda_T by a friction law.

    The force never pulls: where damping would make it negative it is zero.

    Attributes
    ----------
    elastic
        Force of the indentation, such as ``Hertz.spheres(...)`` or ``PowerLaw(K, n)``.
    damping
        What is lost, such as ``HysteresisDamping(restitution=0.7)``; None: nothing.
    friction
        How the tangential force follows from the slip velocity; the mu is that of the declared contact.

    Raises
    ------
    ModelError
        For parts that are none of these, and for damping that does not go with the elastic law.
    """

    elastic: ElasticLaw
    damping: Damping | None = None
    friction: FrictionLaw = field(default_factory=SmoothedCoulomb)

    def __post_init__(self) -> None:
        _check_part("elastic", self.elastic, ("kind", "parameters", "limit", "end", "lenient"), "PowerLaw(1e6)")
        needed = ("kind", "parameters", "slip_speed", "bristles", "check")
        _check_part("friction", self.friction, needed, "SmoothedCoulomb()")
        if self.damping is not None:
            expected = "HysteresisDamping(restitution=0.7)"
            _check_part("damping", self.damping, ("kind", "parameters", "guard_speed", "check"), expected)
            self.damping.check(self.elastic)

    def row(self) -> LawRow:
        """The law as kernels take it."""
        return law_row(self.elastic, self.damping, self.friction)


def law_row(elastic: ElasticLaw | Part, damping: Damping | Part | None, friction: FrictionLaw) -> LawRow:
    """The three parts of a law as kernels take them."""
    p = [0.0] * PARAMETERS
    p[ELASTIC : ELASTIC + len(elastic.parameters)] = elastic.parameters
    p[FRICTION : FRICTION + len(friction.parameters)] = friction.parameters
    p[LIMIT], p[END] = elastic.limit, elastic.end
    p[GUARD] = math.inf
    if damping is not None:
        p[DAMPING : DAMPING + len(damping.parameters)] = damping.parameters
        p[GUARD] = damping.guard_speed
    return LawRow(
        kinds=(
            compiled.ELASTIC_KINDS.index(elastic.kind),
            compiled.DAMPING_KINDS.index("none" if damping is None else damping.kind),
            compiled.FRICTION_KINDS.index(friction.kind),
            getattr(elastic, "address", 0),
        ),
        parameters=tuple(map(float, p)),
        slip_speed=friction.slip_speed,
        remembers=elastic.kind == "own" or friction.bristles or (damping is not None and damping.remembers),
        bristles=friction.bristles,
        turns=damping is not None and damping.kind == "permanent",
        lenient=elastic.lenient,
        own=getattr(elastic, "own", None),
    )


def _check_part(name: str, part: Any, needed: tuple[str, ...], example: str) -> None:
    if isinstance(part, type) or not all(hasattr(part, attribute) for attribute in needed):
        kind = {"elastic": "an elastic law", "damping": "a damping", "friction": "a friction law"}[name]
        raise ModelError(f"{name}: {shown(part)} was given, expected {kind} such as {example}")
