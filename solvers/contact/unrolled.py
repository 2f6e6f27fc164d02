"""Small functions of vectors of any length, written out for two numbers and for three: see :func:`unrolled`.

Numba knows no tuple made in a loop, and a loop over a tuple asks for each number by its place, which costs a sweep its
speed. So what is written once is compiled as if it were written out: the source is taken apart, and put together again
for each length.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator
from functools import cache, reduce
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

from lcpflex.jit.kernel import kernel
from lcpflex.jit.leaf import Leaf, leaf

__all__ = ["unrolled"]

LENGTHS = {2: "in_plane", 3: "in_space"}  # and how their kernels are called

P = ParamSpec("P")
R = TypeVar("R")


def unrolled(function: Callable[P, R]) -> Leaf[P, R]:
    """Decorator: a leaf with an inline kernel for vectors of two numbers, and one for three.

    Arguments annotated as ``Vector`` are tuples of that length. Written out are loops over a range up to
    ``len(vector)``, and such ``tuple(...)``, ``sum(...)``, ``max(...)`` and starred parts of a tuple: a_0 + a_1 + a_2
    from the left, max(a_0, max(a_1, a_2)) from the right.
    """
    known = leaf(function)
    declared = _functions(function.__code__.co_filename)[function.__name__]
    scope: dict[str, Any] = function.__globals__
    vectors = {a.arg for a in declared.args.args if isinstance(a.annotation, ast.Name) and a.annotation.id == "Vector"}
    for length, words in LENGTHS.items():
        name = f"{function.__name__}_{words}"
        arguments = ast.arguments([], [ast.arg(a.arg) for a in declared.args.args], None, [], [], None, [])
        body = _WrittenOut(vectors, length).statements(declared.body)
        made = ast.FunctionDef(name, arguments, body, [], lineno=declared.lineno, end_lineno=declared.end_lineno)
        whole = ast.fix_missing_locations(ast.Module([made], []))
        exec(compile(whole, function.__code__.co_filename, "exec"), scope)
        scope[name] = known.of(length)(kernel(inline=True)(scope[name]))
    return known


@cache
def _functions(file: str) -> dict[str, ast.FunctionDef]:
    parsed = ast.parse(Path(file).read_bytes())
    return {node.name: node for node in parsed.body if isinstance(node, ast.FunctionDef)}


class _WrittenOut:
    """Copies of a source in which vectors have one length, loops over their numbers step by step."""

    def __init__(self, vectors: set[str], length: int) -> None:
        self.vectors, self.length = vectors, length
        self.numbers: dict[str, int] = {}  # of the loops that are being written out

    def statements(self, body: list[ast.stmt]) -> list[ast.stmt]:
        """Of a body."""
        made: list[ast.stmt] = []
        for statement in body:
            if isinstance(statement, ast.For) and self.is_known(statement):
                for _ in self.steps(statement):
                    made += self.statements(statement.body)
            else:
                made.append(self.copy(statement))
        return made

    def copy(self, node: Any) -> Any:
        """Of any part of a source."""
        if isinstance(node, list):
            return self.statements(node) if node and isinstance(node[0], ast.stmt) else list(map(self.copy, node))
        if isinstance(node, ast.Name):
            return ast.Constant(self.numbers[node.id]) if node.id in self.numbers else node
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            return self.call(node, node.func.id)
        if isinstance(node, ast.Tuple):
            return ast.Tuple([made for part in node.elts for made in self.parts(part)], node.ctx)
        fields = getattr(node, "_fields", ())
        return type(node)(*(self.copy(getattr(node, name)) for name in fields)) if fields else node

    def call(self, node: ast.Call, name: str) -> ast.expr:
        """Of ``len(vector)``, of what is made of a generator, and of any other call."""
        first = node.args[0]
        if name == "len" and isinstance(first, ast.Name) and first.id in self.vectors:
            return ast.Constant(self.length)
        if not isinstance(first, ast.GeneratorExp):
            return ast.Call(node.func, self.copy(node.args), [])
        parts = self.parts(ast.Starred(first))
        if name == "tuple":
            return ast.Tuple(parts, ast.Load())
        if name == "sum":
            return reduce(lambda whole, part: ast.BinOp(whole, ast.Add(), part), parts)
        return reduce(lambda whole, part: ast.Call(node.func, [part, whole], []), reversed(parts))

    def parts(self, part: ast.expr) -> list[ast.expr]:
        """Of a part of a tuple: of a starred generator all that it gives."""
        if not isinstance(part, ast.Starred) or not isinstance(part.value, ast.GeneratorExp):
            return [self.copy(part)]
        (loop,) = part.value.generators
        return [self.copy(part.value.elt) for _ in self.steps(loop)]

    def is_known(self, loop: Any) -> bool:
        """Whether a loop is over a range up to the length of a vector."""
        last = loop.iter.args[-1]
        return isinstance(last, ast.Call) and isinstance(self.copy(last), ast.Constant)

    def steps(self, loop: Any) -> Iterator[None]:
        """Once for each number of such a loop, its name standing for it."""
        for number in range(*(bound.value for bound in self.copy(loop.iter.args))):
            self.numbers[loop.target.id] = number
            yield
        del self.numbers[loop.target.id]
