"""Complementarity problems with known answers, by family, from fixed seeds.

``examples()`` yields all families that are LCPs at several sizes, ``spatial_examples()`` those of contact in space; the
same seed gives the same problems to the bit. Sources are named where the families are made:
:mod:`lcpflex.solvers.benchmark.matrix_families`, :mod:`lcpflex.solvers.benchmark.contact_families`,
:mod:`lcpflex.solvers.benchmark.spatial_families`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from types import ModuleType
from zlib import crc32

import numpy as np

from lcpflex.errors import ModelError, shown
from lcpflex.solvers.benchmark import (
    contact_families as contact,
    matrix_families as matrices,
    spatial_families as space,
)
from lcpflex.solvers.benchmark.example import Example

__all__ = ["FAMILIES", "SIZES", "SPATIAL_FAMILIES", "Example", "examples", "family", "spatial_examples"]

Family = Callable[[np.random.Generator, int], Iterator[Example]]


def _named(*modules: ModuleType) -> dict[str, Family]:
    """The families of modules by name."""
    return {name.replace("_", " "): getattr(module, name) for module in modules for name in module.__all__}


FAMILIES: dict[str, Family] = _named(matrices, contact)
SPATIAL_FAMILIES: dict[str, Family] = _named(space)

SIZES = (1, 3, 8, 20)


def family(name: str, seed: int = 0, sizes: tuple[int, ...] = SIZES) -> Iterator[Example]:
    """The examples of one family, with about ``sizes`` unknowns or contacts.

    Some families stop growing where their problems would lose all digits. Raises ModelError for an unknown name or a
    size below one.
    """
    known = FAMILIES | SPATIAL_FAMILIES
    if name not in known:
        raise ModelError(f"family is {shown(name)}: expected one of {', '.join(known)}")
    for n in sizes:
        if n < 1:
            raise ModelError(f"sizes holds {n}: expected numbers of unknowns >= 1")
        # Each family and size draws from a stream of its own: adding one leaves the others as they are.
        yield from known[name](np.random.default_rng([seed, crc32(name.encode()), n]), n)


def examples(seed: int = 0, sizes: tuple[int, ...] = SIZES) -> Iterator[Example]:
    """All examples of all families for one seed."""
    for name in FAMILIES:
        yield from family(name, seed, sizes)


def spatial_examples(seed: int = 0, sizes: tuple[int, ...] = SIZES) -> Iterator[Example]:
    """All examples of all families of contact in space for one seed."""
    for name in SPATIAL_FAMILIES:
        yield from family(name, seed, sizes)
