"""Functions of which each kind of struct has its own kernel: loops are written once, over any scheme.

    @leaf
    def take_step(model, scheme, t): ...

    @take_step.of(MoreauJeanScheme)
    @kernel
    def step(model, scheme, t): ...

A call takes the kernel of the first argument whose struct has one: numba when it compiles the caller, from the types
of the arguments; Python from their classes. The caller is compiled anew for each kind, and nothing is looked up while
it runs.

    @in_space("lcpflex.dynamics.spatial.forces")
    @kernel
    def forces(model, q, u): ...

is a kernel for what is planar; where an argument is a struct of space, the function of the same name in that module
goes before it. The module is loaded when it is first asked for: planar scenes pay nothing for it.

    @leaf
    def dot(a, b): ...

    @dot.of(2)
    @kernel(inline=True)
    def dot_in_plane(a, b): ...

is chosen by the length of a tuple: one loop serves contacts of two rows and of three.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Mapping
from importlib import import_module
from typing import Any, Generic, ParamSpec, TypeVar

from lcpflex.jit.kernel import kernel

__all__ = ["Leaf", "dispatcher_of", "forget_choices", "in_space", "leaf", "length_label", "load_space", "optional_leaf"]

SPATIAL = "Spatial"  # names of the structs of space begin so
LENGTH = "#"  # labels of tuples begin so, which no name does

P = ParamSpec("P")
R = TypeVar("R")

_modules: set[str] = set()  # with kernels of space
forget_choices: list[Callable[[], None]] = []  # called when a leaf has one more kernel: what has looked at the others


class Leaf(Generic[P, R]):
    """A function with a kernel for each kind of struct.

    Attributes
    ----------
    name
        Module and name of the function as it was declared.
    kernels
        By the name of the struct, or by :func:`length_label`.
    default
        The kernel of kinds that have none of their own; None where each must have one.
    py_func
        The plain Python source of the default, where there is one.
    space
        Module with the kernel of all kinds of space; empty where they have none of their own.
    """

    def __init__(self, declared: Callable[P, R], default: Callable[P, R] | None = None, space: str = "") -> None:
        self.name = f"{declared.__module__}.{declared.__qualname__}"
        self.__doc__ = declared.__doc__
        self.default = default
        self.space = space
        self.kernels: dict[str, Callable[P, R]] = {}
        if default is not None:
            self.py_func = getattr(default, "py_func", default)

    def of(self, *kinds: type | int) -> Callable[[Callable[P, R]], Callable[P, R]]:
        """Decorator: the kernel of these structs, or of tuples of so many numbers."""
        labels = [length_label(kind) if isinstance(kind, int) else kind.__name__ for kind in kinds]

        def register(function: Callable[P, R]) -> Callable[P, R]:
            self.kernels.update(dict.fromkeys(labels, function))
            for forget in forget_choices:
                forget()
            return function

        return register

    def __call__(self, *args: P.args, **kwargs: P.kwargs) -> R:
        """What the kernel of the arguments returns."""
        return self.chosen(map(_label, args))(*args, **kwargs)

    def chosen(self, labels: Iterable[str]) -> Callable[P, R]:
        """The kernel for arguments by the names of their structs.

        Raises
        ------
        TypeError
            Where none of them has one.
        """
        found = next((self._kernel(label) for label in labels if self._knows(label)), self.default)
        if found is None:
            raise TypeError(f"{self.name} has kernels for {sorted(self.kernels)}, and for none of the arguments")
        return found

    def _knows(self, label: str) -> bool:
        return label in self.kernels or (bool(self.space) and label.startswith(SPATIAL))

    def _kernel(self, label: str) -> Callable[P, R]:
        key = label if label in self.kernels or not self.space else SPATIAL
        if key not in self.kernels:
            self.kernels[key] = getattr(import_module(self.space), self.name.rpartition(".")[2])
        return self.kernels[key]

    def of_kinds(self, labels: frozenset[str]) -> dict[str, Callable[P, R]]:
        """All that a call with arguments of these structs may take, the default under "".

        Those of tuples in any case: what a kernel calls is not told by its arguments.
        """
        found = {label: self.kernels[label] for label in labels if label in self.kernels}
        found |= {label: kernel for label, kernel in self.kernels.items() if label.startswith(LENGTH)}
        if self.space and any(map(self._knows, labels)):
            return {SPATIAL: self._kernel(SPATIAL)}  # and no planar one
        return found if self.default is None else {**found, "": self.default}

    @property
    def _numba_type_(self) -> Any:
        """What numba asks of a value that a function names."""
        from lcpflex.jit.leaf_type import LeafType

        return LeafType(self)

    def copy(self) -> Leaf[P, R]:
        """Another one with the same kernels."""
        other: Leaf[P, R] = object.__new__(type(self))
        vars(other).update(vars(self), kernels=dict(self.kernels))
        return other

    def put_in(self, functions: Mapping[str, Callable[..., Any]]) -> None:
        """Take other functions for some kinds, the default under ""."""
        self.kernels.update({kind: function for kind, function in functions.items() if kind})
        self.default = functions.get("", self.default)

    @property
    def calls(self) -> dict[str, Callable[P, R]]:
        """All its kernels that are loaded, the default under ""."""
        if self.space in sys.modules:
            self._kernel(SPATIAL)
        return self.kernels if self.default is None else {**self.kernels, "": self.default}


def length_label(length: int) -> str:
    """Under what a leaf has its kernel for tuples of so many numbers."""
    return f"{LENGTH}{length}"


def _label(argument: Any) -> str:
    """By what leaves choose, of an argument in Python."""
    return length_label(len(argument)) if type(argument) is tuple else getattr(argument, "_label", "")


def leaf(declared: Callable[P, R]) -> Leaf[P, R]:
    """A function without code of its own: each kind of struct must have a kernel for it."""
    return Leaf(declared)


def optional_leaf(declared: Callable[P, R]) -> Leaf[P, R]:
    """A function whose code serves all kinds of structs that have no kernel for it."""
    return Leaf(declared, kernel(declared))


def in_space(module: str) -> Callable[[Callable[P, R]], Leaf[P, R]]:
    """Decorator of a planar kernel: arguments of space are for the function of the same name in that module."""

    _modules.add(module)

    def declare(planar: Callable[P, R]) -> Leaf[P, R]:
        return Leaf(getattr(planar, "py_func", planar), planar, module)

    return declare


def dispatcher_of(module: str, name: str) -> Any:
    """What compiles the kernel of that name; of a leaf, the kernel that it was declared with."""
    found = getattr(import_module(module), name)
    kernel: Any = found.default if isinstance(found, Leaf) else found
    return kernel.made


def load_space() -> None:
    """Load the kernels of space of all leaves so far: where Python functions stand in for some, all must be known."""
    for module in sorted(_modules):
        import_module(module)
