"""Kernels that reach what is replaced by Python: the closure over all callers, computed, against the sources read."""

from __future__ import annotations

import ast
import importlib
import pkgutil
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
from lcpflex.jit.kernel import kernel
from lcpflex.solvers.contact.compiled import solve_contacts
from lcpflex.steppers.event_driven import loop as event_loop
from lcpflex.steppers.generalized_alpha import adaptive as generalized_alpha_adaptive, stepper as generalized_alpha
from lcpflex.steppers.massless_boundary import step as massless_step
from lcpflex.steppers.moreau_jean import adaptive as moreau_jean_adaptive, stepper as moreau_jean
from lcpflex.steppers.smooth import explicit as smooth_explicit, slope as smooth_slope

LOOPS: dict[str, Any] = {
    "Moreau-Jean": moreau_jean.advance,
    "adaptive Moreau-Jean": moreau_jean_adaptive.advance_adaptive,
    "generalised-alpha": generalized_alpha.advance,
    "adaptive generalised-alpha": generalized_alpha_adaptive.advance_adaptive,
    "event-driven": event_loop.advance,
    "massless": massless_step.advance,
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
    """Module and name of a kernel, or of the function it was made of."""
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
    return {
        (name, function.name): {
            known[name][node.id]
            for node in ast.walk(function)
            if isinstance(node, ast.Name) and node.id in known[name] and node.id not in own_names(function)
        }
        for name, tree in trees.items()
        for function in tree.body
        if isinstance(function, ast.FunctionDef)
    }


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
    found = {place(function) for function in reaching(LOOPS[loop], replaced)}
    assert found == reach_as_written(LOOPS[loop], HOOKS[which])
    if which == "user system" and "implicit" not in loop:
        assert place(LOOPS[loop]) in found
    if which == "user system" and loop == "adaptive Moreau-Jean":
        looking = {("lcpflex.steppers.adaptive", "unmet"), ("lcpflex.steppers.unmet", "first_unmet")}
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
def leaf(x: float) -> float:
    return x + 1.0


@kernel
def other(x: float) -> float:
    return 10.0 * x


renamed = leaf


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
    return sum([leaf(x) for _ in range(2)])


def test_names_do_not_matter() -> None:
    assert link(middle, {leaf: lambda x: 100.0})(1.0) == 110.0
    assert link(other, {leaf: lambda x: 100.0}) is other
    assert link(leaf, {leaf: abs})(-1.0) == 1.0
    assert link(within, {leaf: lambda x: 100.0})(1.0) == 200.0
    assert link(countdown, {leaf: lambda x: 100.0})(3, 1.0) == 110.0
    assert middle(1.0) == 12.0  # nothing has been changed for others


def test_what_cannot_be_replaced_is_refused() -> None:
    made = [leaf, other]
    scope = {"made": made, "linking": linking}
    hidden = {}
    exec("def inside(x):\n    return made[0](x)\ndef through(x):\n    return linking.link(x)\n", scope, hidden)
    for name, what in (("inside", "'made'"), ("through", "'linking'")):
        with pytest.raises(TypeError, match=f"{name}: name the kernels it calls, not {what}"):
            link(hidden[name], {leaf: abs})

    def enclosed(x: float) -> float:
        return kept(x)

    kept = leaf
    with pytest.raises(TypeError, match="of an enclosing function"):
        link(enclosed, {leaf: abs})
