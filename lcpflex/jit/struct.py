"""Structs that kernels and Python share: arrays, numbers and further structs, handed to kernels as one pointer.

Numba passes a named tuple of arrays by value: with the hundred arrays of a model, each call copies a thousand
words and each function takes a second to compile. A struct is a block of memory with numbers and array descriptors,
and kernels load just those that they use; ``work.n_contacts`` reads the same in a kernel and in Python, and a number is
written in either.

A struct is declared as a class of annotated fields with the shapes of its arrays:

    @struct
    class Work:
        n_contacts: int
        time: float
        q: FloatArray = array("ndof")
        rows: FloatArray = array("rows", 2, "width")
        table: ContactTable

    work = allocate(Work, {"ndof": 6, "rows": 10, "width": 3}, table=contact_table(8))

:func:`pack` makes one of a named tuple of arrays, for what is read only.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from typing import Any, TypeVar, cast, dataclass_transform

import numpy as np
import numpy.typing as npt

__all__ = [
    "allocate", "array", "copy_parts", "lengthen", "numbers_of", "pack", "parts_of", "put_array", "shapes_of",
    "spatial", "struct", "with_parts",
]  # fmt: skip

T = TypeVar("T")
NUMBERS = {"int": np.dtype(np.int64), "float": np.dtype(np.float64)}
DTYPES = {"IntArray": np.int64, "FloatArray": np.float64}


class Packed:
    """Fields and their block of memory. Numbers stand in the block; arrays and structs are attributes beside it."""

    _address: int
    _type: Any
    _numbers: tuple[tuple[str, np.dtype[Any]], ...] = ()

    def __init__(self, values: Any) -> None:
        self._pack(type(values).__name__, dict(zip(values._fields, values, strict=True)))

    def _pack(self, label: str, values: dict[str, Any]) -> None:
        from lcpflex.jit.struct_type import number_type, packed_type

        self._label = label
        names = [name for name, _ in self._numbers]
        fields: list[tuple[str, Any]] = [(name, number_type(kind)) for name, kind in self._numbers]
        words: list[int] = [0] * len(names)
        for name, value in values.items():
            if name not in names:
                kept = value if isinstance(value, np.ndarray) else pack(value)
                vars(self)[name] = kept
                fields.append((name, _type_of(kept)))
                words += [kept._address] if isinstance(kept, Packed) else _descriptor(kept)
        self._memory = np.array(words, dtype=np.int64)
        self._address = int(self._memory.ctypes.data)
        self._type = packed_type(label, tuple(fields))
        for name in names:
            setattr(self, name, values[name])

    # names of methods begin with an underscore, so that fields may have any other

    def _parts(self) -> dict[str, Any]:
        """All fields by name."""
        numbers = {name: getattr(self, name) for name, _ in self._numbers}
        return numbers | {name: value for name, value in vars(self).items() if not name.startswith("_")}

    def _with_parts(self, parts: dict[str, Any]) -> Packed:
        """Another one like this, some of its fields replaced."""
        other = object.__new__(type(self))
        other._pack(self._label, self._parts() | parts)
        return other

    def _put(self, name: str, value: np.ndarray[Any, Any]) -> None:
        """Another array of the same type in the place of one; kernels that are called from now on take it."""
        at = len(self._numbers)
        for field, kept in vars(self).items():
            if field == name:
                if _type_of(kept) is not _type_of(value):
                    raise TypeError(f"{name} is {_type_of(kept)}, not {_type_of(value)}")
                words = _descriptor(value)
                vars(self)[name] = value
                self._memory[at : at + len(words)] = words
                return
            if not field.startswith("_"):
                at += len(_descriptor(kept)) if isinstance(kept, np.ndarray) else 1
        raise AttributeError(name)

    def __reduce__(self) -> tuple[Any, ...]:
        """Its block holds addresses: a copy, or what is unpickled, gets one of its own."""
        own = self._parts()
        frozen = [name for name, value in own.items() if isinstance(value, np.ndarray) and not value.flags.writeable]
        return _packed_again, (type(self), self._label, own, frozen)


def _packed_again(kind: type[Packed], label: str, values: dict[str, Any], frozen: list[str]) -> Packed:
    """As it was: whether an array can be written to is part of the type that kernels are compiled for."""
    for name in frozen:
        values[name].setflags(write=False)
    again = object.__new__(kind)
    again._pack(label, values)
    return again


def array(*shape: int | str) -> Any:
    """Shape of a declared array: numbers, and names of dimensions that :func:`allocate` is told."""
    return shape


@dataclass_transform(kw_only_default=True, field_specifiers=(array,))
def struct(declared: type[T]) -> type[T]:
    """The class of structs with the annotated fields of ``declared``; numbers are 0 where they are not given.

    Raises
    ------
    TypeError
        When one is made, for a field that is missing or not declared.
    """
    annotations = dict(declared.__annotations__)
    shapes = {name: vars(declared).get(name) for name in annotations}
    numbers = tuple((name, NUMBERS[kind]) for name, kind in annotations.items() if kind in NUMBERS)

    def begin(self: Packed, **values: Any) -> None:
        given = {name: 0 for name, _ in numbers} | values
        if set(given) != set(annotations):
            raise TypeError(f"{declared.__name__} takes {sorted(annotations)}, not {sorted(given)}")
        self._pack(type(self).__name__, {name: given[name] for name in annotations})

    scope = {
        "__doc__": declared.__doc__,
        "__module__": declared.__module__,
        "__qualname__": declared.__qualname__,
        "__init__": begin,
        "__annotations__": annotations,
        "_numbers": numbers,
        "_shapes": shapes,
        **{name: _number(place, kind) for place, (name, kind) in enumerate(numbers)},
    }
    return cast(type[T], type(declared.__name__, (Packed,), scope))


def spatial(kind: type[T]) -> type[T]:
    """Structs with the fields of ``kind`` that calls of :mod:`lcpflex.jit.leaf` take for those of space.

    To be kept in the module of ``kind`` as Spatial and its name.
    """
    name = f"Spatial{kind.__name__}"
    scope = {
        "__module__": kind.__module__,
        "__qualname__": name,
        "__doc__": f"A :class:`{kind.__name__}` of space.",
        "__annotations__": dict(kind.__annotations__),
    }
    return cast(type[T], type(name, (kind,), scope))


def _number(place: int, kind: np.dtype[Any]) -> property:
    """A number in the block of memory, for Python."""

    def read(self: Any) -> Any:
        return self._memory.view(kind)[place].item()

    def write(self: Any, value: Any) -> None:
        self._memory.view(kind)[place] = value

    return property(read, write)


def allocate(kind: type[T], dimensions: Mapping[str, int], **given: Any) -> T:
    """A struct with the ``given`` fields; the other arrays are zeros of their declared shapes, other numbers zero."""
    declared: Any = kind
    made = dict(given)
    for name, shape in shapes_of(kind).items():
        if name not in made:
            sizes = tuple(dimensions[size] if isinstance(size, str) else size for size in shape)
            made[name] = np.zeros(sizes, DTYPES[declared.__annotations__[name]])
    make = cast(Callable[..., T], kind)
    return make(**made)


def shapes_of(kind: type) -> dict[str, tuple[int | str, ...]]:
    """The declared shapes of the arrays of a struct, by name."""
    declared: Any = kind
    return {name: shape for name, shape in declared._shapes.items() if shape is not None}


def parts_of(values: Any) -> dict[str, Any]:
    """The fields of a struct by name."""
    return cast(Packed, values)._parts()


def with_parts(values: T, parts: Mapping[str, Any]) -> T:
    """Another struct like this one, some of its fields replaced."""
    return cast(T, cast(Packed, values)._with_parts(dict(parts)))


def put_array(values: Any, name: str, array: npt.NDArray[Any]) -> None:
    """Another array of the same type, of any size, in the place of one of a struct. Not while a kernel runs on it."""
    cast(Packed, values)._put(name, array)


def lengthen(values: Any, dimension: str, old: int, new: int) -> None:
    """Room for ``new`` items along a declared dimension of a struct, and of those in it, where it has had ``old``.

    What is there stays, the rest is zero.
    """
    packed = cast(Packed, values)
    shapes = {name: shape for name, shape in getattr(packed, "_shapes", {}).items() if shape is not None}
    for name, value in parts_of(values).items():
        if isinstance(value, Packed):
            lengthen(value, dimension, old, new)
        elif isinstance(value, np.ndarray) and dimension in shapes.get(name, ()):
            sizes = [
                new if of == dimension and size == old else size
                for of, size in zip(shapes[name], value.shape, strict=True)
            ]
            if tuple(sizes) != value.shape:
                longer = np.zeros(sizes, value.dtype)
                longer[tuple(slice(size) for size in value.shape)] = value
                packed._put(name, longer)


def numbers_of(values: Any) -> npt.NDArray[np.int64]:
    """The words of the numbers of a struct itself: to keep, and to write back."""
    packed = cast(Packed, values)
    return packed._memory[: len(packed._numbers)]


def copy_parts(source: Any, target: Any) -> None:
    """Content of one struct into another, whose arrays are at least as large; what is beyond stays.

    In kernels, of two structs of one type with arrays of the same shapes.
    """
    for name, value in parts_of(source).items():
        if isinstance(value, np.ndarray):
            getattr(target, name)[tuple(slice(size) for size in value.shape)] = value
        elif isinstance(value, Packed):
            copy_parts(value, getattr(target, name))
        else:
            setattr(target, name, value)


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
