"""Elastic laws of contacts under the massless-boundary scheme: what is admitted, expected, and told of them."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from lcpflex.dynamics.contact_compliance import ContactCompliance
from lcpflex.dynamics.mass_matrix import mass_matrix
from lcpflex.errors import ModelError, shown
from lcpflex.force_laws.contact_law import law_row
from lcpflex.force_laws.elastic.kernels import elastic_force, elastic_stiffness, indentation_of
from lcpflex.force_laws.friction.laws import SmoothedCoulomb
from lcpflex.force_laws.layout import ElasticLaw, LawRow
from lcpflex.jit.kernel import FloatArray
from lcpflex.steppers.system import System

__all__ = ["checked_compliance", "compliance_rows", "expected_compliance"]

FALL = 10.0  # times the distance up to which gaps are measured: a height of fall that is hardly exceeded
DENT = 1e-6  # times the same, an indentation where nothing tells what to expect
NEGLIGIBLE = 1e-6  # part of the force of such an indentation


def checked_compliance(compliance: Mapping[str, ElasticLaw]) -> dict[str, ElasticLaw]:
    """The laws as a dict; ModelError for what is no elastic law."""
    if not isinstance(compliance, Mapping):
        raise ModelError(
            f"compliance: {shown(compliance)} was given, expected a dict of elastic laws by names of contacts"
        )
    for name, law in compliance.items():
        needed = ("kind", "parameters", "limit", "end", "lenient")
        if isinstance(law, type) or not all(hasattr(law, attribute) for attribute in needed) or law.kind == "own":
            raise ModelError(
                f"compliance[{name!r}]: {shown(law)} was given, "
                f"expected an elastic law such as PowerLaw(1e6): at position "
                "level a contact has the force of its indentation and nothing else; damping, and functions of one's "
                "own, take Smooth(law)"
            )
    return dict(compliance)


def compliance_rows(compliance: Mapping[str, ElasticLaw], names: tuple[str, ...], n_laws: int) -> list[LawRow | None]:
    """The law of each declared contact, None where it has none; ModelError for a name that no contact has."""
    for name in compliance:
        if name not in names:
            known = ", ".join(names) or "none"
            raise ModelError(f"compliance: {shown(name)} was given, expected names of declared contacts: {known}")
    laws = [compliance.get(name) for name in names] or [None] * n_laws
    return [None if law is None else law_row(law, None, SmoothedCoulomb()) for law in laws]


def expected_compliance(system: System, compliance: ContactCompliance) -> FloatArray:
    """(passes,) 1 / stiffness [m/N] at the largest indentation that an impact may cause, 0 where there is no law.

    That which stores the kinetic energy of the two bodies, after a fall over what is a long way in the scene. A guess:
    the frequency of a contact goes with the tenth root of it, and steps are divided where it was exceeded. The force
    there tells which ones do not matter.
    """
    model = system.model
    contacts = model.contacts
    mass = mass_matrix(model, system.q)
    fall = math.sqrt(2.0 * math.hypot(*model.loads.gravity) * FALL * system.margin)
    give = np.zeros(len(contacts.pass_law))
    for w, law in enumerate(contacts.pass_law):
        if compliance.soft[law] == 0:
            continue
        energy = 0.0
        for surface in (contacts.pass_node[w], contacts.pass_feature[w]):
            b = int(contacts.surface_body[surface])
            if b >= 0:
                own = slice(model.bodies.dof[b], model.bodies.dof[b + 1])
                speed = math.sqrt(system.u[own] @ mass[own, own] @ system.u[own] / model.bodies.mass[b])
                energy += 0.5 * model.bodies.mass[b] * (speed + fall) ** 2
        kinds, p = compliance.history.kinds[law], compliance.history.parameters[law]
        depth = indentation_of(kinds, p, energy) if energy > 0.0 else DENT * system.margin
        compliance.least[law] = max(compliance.least[law], NEGLIGIBLE * elastic_force(kinds, p, depth))
        if energy > 0.0:
            give[w] = 1.0 / elastic_stiffness(kinds, p, depth)
    return give
