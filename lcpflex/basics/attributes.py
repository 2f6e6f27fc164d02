"""An attribute that an object does not have, told with the one that was meant."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, ClassVar

from lcpflex.basics.names import nearest

__all__ = ["NamesNearest"]

ALSO = dict.fromkeys(("t", "ts", "time", "times", "instant", "instants"), ("times", "time"))  # what others call it


class NamesNearest:
    """A base of classes whose users may know other names: AttributeError tells what is meant.

    ``_known_as``: what is told of names that belong to another class.
    """

    __slots__ = ()
    _known_as: ClassVar[Mapping[str, str]] = {}

    if not TYPE_CHECKING:  # every attribute would be there for type checkers

        def __getattr__(self, name: str) -> Any:
            kind = type(self)
            if hasattr(kind, name):  # a property that raised AttributeError itself, or a field that is not set yet
                return object.__getattribute__(self, name)
            told = ""
            if not name.startswith("_"):  # tools ask for __deepcopy__, _repr_html_ ...
                known = [key for key in dir(kind) if not key.startswith("_")]
                also = [key for key in ALSO.get(name, ()) if key in known]
                told = f": {self._known_as[name]}" if name in self._known_as else nearest((also or [name])[0], known)
            raise AttributeError(f"{kind.__name__!r} object has no attribute {name!r}{told}")
