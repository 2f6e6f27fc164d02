"""Kernels that reach what is replaced by Python: the closure over all callers, computed, against the sources read."""

from __future__ import annotations

import ast
import importlib
import pkgutil
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lcpflex
import lcpflex as lf
from lcpflex.dynamics.mechanics import supply
from lcpflex.dynamics.user_mechanics import hooks
from lcpflex.jit import dispatch as linking
from lcpflex.jit.dispatch import callees, link, reaching
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.jit.leaf import Leaf, leaf, optional_leaf
from lcpflex.jit.struct import allocate, array, copy_parts, struct
from lcpflex.solvers.contact.compiled import solve_contacts
from lcpflex.steppers import fixed_steps, step_doubling
from lcpflex.steppers.event_driven import loop as event_loop
from lcpflex.steppers.smooth import explicit as smooth_explicit, slope as smooth_slope

LOOPS: dict[str, Any] = {
    "fixed steps": fixed_steps.advance,
    "step doubling": step_doubling.advance,
    "event-driven": event_loop.advance,
    "smooth": smooth_explicit.advance,
    "smooth, fixed": smooth_explicit.advance_fixed,
    "smooth, implicit": smooth_slope.slope,
}


def particle() -> lf.UserSystem:
    """A particle above a line, on a rail."""
    return lf.UserSystem(
        q=[0.0, 1.0], u=[1.0, 0.0], mass=np.eye(2), force=lambda t, q, u: [0.0, 0.0], gaps=lambda q: [q[1]],
        normals=[[0.0], [1.0]], constraints=lambda t, q: [q[0] - t], jacobian=lambda t, q: [[1.0, 0.0]],
    )  # fmt: skip


HOOKS: dict[str, list[Any]] = {
    "user system": list(hooks(particle()._functions)),
    "solver": [solve_contacts],
    "load": [supply],
    "everything": [*hooks(particle()._functions), solve_contacts, supply],
}


def place(function: Any) -> tuple[str, str]:
    """Module and name of a kernel, or of the function it was made of, or of a leaf."""
    if isinstance(function, Leaf):
        module, _, name = function.name.rpartition(".")
        return module, name
    source = getattr(function, "py_func", function)
    return source.__module__, source.__name__


@cache
def written() -> dict[tuple[str, str], set[tuple[str, str]]]:
    """What each function of the package names, as its source has it, imports followed: no code is looked at."""
    modules = [m.name for m in pkgutil.walk_packages(lcpflex.__path__, "lcpflex.") if "__main__" not in m.name]
    trees = {
        name: ast.parse(Path(str(importlib.import_module(name).__file__)).read_text(encoding="utf-8"))
        for name in modules
    }
    known: dict[str, dict[str, tuple[str, str]]] = {}
    for name, tree in trees.items():
        own = {node.name: (name, node.name) for node in tree.body if isinstance(node, ast.FunctionDef)}
        imported = {
            alias.asname or alias.name: (node.module, alias.name)
            for node in tree.body
            if isinstance(node, ast.ImportFrom) and node.module
            for alias in node.names
        }
        known[name] = {**imported, **own}
    graph = {
        (name, function.name): {
            known[name][node.id]
            for part in function.body
            for node in ast.walk(part)
            if isinstance(node, ast.Name) and node.id in known[name] and node.id not in own
        }
        for name, tree in trees.items()
        for function in tree.body
        if isinstance(function, ast.FunctionDef)
        for own in [own_names(function)]
    }
    for name, tree in trees.items():
        for declared, function in registered(tree):
            graph[known[name][declared]].add(known[name][function])
        for function, module in spatial(tree):
            graph[name, function].add((module, function))
    return graph


def spatial(tree: ast.Module) -> Iterator[tuple[str, str]]:
    """Names of planar kernels, and of the modules with those of the same name for space: ``@in_space("module")``."""
    for node in tree.body:
        for call in node.decorator_list if isinstance(node, ast.FunctionDef) else ():
            if isinstance(call, ast.Call) and getattr(call.func, "id", "") == "in_space":
                yield node.name, ast.literal_eval(call.args[0])  # type: ignore[union-attr]


def registered(tree: ast.Module) -> Iterator[tuple[str, str]]:
    """Names of leaves and of what a module makes their kernels: ``@leaf.of(Struct)``, ``leaf.of(Struct)(kernel)``."""
    for node in tree.body:
        if isinstance(node, ast.FunctionDef):
            calls = [(call, node.name) for call in node.decorator_list]
        elif isinstance(node, ast.Expr) and isinstance(node.value, ast.Call) and node.value.args:
            calls = [(node.value.func, getattr(node.value.args[0], "id", ""))]
        else:
            continue
        for call, function in calls:
            at = call.func if isinstance(call, ast.Call) else None
            if isinstance(at, ast.Attribute) and at.attr == "of" and isinstance(at.value, ast.Name):
                yield at.value.id, function


def own_names(function: ast.FunctionDef) -> set[str]:
    """Arguments and variables of a function, which may be called like a function of its module."""
    stored = {n.id for n in ast.walk(function) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}
    return stored | {a.arg for a in ast.walk(function) if isinstance(a, ast.arg)}


def reach_as_written(root: Any, replaced: list[Any]) -> set[tuple[str, str]]:
    """The functions from ``root`` on that come to one of ``replaced``."""
    graph, targets = written(), {place(function) for function in replaced}
    within, waiting = set(), [place(root)]
    while waiting:
        at = waiting.pop()
        if at in graph and at not in within and at not in targets:
            within.add(at)
            waiting.extend(graph[at])
    found: set[tuple[str, str]] = set()
    while more := {at for at in within - found if graph[at] & (found | targets)}:
        found |= more
    return found


@pytest.mark.parametrize("which", HOOKS)
@pytest.mark.parametrize("loop", LOOPS)
def test_every_caller_is_found(loop: str, which: str) -> None:
    replaced = dict.fromkeys(HOOKS[which], print)
    expected = reach_as_written(LOOPS[loop], HOOKS[which])  # imports all schemes
    found = {place(function) for function in reaching(LOOPS[loop], replaced)}
    found = {at for at in found if at[0].startswith("lcpflex.")}  # schemes of other tests may be there
    assert found == expected
    if which == "user system" and "implicit" not in loop:
        assert place(LOOPS[loop]) in found
    if which == "user system" and loop == "step doubling":
        looking = {("lcpflex.steppers.unmet", "unmet"), ("lcpflex.steppers.unmet", "first_unmet")}
        assert looking <= found  # between steps, where the lists kept by hand had holes


@pytest.mark.parametrize("loop", LOOPS)
def test_no_original_is_called_any_more(loop: str) -> None:
    """From the linked loop on, by whatever name, no kernel is met that was to be replaced."""
    replaced = {function: lambda *_: None for function in HOOKS["everything"]}
    seen, waiting = set(), [link(LOOPS[loop], replaced)]
    while waiting:
        function = waiting.pop()
        if function not in seen and function not in replaced.values():
            seen.add(function)
            assert function not in replaced
            waiting.extend(callees(function).values())
    assert len(seen) > 10


@kernel
def lowest(x: float) -> float:
    return x + 1.0


@kernel
def other(x: float) -> float:
    return 10.0 * x


renamed = lowest


@kernel
def middle(x: float) -> float:
    return renamed(x) + other(x)


@kernel
def countdown(n: int, x: float) -> float:
    if n == 0:
        return middle(x)
    return countdown(n - 1, x)


@kernel
def within(x: float) -> float:
    return sum([lowest(x) for _ in range(2)])


def test_names_do_not_matter() -> None:
    assert link(middle, {lowest: lambda x: 100.0})(1.0) == 110.0
    assert link(other, {lowest: lambda x: 100.0}) is other
    assert link(lowest, {lowest: abs})(-1.0) == 1.0
    assert link(within, {lowest: lambda x: 100.0})(1.0) == 200.0
    assert link(countdown, {lowest: lambda x: 100.0})(3, 1.0) == 110.0
    assert middle(1.0) == 12.0  # nothing has been changed for others


def test_what_cannot_be_replaced_is_refused() -> None:
    made = [lowest, other]
    scope = {"made": made, "linking": linking}
    hidden = {}
    exec("def inside(x):\n    return made[0](x)\ndef through(x):\n    return linking.link(x)\n", scope, hidden)
    for name, what in (("inside", "'made'"), ("through", "'linking'")):
        with pytest.raises(TypeError, match=f"{name}: name the kernels it calls, not {what}"):
            link(hidden[name], {lowest: abs})

    def enclosed(x: float) -> float:
        return kept(x)

    kept = lowest
    with pytest.raises(TypeError, match="of an enclosing function"):
        link(enclosed, {lowest: abs})


@struct
class Falling:
    n: int
    height: FloatArray = array("points")


@struct
class Rising:
    n: int
    height: FloatArray = array("points")


@leaf
def move(x: float, state: Any) -> float:
    """By x."""
    raise NotImplementedError


@optional_leaf
def rest(state: Any) -> bool:
    """Whether it does."""
    return False


@move.of(Falling)
@kernel
def fall(x: float, state: Falling) -> float:
    state.height[0] -= lowest(x)
    state.n += 1
    return 1.0


@move.of(Rising)
@kernel
def rise(x: float, state: Rising) -> float:
    state.height[0] += other(x)
    return 2.0


@rest.of(Rising)
@kernel
def rest_above(state: Rising) -> bool:
    return state.height[0] > 100.0


@kernel
def move_on(x: float, state: Any, kept: Any) -> float:
    found = move(x, state) + move(x, state)
    copy_parts(state, kept)
    return found + 10.0 * rest(state)


@pytest.mark.parametrize("loop", [move_on, getattr(move_on, "py_func", move_on)], ids=["compiled", "Python"])
def test_a_leaf_is_the_kernel_of_its_struct(loop: Any) -> None:
    assert rest(allocate(Falling, {"points": 1})) is False  # a constant, from Python
    falling, rising, kept_falling, kept_rising = (
        allocate(kind, {"points": 2}) for kind in (Falling, Rising, Falling, Rising)
    )
    assert loop(2.0, falling, kept_falling) == 2.0
    assert loop(6.0, rising, kept_rising) == 14.0
    assert (falling.height.tolist(), falling.n) == ([-6.0, 0.0], 2)
    assert (kept_falling.height.tolist(), kept_falling.n) == ([-6.0, 0.0], 2)
    assert (kept_rising.height.tolist(), kept_rising.n) == ([120.0, 0.0], 0)
    assert kept_falling.height is not falling.height


def test_kernels_of_a_leaf_can_be_replaced_for_one_loop() -> None:
    linked = link(move_on, {lowest: lambda x: 100.0})
    falling, kept = (allocate(Falling, {"points": 1}) for _ in range(2))
    assert linked(2.0, falling, kept) == 2.0
    assert falling.height[0] == kept.height[0] == -200.0
    assert move_on(2.0, falling, kept) == 2.0
    assert falling.height[0] == -206.0  # nothing has been changed for others


def test_a_leaf_without_a_kernel_for_a_struct_says_so() -> None:
    with pytest.raises(TypeError, match=r"test_linking.move has kernels for \['Falling', 'Rising'\]"):
        move(1.0, 2.0)
