"""Functions of which each kind of struct has its own kernel: loops are written once, over any scheme.

    @leaf
    def take_step(model, scheme, t): ...

    @take_step.of(MoreauJeanScheme)
    @kernel
    def step(model, scheme, t): ...

A call takes the kernel of the first argument whose struct has one: numba when it compiles the caller, from the types
of the arguments; Python from their classes. The caller is compiled anew for each kind, and nothing is looked up while
it runs.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any, Generic, ParamSpec, TypeVar

from lcpflex.jit.kernel import kernel

__all__ = ["Leaf", "leaf", "optional_leaf"]

P = ParamSpec("P")
R = TypeVar("R")


class Leaf(Generic[P, R]):
    """A function with a kernel for each kind of struct.

    Attributes
    ----------
    name
        Module and name of the function as it was declared.
    kernels
        By the name of the struct.
    default
        The kernel of kinds that have none of their own; None where each must have one.
    """

    def __init__(self, declared: Callable[P, R], default: Callable[P, R] | None = None) -> None:
        self.name = f"{declared.__module__}.{declared.__qualname__}"
        self.__doc__ = declared.__doc__
        self.default = default
        self.kernels: dict[str, Callable[P, R]] = {}

    def of(self, *kinds: type) -> Callable[[Callable[P, R]], Callable[P, R]]:
        """Decorator: the kernel of these structs."""

        def register(function: Callable[P, R]) -> Callable[P, R]:
            self.kernels.update({kind.__name__: function for kind in kinds})
            return function

        return register

    def __call__(self, *args: P.args, **kwargs: P.kwargs) -> R:
        """What the kernel of the arguments returns."""
        return self.chosen(getattr(argument, "_label", "") for argument in args)(*args, **kwargs)

    def chosen(self, labels: Iterable[str]) -> Callable[P, R]:
        """The kernel for arguments by the names of their structs.

        Raises
        ------
        TypeError
            Where none of them has one.
        """
        found = next((self.kernels[label] for label in labels if label in self.kernels), self.default)
        if found is None:
            raise TypeError(f"{self.name} has kernels for {sorted(self.kernels)}, and for none of the arguments")
        return found

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
        """All its kernels, the default under ""."""
        return self.kernels if self.default is None else {**self.kernels, "": self.default}


def leaf(declared: Callable[P, R]) -> Leaf[P, R]:
    """A function without code of its own: each kind of struct must have a kernel for it."""
    return _known_to_numba(Leaf(declared))


def optional_leaf(declared: Callable[P, R]) -> Leaf[P, R]:
    """A function whose code serves all kinds of structs that have no kernel for it."""
    return _known_to_numba(Leaf(declared, kernel(declared)))


def _known_to_numba(made: Leaf[P, R]) -> Leaf[P, R]:
    import lcpflex.jit.leaf_type  # noqa: F401  (numba is loaded by the first kernel)

    return made
