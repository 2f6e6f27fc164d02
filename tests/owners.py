"""Who writes to which struct of a workspace: read from the sources, by the types that parameters are declared with.

A name is followed from the parameter or the field it stands for: through aliases (``p = work.impulses.p``), unpacked
tuples, slices, and arrays handed to functions that write to them, however deep. A function that is handed a whole owner
struct answers for what it writes. Where a field of one is handed over, either may be the writer: the function that
writes to its argument, or the one that hands it over.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import TypeAlias

OWNERS = ("Rows", "FreeMotion", "Posed", "Impulses", "Scratch")
SPACE = {"SpatialWork": "Workspace", "SpatialWorkspace": "Workspace", "RowsOfSpace": "Rows", "SpatialRows": "Rows"}
WORK = {"work", "_work", "old_work"}  # what is not annotated, but never anything else
ARRAYS = {"FloatArray", "IntArray"}

Key: TypeAlias = tuple[str, str]  # a module and the name of a function in it


@dataclass(frozen=True)
class Place:
    """What an expression stands for: a part of a parameter, or of a field "Owner.field"; and its declared type."""

    root: str
    type: str
    owned: bool = False


@dataclass(frozen=True)
class Write:
    """A place in the sources that writes to a field of an owner, by itself or through the function that it calls."""

    module: str
    line: int
    target: str
    through: Key = ("", "")

    def __str__(self) -> str:
        through = f" through {'.'.join(self.through)}" if self.through[0] else ""
        return f"{self.module}, line {self.line}: {self.target}{through}"

    @property
    def owner(self) -> str:
        """The struct that the field belongs to."""
        return self.target.partition(".")[0]

    def by(self, names: Iterable[str]) -> bool:
        """Whether one of these modules, or one in these packages, writes."""
        return any(f"{module}.".startswith(f"{name}.") for module in (self.module, self.through[0]) for name in names)


@dataclass
class Found:
    """What one function does: its writes, and what it hands to others."""

    parameters: list[str]
    writes: list[tuple[Place, int]] = field(default_factory=list)
    calls: list[tuple[str, str, int, int, Place]] = field(default_factory=list)  # key, line, which argument, its place


def foreign(writes: Iterable[Write], writers: Mapping[str, tuple[str, ...]]) -> list[str]:
    """Those by modules that ``writers`` names neither for the owner nor for its field."""
    return [str(one) for one in writes if not one.by((*writers[one.owner], *writers.get(one.target, ())))]


def all_writes(sources: Mapping[str, str]) -> list[Write]:
    """All writes to fields of owners; sources: the text of each module by its name."""
    trees = {module: ast.parse(text) for module, text in sources.items()}
    structs = {name: fields for tree in trees.values() for name, fields in _structs(tree)}
    functions: dict[Key, list[Found]] = {}
    twins: dict[Key, set[Key]] = {}
    for module, tree in trees.items():
        imported = dict(_imports(tree))
        for node in ast.walk(tree):
            if isinstance(node, ast.FunctionDef):
                functions.setdefault((module, node.name), []).append(_Reader(module, imported, structs).read(node))
                for declared in _declared(node, imported):
                    twins.setdefault(declared, set()).add((module, node.name))
                for other in _spaces(node):
                    twins.setdefault((module, node.name), set()).add((other, node.name))
    written = _written(functions, twins)
    found: set[Write] = set()
    for (module, _), each in functions.items():
        for one in each:
            found |= {Write(module, line, place.root) for place, line in one.writes if place.owned}
            for where, name, line, argument, place in one.calls:
                if place.owned and argument in written.get((where, name), ()):
                    found.add(Write(module, line, place.root, (where, name)))
    return sorted(found, key=lambda write: (write.module, write.line, write.target))


def _written(functions: Mapping[Key, list[Found]], twins: Mapping[Key, set[Key]]) -> dict[Key, set[int]]:
    """Arguments that each function writes to, by itself or through others: a fixpoint."""
    callers: dict[Key, set[Key]] = {}
    for key, each in functions.items():
        for one in each:
            for where, name, *_ in one.calls:
                callers.setdefault((where, name), set()).add(key)
    declared = {twin: key for key, several in twins.items() for twin in several}
    written: dict[Key, set[int]] = {}
    todo = set(functions)
    while todo:
        key = todo.pop()
        now = set(written.get(key, ()))
        for one in functions.get(key, ()):
            roots = {place.root for place, _ in one.writes if not place.owned}
            for where, name, _, argument, place in one.calls:
                if not place.owned and argument in written.get((where, name), ()):
                    roots.add(place.root)
            now |= {one.parameters.index(root) for root in roots if root in one.parameters}
        for twin in twins.get(key, ()):
            now |= written.get(twin, set())
        if now != written.get(key, set()):
            written[key] = now
            todo |= callers.get(key, set()) | ({declared[key]} if key in declared else set())
    return written


class _Reader:
    """Reads one function."""

    def __init__(self, module: str, imported: Mapping[str, Key], structs: Mapping[str, Mapping[str, str]]) -> None:
        self.module, self.imported, self.structs = module, imported, structs
        self.known: dict[str, Place] = {}

    def read(self, function: ast.FunctionDef) -> Found:
        """What it does."""
        arguments = [*function.args.posonlyargs, *function.args.args, *function.args.kwonlyargs]
        found = Found([argument.arg for argument in arguments])
        for argument in arguments:
            kind = self._type(argument.annotation)
            if argument.arg in WORK and kind not in self.structs:
                kind = "Workspace" if kind in ("", "Any") else kind
            self.known[argument.arg] = Place(argument.arg, kind)
        nodes = list(ast.walk(function))
        for _ in range(2):  # an alias may stand before its source in the order of the walk
            for node in nodes:
                if isinstance(node, ast.Assign):
                    for target in node.targets:
                        self._alias(target, node.value)
        for node in nodes:
            if isinstance(node, ast.Assign):
                for target in node.targets:
                    found.writes += self._stored(target)
            elif isinstance(node, ast.AugAssign):
                found.writes += self._stored(node.target)
                if isinstance(node.target, ast.Name) and (place := self._place(node.target)) and place.type in ARRAYS:
                    found.writes.append((place, node.lineno))
            elif isinstance(node, ast.Call):
                self._call(node, found)
        return found

    def _type(self, annotation: ast.expr | None) -> str:
        if annotation is None:
            return ""
        parts = ast.unparse(annotation).strip("'\"").split(" | ")
        named = [SPACE.get(part, part) for part in parts]
        return next((part for part in named if part in self.structs), named[0])

    def _alias(self, target: ast.expr, value: ast.expr) -> None:
        if isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple):
            for one, other in zip(target.elts, value.elts, strict=False):
                self._alias(one, other)
        elif isinstance(target, ast.Name) and target.id not in self.known and (place := self._place(value)):
            self.known[target.id] = place

    def _place(self, node: ast.expr) -> Place | None:
        """What an expression stands for, where it is a part of a parameter or of an owner."""
        if isinstance(node, ast.Name):
            return self.known.get(node.id) or (Place(node.id, "Workspace") if node.id in WORK else None)
        if isinstance(node, ast.Subscript):
            return self._place(node.value)
        if isinstance(node, ast.IfExp):
            return self._place(node.body) or self._place(node.orelse)
        if not isinstance(node, ast.Attribute):
            return None
        of = self._place(node.value)
        if of is None or of.type not in self.structs:
            return Place(node.attr, "Workspace") if node.attr in WORK else of
        kind = self.structs[of.type].get(node.attr)
        if kind is None:  # in space the memory of a solver has other fields
            return Place(of.root, "", owned=True) if of.owned else None
        if of.type in OWNERS:
            return Place(f"{of.type}.{node.attr}", kind, owned=True)
        return Place(of.root, kind, of.owned)

    def _stored(self, target: ast.expr) -> Iterator[tuple[Place, int]]:
        if isinstance(target, ast.Tuple | ast.List):
            for one in target.elts:
                yield from self._stored(one)
        elif isinstance(target, ast.Subscript | ast.Attribute):
            place = self._place(target)
            if place is not None and not (isinstance(target, ast.Attribute) and place.type == "Workspace"):
                yield place, target.lineno

    def _call(self, node: ast.Call, found: Found) -> None:
        function = node.func
        if isinstance(function, ast.Attribute) and function.attr in ("fill", "sort"):
            if place := self._place(function.value):
                found.writes.append((place, node.lineno))
            return
        if isinstance(function, ast.Name):
            key = self.imported.get(function.id, (self.module, function.id))
        elif isinstance(function, ast.Attribute) and isinstance(function.value, ast.Name):
            if function.value.id not in self.imported:
                return
            key = ".".join(self.imported[function.value.id]), function.attr
        else:
            return
        for at, argument in enumerate(node.args):
            place = self._place(argument)
            if place is not None and place.type not in ("int", "float", "bool"):
                found.calls.append((*key, node.lineno, at, place))


def _structs(tree: ast.Module) -> Iterable[tuple[str, dict[str, str]]]:
    """The declared structs and the types of their fields."""
    for node in tree.body:
        if isinstance(node, ast.ClassDef) and any(ast.unparse(one) == "struct" for one in node.decorator_list):
            fields = (one for one in node.body if isinstance(one, ast.AnnAssign) and isinstance(one.target, ast.Name))
            yield node.name, {one.target.id: ast.unparse(one.annotation) for one in fields}  # type: ignore[union-attr]


def _imports(tree: ast.Module) -> Iterable[tuple[str, Key]]:
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module:
            for name in node.names:
                yield name.asname or name.name, (node.module, name.name)


def _spaces(function: ast.FunctionDef) -> Iterable[str]:
    """Modules with the same function for space."""
    for one in function.decorator_list:
        if isinstance(one, ast.Call) and ast.unparse(one.func) == "in_space":
            yield ast.literal_eval(one.args[0])


def _declared(function: ast.FunctionDef, imported: Mapping[str, Key]) -> Iterable[Key]:
    """Leaves that the function is a kernel of."""
    for one in function.decorator_list:
        if isinstance(one, ast.Call) and isinstance(one.func, ast.Attribute) and one.func.attr == "of":
            name = ast.unparse(one.func.value)
            if name in imported:
                yield imported[name]
