"""What numba must know of :class:`lcpflex.jit.leaf.Leaf`: a call has the type and the code of the kernel it chooses."""

from __future__ import annotations

from typing import Any

import numba.core.types
from numba.extending import models, register_model

from lcpflex.jit.leaf import Leaf, length_label

__all__ = ["LeafType"]

types: Any = numba.core.types
PLAIN_TUPLES = types.Tuple, types.UniTuple  # those with names have other types


class LeafType(types.Callable, types.Dummy):  # type: ignore[misc]
    """The type of one leaf."""

    def __init__(self, leaf: Leaf[Any, Any]) -> None:
        self.leaf = leaf
        super().__init__(name=f"leaf {leaf.name}")

    def get_call_type(self, context: Any, args: Any, kws: Any) -> Any:
        """The signature of the kernel for these arguments."""
        return self._dispatcher(args).get_call_type(context, args, kws)

    def get_call_signatures(self) -> tuple[tuple[Any, ...], bool]:
        """None that hold for all arguments."""
        return (), True

    def get_impl_key(self, sig: Any) -> Any:
        """Under what numba finds the code of a call."""
        return self._dispatcher(sig.args).get_impl_key(sig)

    def _dispatcher(self, arguments: Any) -> Any:
        """The type of the kernel for arguments of these types."""
        chosen: Any = self.leaf.chosen(map(_label, arguments))
        return chosen._numba_type_


def _label(argument: Any) -> str:
    """By what leaves choose, of the type of an argument."""
    if isinstance(argument, PLAIN_TUPLES):
        return length_label(len(argument))
    return getattr(argument, "label", "")


@register_model(LeafType)
class LeafModel(models.OpaqueModel):  # type: ignore[misc]
    """Nothing is passed."""
