"""What numba must know of :class:`lcpflex.jit.struct.Packed`: its type, how it comes in, how attributes are loaded."""

from __future__ import annotations

from hashlib import sha256
from typing import Any

from numba.core import cgutils, types
from numba.core.imputils import lower_getattr_generic, lower_setattr_generic
from numba.core.typing.templates import AttributeTemplate, infer_getattr
from numba.extending import NativeValue, lower_builtin, models, register_model, type_callable, typeof_impl, unbox

from lcpflex.jit.struct import Packed, copy_parts

__all__ = ["PackedType", "number_type", "packed_type"]

_made: dict[Any, PackedType] = {}
WORD = 8  # bytes; every field is a number of whole words


class PackedType(types.Type):
    """A pointer to numbers, array descriptors and further structs; ``fields``: (name, type) in the order of memory."""

    def __init__(self, label: str, fields: tuple[tuple[str, Any], ...]) -> None:
        self.label = label
        self.fields = fields
        told = ", ".join(f"{name}: {kind.name}" for name, kind in fields)
        super().__init__(name=label + sha256(told.encode()).hexdigest()[:16])  # told in full, symbols are kilobytes

    def place(self, name: str) -> tuple[int, Any]:
        """Offset [bytes] and type of a field."""
        offset = 0
        for field, kind in self.fields:
            if field == name:
                return offset, kind
            offset += WORD * (5 + 2 * kind.ndim if isinstance(kind, types.Array) else 1)
        raise AttributeError(name)


def packed_type(label: str, fields: tuple[tuple[str, Any], ...]) -> PackedType:
    """The one type of structs with these fields: a tenth of a millisecond is needed to make it, and as much to hash."""
    key = label, *((name, id(kind)) for name, kind in fields)  # the type that is kept keeps the kinds
    if key not in _made:
        _made[key] = PackedType(label, fields)
    return _made[key]


def number_type(kind: Any) -> Any:
    """Numba's type of a number in the block: an integer or a float of one word."""
    return types.int64 if kind == "int64" else types.float64


@register_model(PackedType)
class PackedModel(models.OpaqueModel):  # type: ignore[misc]
    """An opaque pointer."""


@typeof_impl.register(Packed)  # type: ignore[untyped-decorator]
def typeof_packed(value: Packed, context: Any) -> PackedType:
    """The type is made with the value."""
    kind: PackedType = value._type
    return kind


@unbox(PackedType)  # type: ignore[untyped-decorator]
def unbox_packed(kind: PackedType, obj: Any, c: Any) -> NativeValue:
    """The address of the block, from the Python object that keeps it alive."""
    number = c.pyapi.object_getattr_string(obj, "_address")
    pointer = c.pyapi.long_as_voidptr(number)
    c.pyapi.decref(number)
    return NativeValue(pointer)


@infer_getattr
class PackedAttributes(AttributeTemplate):  # type: ignore[misc]
    """Type inference of ``packed.name``."""

    key = PackedType

    def generic_resolve(self, kind: PackedType, name: str) -> Any:
        for field, found in kind.fields:
            if field == name:
                return found
        return None


@lower_getattr_generic(PackedType)  # type: ignore[untyped-decorator]
def load_field(context: Any, builder: Any, kind: PackedType, value: Any, name: str) -> Any:
    """Code for ``packed.name``: a number, one array descriptor, or the pointer to a struct.

    Descriptors and pointers are never written after the block was made. Saying so of each of their words
    (``invariant.load``) spares loops to load them again after every store to an array.
    """
    offset, found = kind.place(name)
    block = context.get_value_type(found)
    at = builder.bitcast(cgutils.pointer_add(builder, value, offset), block.as_pointer())
    if isinstance(found, types.Number):
        return builder.load(at)
    never_written = builder.module.add_metadata([])

    def words(at: Any, block: Any) -> Any:
        if hasattr(block, "elements"):
            whole = cgutils.get_null_value(block)
            for i in range(len(block)):
                part = cgutils.gep_inbounds(builder, at, 0, i)
                whole = builder.insert_value(whole, words(part, part.type.pointee), i)
            return whole
        loaded = builder.load(at)
        loaded.set_metadata("invariant.load", never_written)
        return loaded

    return words(at, block)


@lower_setattr_generic(PackedType)  # type: ignore[untyped-decorator]
def store_number(context: Any, builder: Any, sig: Any, args: Any, name: str) -> None:
    """Code for ``packed.name = number``."""
    kind, _ = sig.args
    offset, found = kind.place(name)
    if not isinstance(found, types.Number):
        raise TypeError(f"{name} is not a number: only numbers of a struct can be set in kernels")
    block = context.get_value_type(found)
    builder.store(args[1], builder.bitcast(cgutils.pointer_add(builder, args[0], offset), block.as_pointer()))


@type_callable(copy_parts)  # type: ignore[untyped-decorator]
def type_copy(context: Any) -> Any:
    """``copy_parts(source, target)`` of two structs of one type."""
    return lambda source, target: types.none if isinstance(source, PackedType) and source == target else None


@lower_builtin(copy_parts, PackedType, PackedType)  # type: ignore[untyped-decorator]
def copy_block(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    """Code for ``copy_parts``: numbers and the content of arrays, which have the same shapes, and that of structs."""
    _copy_fields(context, builder, sig.args[0], *args)
    return context.get_dummy_value()


def _copy_fields(context: Any, builder: Any, kind: PackedType, source: Any, target: Any) -> None:
    for name, found in kind.fields:
        value = load_field(context, builder, kind, source, name)
        if isinstance(found, types.Number):
            store_number(context, builder, types.none(kind, found), (target, value), name)
        elif isinstance(found, PackedType):
            _copy_fields(context, builder, found, value, load_field(context, builder, kind, target, name))
        else:
            array = context.make_array(found)
            given, taken = array(context, builder, value), load_field(context, builder, kind, target, name)
            size = builder.mul(given.nitems, given.itemsize)
            cgutils.raw_memcpy(builder, array(context, builder, taken).data, given.data, size, 1)
