"""Complementarity problems with known answers, by family, from fixed seeds.

``examples()`` yields all families at several sizes; the same seed gives the same problems to the bit. Sources are named
where the families are made: :mod:`lcpflex.solvers.benchmark.matrix_families`,
:mod:`lcpflex.solvers.benchmark.contact_families`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from zlib import crc32

import numpy as np

from lcpflex.errors import ModelError, shown
from lcpflex.solvers.benchmark import contact_families as contact, matrix_families as matrices
from lcpflex.solvers.benchmark.example import Example

__all__ = ["FAMILIES", "SIZES", "Example", "examples", "family"]

Family = Callable[[np.random.Generator, int], Iterator[Example]]

FAMILIES: dict[str, Family] = {
    function.__name__.replace("_", " "): function
    for function in (
        *(getattr(matrices, name) for name in matrices.__all__),
        *(getattr(contact, name) for name in contact.__all__),
    )
}

SIZES = (1, 3, 8, 20)


def family(name: str, seed: int = 0, sizes: tuple[int, ...] = SIZES) -> Iterator[Example]:
    """The examples of one family, with about ``sizes`` unknowns or contacts.

    Some families stop growing where their problems would lose all digits. Raises ModelError for an unknown name or a
    size below one.
    """
    if name not in FAMILIES:
        raise ModelError(f"family is {shown(name)}: expected one of {', '.join(FAMILIES)}")
    for n in sizes:
        if n < 1:
            raise ModelError(f"sizes holds {n}: expected numbers of unknowns >= 1")
        # Each family and size draws from a stream of its own: adding one leaves the others as they are.
        yield from FAMILIES[name](np.random.default_rng([seed, crc32(name.encode()), n]), n)


def examples(seed: int = 0, sizes: tuple[int, ...] = SIZES) -> Iterator[Example]:
    """All examples of all families for one seed."""
    for name in FAMILIES:
        yield from family(name, seed, sizes)
