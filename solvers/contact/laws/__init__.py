"""The laws that units of a contact problem obey, one file a law; ``Group.law`` holds their numbers.

A law is a module with six functions, in which v and p are the velocity and the force of unit k of the group:

    solve(group, k, v, p)         the new force that obeys the law if no other changes, and whether there is one
    answer(group, k, a, convex)   q: the force that obeys the law regularised by a = c - v / eps about a centre c, and
                                  its state
    derivative(group, k, a, state, rho, C)    C[k] = rho dq/da by rows, in that state
    room(group, k, q, d)          how far q may go along d until its state changes
    miss(group, k, p, v)          what is left of the law, in the unit of the contact; inf for what is not finite
    soft(eps)                     the eps that the law can bear

To add one, write such a file and name it in NAMES: sweeps, Newton's method and the certificate take it from there,
and tests hold it to a contract: its functions agree with each other. What to know:

- A state is any integer but those of :mod:`.states` that mean something else: a factor serves again only while no unit
  has changed its state, so each piece of the answer needs one of its own. 0 is "without force".
- Functions that most problems never come to are kernels, not inline ones: each is copied into all iterations.
- Paths (:mod:`..tracing`) know of Coulomb's law, half lines and joints alone, and are not begun with others. The convex
  start ends at points that are judged: with other laws it may be of no use, but does no harm.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from types import ModuleType
from typing import Any

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.solvers.contact.algebra import Vector
from lcpflex.solvers.contact.group import Group
from lcpflex.solvers.contact.laws import disc, interval  # noqa: F401  Coulomb's law in space and in the plane

__all__ = [
    "BILATERAL", "COULOMB", "HALF_LINE", "LOADED", "answer", "derivative", "miss", "number_of", "room", "soft", "solve",
]  # fmt: skip

NAMES = (
    "coulomb",
    "half_line",
    "bilateral",
    "loaded",
)
LAWS: tuple[ModuleType, ...] = tuple(import_module(f"{__name__}.{name}") for name in NAMES)


def number_of(law: ModuleType) -> int:
    """What ``Group.law`` holds for a law."""
    return LAWS.index(law)


COULOMB, HALF_LINE, BILATERAL, LOADED = map(NAMES.index, ("coulomb", "half_line", "bilateral", "loaded"))


def _switch(name: str, given: str, chosen: str = "group.law[k]") -> Any:
    """A kernel with the arguments ``given`` that calls the function ``name`` of the law ``chosen``.

    Written out as a chain of comparisons, which costs a sweep 1 % of its time; functions in a tuple cost as much again
    as the sweep.
    """
    scope, lines = globals(), [f"def {name}({given}):", f"    law = {chosen}"]
    arguments = given.removeprefix("law, ")
    for number, law in enumerate(LAWS):
        own = f"{law.__name__.rpartition('.')[2]}_{name}"
        scope[own] = getattr(law, name)
        lines += [f"    if law == {number}:"] * (number + 1 < len(LAWS))
        lines += ["    " * (1 + (number + 1 < len(LAWS))) + f"return {own}({arguments})"]
    exec(compile("\n".join(lines), __file__, "exec"), scope)
    return kernel(inline=True)(scope[name])


solve: Callable[[Group, int, Vector, Vector], tuple[Vector, bool]] = _switch("solve", "group, k, v, p")
answer: Callable[[Group, int, Vector, bool], tuple[Vector, int]] = _switch("answer", "group, k, a, convex")
derivative: Callable[[Group, int, Vector, int, float, FloatArray], None] = _switch(
    "derivative", "group, k, a, state, rho, C"
)
room: Callable[[Group, int, Vector, Vector], float] = _switch("room", "group, k, q, d")
miss: Callable[[Group, int, Vector, Vector], float] = _switch("miss", "group, k, p, v")
soft: Callable[[int, float], float] = _switch("soft", "law, eps", "law")
