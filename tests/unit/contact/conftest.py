"""Scenes of bare surfaces on bodies with made-up modes, and a plain view of what detection finds."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import pytest

from lcpflex.bodies.body import MaterialPoint
from lcpflex.bodies.surface import Surface
from lcpflex.compile.contact_surfaces import compile_surfaces
from lcpflex.contact.detection import ContactTable, contact_table, detect
from lcpflex.jit.kernel import FloatArray
from lcpflex.jit.struct import pack
from lcpflex.model.arrays import Model, PointTable, bodiless_model, frozen

Declared = tuple[int, int, float, float, float]


class Found(NamedTuple):
    """One near contact."""

    key: int
    law: int
    kind: int
    gap: float
    normal: tuple[float, float]
    s: float
    bodies: tuple[int, int]


def place(x: float, y: float, phi: FloatArray | None = None, psi: FloatArray | None = None) -> MaterialPoint:
    """A material point; rigid unless it has mode shapes."""
    return MaterialPoint(
        np.array([x, y]), np.zeros((0, 2)) if phi is None else phi, np.zeros(0) if psi is None else psi
    )


def assemble(modes: Sequence[int], surfaces: Sequence[tuple[int, Surface]], declared: Sequence[Declared] = ()) -> Model:
    """A model that consists of surfaces alone; ``modes``: how many each body has."""
    points = PointTable()
    contacts = compile_surfaces(surfaces, declared, points)
    empty = bodiless_model(0, 0, [], [], [])
    dof = np.cumsum([0, *[3 + n for n in modes]])
    return pack(
        empty._replace(
            bodies=empty.bodies._replace(dof=frozen(dof, np.int64)), points=points.compile(), contacts=contacts
        )
    )


def pair(a: Surface, b: Surface, body_a: int = 0, body_b: int = -1, modes: Sequence[int] = (0,)) -> Model:
    """Surface a, which may touch surface b."""
    return assemble(modes, [(body_a, a), (body_b, b)], [(0, 1, 0.0, 0.0, 0.0)])


def table_of(model: Model, capacity: int = 64) -> ContactTable:
    return contact_table(capacity, len(model.contacts.surface_body))


def find(model: Model, q: Sequence[float] | FloatArray, margin: float = 1e-3) -> list[Found]:
    """What ``detect`` finds."""
    table = table_of(model, 256)
    n = detect(model, np.array(q, dtype=float), margin, table)
    assert n <= 256
    return [
        Found(
            int(table.key[k]),
            int(table.law[k]),
            int(table.kind[k]),
            float(table.gap[k]),
            (float(table.normal[k, 0]), float(table.normal[k, 1])),
            float(table.s[k]),
            (int(table.body[k, 0]), int(table.body[k, 1])),
        )
        for k in range(n)
    ]


class Tools(NamedTuple):
    """The functions of this file."""

    place: Callable[..., MaterialPoint]
    assemble: Callable[..., Model]
    pair: Callable[..., Model]
    table_of: Callable[..., ContactTable]
    find: Callable[..., list[Found]]


@pytest.fixture(scope="session")
def tools() -> Tools:
    return Tools(place, assemble, pair, table_of, find)
