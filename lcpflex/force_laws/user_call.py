"""The call of a user's law from kernels, which are compiled once and for all laws.

``address`` is that of two words: the address of a function double(double, double, double, double*), and that of the
numbers which are its last argument. Nothing of it is known when a kernel is compiled.
"""

from __future__ import annotations

from typing import Any

import llvmlite.ir
from numba.core import types
from numba.extending import intrinsic

from lcpflex.jit.kernel import FloatArray, kernel

__all__ = ["own_force", "own_forces"]

ir: Any = llvmlite.ir  # without types

WORD = ir.IntType(64)
DOUBLE = ir.DoubleType()
FUNCTION = ir.FunctionType(DOUBLE, [DOUBLE, DOUBLE, DOUBLE, DOUBLE.as_pointer()])


@intrinsic  # type: ignore[untyped-decorator]
def call_at(typing: Any, address: Any, depth: Any, rate: Any, speed: Any) -> Any:
    """Call of the function whose address stands at ``address``."""

    def code(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        words = builder.inttoptr(values[0], WORD.as_pointer())
        function = builder.inttoptr(builder.load(words), FUNCTION.as_pointer())
        numbers = builder.load(builder.gep(words, [ir.Constant(WORD, 1)]))
        return builder.call(function, [*values[1:], builder.inttoptr(numbers, DOUBLE.as_pointer())])

    return types.float64(types.int64, types.float64, types.float64, types.float64), code


@kernel
def own_force(address: int, depth: float, rate: float, speed: float) -> float:
    """What the function of a user's law returns, for an indentation [m] growing with ``rate`` [m/s]."""
    return call_at(address, depth, rate, speed)


@kernel
def own_forces(address: int, depth: FloatArray, rate: FloatArray, speed: FloatArray, out: FloatArray) -> None:
    """out = the force of each element, 0 where the function is negative and where nothing touches."""
    for i in range(len(out)):
        force = own_force(address, depth[i], rate[i], speed[i]) if depth[i] > 0.0 else 0.0
        out[i] = 0.0 if force < 0.0 else force
