"""Factors by PARDISO of Intel's MKL, through the package pypardiso where it is installed.

It orders by METIS, works on dense blocks of columns, eight times as fast as SuperLU on meshes of 2e5 degrees of
freedom, and keeps one triangle in a quarter of the memory. On one thread, for which results are the same to the bit
from run to run, and no second library of threads is loaded beside those of numpy and numba.

Source: Schenk and Gaertner, Solving unsymmetric sparse systems of linear equations with PARDISO, 2004; the parameters
(``iparm``) are those of Intel's reference.
"""

from __future__ import annotations

import warnings
import weakref
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.basics import libs
from lcpflex.basics.stack import outside
from lcpflex.bodies.fem.factors import AT_ONCE, NotPositive
from lcpflex.errors import ModelError, ModelWarning
from lcpflex.jit.kernel import FloatArray

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix

__all__ = ["PardisoFactor", "is_there", "pardiso_factor"]

POSITIVE_DEFINITE = 2  # type of matrix: real, symmetric positive definite, of which the upper triangle is given
LP64, SEQUENTIAL = 0, 1  # layers of MKL: numbers of 32 bits, one thread
PARAMETERS = {
    1: 1,  # take the following
    2: 2,  # order by METIS
    8: 0,  # no steps of iterative refinement: pivots are never changed, and the two by default treble the time
}
MEMORY = (16, 17)  # parameters that tell it: kilobytes of the analysis and of the factor
NOT_POSITIVE, NO_MEMORY = -4, -2  # errors


class PardisoFactor:
    """That of PARDISO; its memory, which is not Python's, is freed with it."""

    def __init__(self, solver: Any, upper: Any) -> None:
        self._solver = solver
        self._upper = upper
        weakref.finalize(self, solver.free_memory, everything=True)

    @property
    def in_blocks(self) -> bool:
        """One column takes a quarter of the time of 16: most of it is reading the factor."""
        return True

    @property
    def memory(self) -> float:
        """Bytes that it takes, about."""
        return 1024.0 * sum(float(self._solver.get_iparm(number)) for number in MEMORY)

    def solve(self, right: FloatArray) -> FloatArray:
        """x of b (n,) or (n, k)."""
        if right.ndim == 1:
            return np.asarray(self._solver.solve(self._upper, right))
        out = np.empty(right.shape)
        for first in range(0, right.shape[1], AT_ONCE):
            part = slice(first, first + AT_ONCE)
            out[:, part] = self._solver.solve(self._upper, np.asfortranarray(right[:, part]))
        return out


def pardiso_factor(matrix: csc_matrix[Any]) -> PardisoFactor | None:
    """Factors of a symmetric matrix; None where PARDISO does not work, which is told.

    Raises
    ------
    NotPositive
        If a pivot is not positive.
    ModelError
        If there is not enough memory.
    """
    upper = libs.sparse.triu(matrix, format="csr")
    solver = libs.pypardiso.PyPardisoSolver(mtype=POSITIVE_DEFINITE)
    for number, value in PARAMETERS.items():
        solver.set_iparm(number, value)
    try:
        solver.factorize(upper)
    except ValueError as error:  # a row without entries
        solver.free_memory(everything=True)
        raise NotPositive(str(error)) from None
    except libs.pypardiso.pardiso_wrapper.PyPardisoError as error:
        solver.free_memory(everything=True)
        if error.value == NOT_POSITIVE:
            raise NotPositive("a pivot is not positive") from None
        if error.value == NO_MEMORY:
            raise ModelError(
                f"stiffness: the memory does not suffice to factorise a mesh of {matrix.shape[0]} degrees of freedom, "
                "expected a smaller one"
            ) from None
        _tell(f"fails with error {error.value}")
        return None
    return PardisoFactor(solver, upper)


@cache
def is_there() -> bool:
    """Whether pypardiso is installed; one that cannot be loaded is told once."""
    try:
        mkl = libs.pypardiso.PyPardisoSolver().libmkl
    except ModuleNotFoundError:
        return False
    except (ImportError, OSError) as error:  # without its library, or with one for other processors
        _tell(f"cannot be loaded ({str(error)[:150]})")
        return False
    mkl.MKL_Set_Interface_Layer(LP64)
    mkl.MKL_Set_Threading_Layer(SEQUENTIAL)  # the first call decides: MKL in use elsewhere keeps its threads
    return True


def _tell(what: str) -> None:
    warnings.warn(
        f"pypardiso is installed but {what}: large meshes are factorised by SuperLU, with more time and memory",
        ModelWarning,
        stacklevel=outside(),
    )
