"""What numba must know of :class:`lcpflex.jit.struct.Packed`: its type, how it comes in, how attributes are loaded."""

from __future__ import annotations

from typing import Any

from numba.core import cgutils, types
from numba.core.imputils import lower_getattr_generic
from numba.core.typing.templates import AttributeTemplate, infer_getattr
from numba.extending import NativeValue, models, register_model, typeof_impl, unbox

from lcpflex.jit.struct import Packed

__all__ = ["PackedType"]

WORD = 8  # bytes; every field is a number of whole words


class PackedType(types.Type):
    """A pointer to array descriptors and further packed tuples; ``fields``: (name, type) in the order of memory."""

    def __init__(self, label: str, fields: tuple[tuple[str, Any], ...]) -> None:
        self.fields = fields
        super().__init__(name=f"{label}({', '.join(f'{name}: {kind.name}' for name, kind in fields)})")

    def place(self, name: str) -> tuple[int, Any]:
        """Offset [bytes] and type of a field."""
        offset = 0
        for field, kind in self.fields:
            if field == name:
                return offset, kind
            offset += WORD * (1 if isinstance(kind, PackedType) else 5 + 2 * kind.ndim)
        raise AttributeError(name)


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
    """Code for ``packed.name``: one array descriptor, or the pointer to a packed tuple.

    The block is never written after it was made. Saying so of each of its words (``invariant.load``) spares loops to
    load them again after every store to an array.
    """
    offset, found = kind.place(name)
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

    block = context.get_value_type(found)
    return words(builder.bitcast(cgutils.pointer_add(builder, value, offset), block.as_pointer()), block)
