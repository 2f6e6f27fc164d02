"""Runs in which Python functions stand in for kernels: which of the others are then Python, too, is computed.

A compiled kernel calls compiled ones. Where one of them is replaced by a Python function (the mechanics of a user's own
system, a solver that is not compiled, callbacks), every kernel that reaches it must be run as Python, and only those.
Kernels are told apart by identity, never by name: two modules may have a kernel of the same name, and one may import
it under another.
"""

from __future__ import annotations

import dis
import types
from collections.abc import Callable, Mapping
from functools import cache
from typing import Any, cast

from lcpflex.jit.kernel import interpreted
from lcpflex.jit.leaf import Leaf

__all__ = ["Hooks", "callees", "in_space_too", "link", "reaching"]

Kernel = Callable[..., Any]
Hooks = Mapping[Kernel, Kernel]  # kernel: the Python function that stands in for it


def link(root: Kernel, hooks: Hooks) -> Kernel:
    """``root`` with ``hooks`` in place of kernels wherever it reaches one of them; itself where it reaches none.

    Raises
    ------
    TypeError
        For a kernel on the way whose calls cannot be told from its names; see :func:`callees`.
    """
    if not hooks:
        return root
    if root in hooks:
        return hooks[root]
    calls = reaching(root, hooks)
    linked = {**hooks, **{function: _opened(function) for function in calls}}
    for function, called in calls.items():
        _put_in(linked[function], {name: linked[callee] for name, callee in called.items()})
    return linked.get(root, root)


def in_space_too(hooks: Hooks) -> Hooks:
    """``hooks`` that stand in for the kernels of space as well, wherever these are called by themselves."""
    leaves = [kernel for kernel in hooks if isinstance(kernel, Leaf) and kernel.space]
    return {**hooks, **{leaf.chosen(["Spatial"]): hooks[leaf] for leaf in leaves}}


def _opened(function: Kernel) -> Kernel:
    """A copy whose calls can be replaced."""
    return function.copy() if isinstance(function, Leaf) else interpreted(function)


def _put_in(function: Kernel, called: dict[str, Kernel]) -> None:
    """Replace what a copy calls, by the names of :func:`callees`."""
    if isinstance(function, Leaf):
        function.put_in(called)
    else:
        function.__globals__.update(called)


def reaching(root: Kernel, hooks: Hooks) -> dict[Kernel, dict[str, Kernel]]:
    """The kernels from ``root`` on that reach one of ``hooks``, each with what it calls of them and of ``hooks``."""
    graph: dict[Kernel, dict[str, Kernel]] = {}
    waiting = [root]
    while waiting:
        function = waiting.pop()
        if function not in graph and function not in hooks:
            graph[function] = callees(function)
            waiting.extend(graph[function].values())
    callers: dict[Kernel, list[Kernel]] = {}
    for function, called in graph.items():
        for callee in called.values():
            callers.setdefault(callee, []).append(function)
    found: set[Kernel] = set()
    waiting = list(hooks)
    while waiting:
        for caller in callers.get(waiting.pop(), ()):
            if caller not in found:
                found.add(caller)
                waiting.append(caller)
    return {
        function: {name: callee for name, callee in called.items() if callee in found or callee in hooks}
        for function, called in graph.items()
        if function in found
    }


def callees(function: Kernel) -> dict[str, Kernel]:
    """What ``function`` calls, by the name that its own module has for it.

    Raises
    ------
    TypeError
        If it could call kernels through a module, a container or an enclosing function, where they cannot be replaced.
    """
    if isinstance(function, Leaf):
        return function.calls
    source = _source(function)
    called: dict[str, Kernel] = {}
    for name in _names(source.__code__):
        value: Any = source.__globals__.get(name)
        if _is_kernel(value):
            called[name] = value
        elif _hides_kernels(value):
            raise TypeError(f"{source.__module__}.{source.__name__}: name the kernels it calls, not {name!r}")
    if any(_is_kernel(cell.cell_contents) for cell in source.__closure__ or ()):
        raise TypeError(f"{source.__module__}.{source.__name__}: a kernel of an enclosing function cannot be replaced")
    return called


def _source(function: Kernel) -> types.FunctionType:
    return cast(types.FunctionType, getattr(function, "py_func", function))


@cache
def _names(code: types.CodeType) -> frozenset[str]:
    """Global names in ``code`` and in the functions and comprehensions inside it; those of attributes are none."""
    inner = [_names(constant) for constant in code.co_consts if isinstance(constant, types.CodeType)]
    own = (instruction.argval for instruction in dis.get_instructions(code) if instruction.opname == "LOAD_GLOBAL")
    return frozenset(own).union(*inner)


def _is_kernel(value: Any) -> bool:
    """A compiled function, or a plain one, as kernels are where numba is told not to compile."""
    return hasattr(value, "py_func") or isinstance(value, types.FunctionType | Leaf)


def _hides_kernels(value: Any) -> bool:
    if isinstance(value, types.ModuleType):
        return value.__name__.split(".")[0] == __name__.split(".")[0]
    if isinstance(value, dict):
        return any(map(_is_kernel, value.values()))
    return isinstance(value, list | tuple) and any(map(_is_kernel, value))
