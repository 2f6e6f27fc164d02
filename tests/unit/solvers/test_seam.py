"""Mechanics hands over contact problems and reads forces back: no LCP is looked at outside of the solvers."""

import ast
from pathlib import Path

import lcpflex
from lcpflex.solvers.contact.memory import SolverMemory

# what anybody may know of a solution: forces, how good it is, how large the problem was
ANSWER = {"method", "known", "size", "residual", "strict", "iterations", "normal", "tangential"}
INSIDE = set(SolverMemory.__annotations__) - ANSWER


def lcp_reads(source):
    """Places where the memory of a solver, ``x.solver`` or an argument of that type, is asked for parts of an LCP."""
    tree = ast.parse(source)
    named = {
        argument.arg
        for function in ast.walk(tree)
        if isinstance(function, ast.FunctionDef)
        for argument in function.args.args
        if isinstance(argument.annotation, ast.Name) and argument.annotation.id == "SolverMemory"
    }
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and node.attr in INSIDE:
            owner = node.value
            memory = isinstance(owner, ast.Attribute) and owner.attr == "solver"
            if memory or (isinstance(owner, ast.Name) and owner.id in named):
                yield f"line {node.lineno}: {ast.unparse(node)}"


def test_no_lcp_is_read_outside_of_solvers():
    root = Path(lcpflex.__file__).parent
    files = [path for path in root.rglob("*.py") if path.relative_to(root).parts[0] != "solvers"]
    assert len(files) > 200
    found = [f"{path.relative_to(root)}: {place}" for path in files for place in lcp_reads(path.read_text())]
    assert found == []


def test_what_counts_as_reading_one():
    source = (
        "def f(work, memory: SolverMemory):\n    work.solver.M[0] + memory.z + work.solver.normal + memory.residual\n"
    )
    assert sorted(place.partition(": ")[2] for place in lcp_reads(source)) == ["memory.z", "work.solver.M"]
