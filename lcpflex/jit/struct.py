"""Named tuples of arrays handed to kernels as one pointer.

Numba passes a named tuple of arrays by value: with the hundred arrays of a model, each call copies a thousand
words and each function takes a second to compile. A packed tuple is a block of memory with the array descriptors,
and kernels load just those that they use; ``model.bodies.mass[b]`` reads the same in a kernel and in Python.
"""

from __future__ import annotations

from functools import cache
from typing import Any, TypeVar, cast

import numpy as np

__all__ = ["pack"]

T = TypeVar("T")


class Packed:
    """A named tuple with its block of memory. Attributes are those of the tuple, nested tuples packed likewise."""

    _address: int
    _type: Any

    def __init__(self, values: Any) -> None:
        self._pack(type(values).__name__, dict(zip(values._fields, values, strict=True)))

    def _pack(self, label: str, values: dict[str, Any]) -> None:
        from lcpflex.jit.struct_type import PackedType

        self._label = label
        fields: list[tuple[str, Any]] = []
        words: list[int] = []
        for name, value in values.items():
            kept = value if isinstance(value, np.ndarray) else pack(value)
            setattr(self, name, kept)
            fields.append((name, _type_of(kept)))
            words += [kept._address] if isinstance(kept, Packed) else _descriptor(kept)
        self._memory = np.array(words, dtype=np.int64)
        self._address = int(self._memory.ctypes.data)
        self._type = PackedType(label, tuple(fields))

    @property
    def label(self) -> str:
        """Name of the named tuple."""
        return self._label

    def with_parts(self, parts: dict[str, Any]) -> Packed:
        """Another one like this, some of its arrays and packed tuples replaced."""
        own = {name: value for name, value in vars(self).items() if not name.startswith("_")}
        other = object.__new__(Packed)
        other._pack(self._label, own | parts)
        return other

    def __reduce__(self) -> tuple[Any, ...]:
        """Its block holds addresses: a copy, or what is unpickled, gets one of its own."""
        own = {name: value for name, value in vars(self).items() if not name.startswith("_")}
        frozen = [name for name, value in own.items() if isinstance(value, np.ndarray) and not value.flags.writeable]
        return _packed_again, (self._label, own, frozen)


def _packed_again(label: str, values: dict[str, Any], frozen: list[str]) -> Packed:
    """As it was: whether an array can be written to is part of the type that kernels are compiled for."""
    for name in frozen:
        values[name].setflags(write=False)
    again = object.__new__(Packed)
    again._pack(label, values)
    return again


def _descriptor(array: np.ndarray[Any, Any]) -> list[int]:
    """The words of numba's array structure: no owner, no parent, items, item size, data, shape, strides."""
    return [0, 0, array.size, array.itemsize, array.ctypes.data, *array.shape, *array.strides]


def _type_of(value: Any) -> Any:
    if isinstance(value, Packed):
        return value._type
    flags = value.flags
    return _array_type(value.dtype, value.ndim, flags.c_contiguous, flags.f_contiguous, flags.writeable, flags.aligned)


@cache
def _array_type(dtype: Any, ndim: int, c: bool, f: bool, writeable: bool, aligned: bool) -> Any:
    """What ``numba.typeof`` says of such an array, which takes it thirty times as long."""
    from numba import types
    from numba.np.numpy_support import from_dtype

    layout = "C" if c else "F" if f else "A"
    return types.Array(from_dtype(dtype), ndim, layout, readonly=not writeable, aligned=aligned)


def pack(values: T) -> T:
    """``values``, a named tuple of arrays and such tuples, ready to be passed to kernels; to its users the same thing.

    The arrays are shared, not copied.
    """
    return values if isinstance(values, Packed) else cast(T, Packed(values))
