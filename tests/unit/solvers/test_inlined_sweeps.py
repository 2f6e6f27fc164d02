"""The innermost loop of contact problems is one piece of machine code: a call in it would cost half of its speed.

LLVM copies a function by itself only where it is small or has one caller; laws, operators and vectors have many.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from lcpflex.jit.private import why_not_thin

TREE = Path(__file__).parents[3]
# Another limit of what is taken in gives other keys: nothing that was compiled before is loaded in its place.
COMPILE = """
import json, re, sys
from lcpflex.jit import thin
thin.LARGEST += 1
from lcpflex.solvers.contact.sweeping import sweep
from lcpflex.solvers.contact.operators import begin
from tests.unit.solvers.test_block_iteration import LIKE, Problem
found = {}
for storage in sys.argv[1:]:
    for rows, like in LIKE.items():
        problem = Problem(rows, 3, seed=1)
        group, op = problem.group, problem.operator(storage)
        begin(op, group, group.p, like)
        sweep(op, group, like, 1, 0.0)
        made = {types: one.library for types, one in sweep.overloads.items()}
        (code,) = [one for types, one in made.items() if types[0] is op._type and types[2].count == rows]
        text = code.get_llvm_str()
        names = r'@("[^"]+"|[\\w.$]+)'
        called = re.findall(rf"(?:call|invoke) [^@\\n]*{names}", text)
        found[f"{storage} {rows}"] = len(re.findall(rf"define [^@\\n]*{names}", text)), sorted({*called, *code.needs})
print(json.dumps(found))
"""


@pytest.mark.skipif(bool(os.environ.get("NUMBA_DISABLE_JIT")), reason="nothing is compiled")
@pytest.mark.skipif(bool(why_not_thin()), reason="numba links as it does for all")
@pytest.mark.parametrize("storages", [("dense", "bodies"), pytest.param(("blocks", "factor"), marks=pytest.mark.slow)])
def test_sweeps_call_nothing(storages: tuple[str, ...], tmp_path: Path) -> None:
    """But what LLVM has an instruction for, in the plane and in space."""
    environment = {**os.environ, "PYTHONPATH": str(TREE), "NUMBA_CACHE_DIR": str(tmp_path)}
    command = [sys.executable, "-c", COMPILE, *storages]
    told = subprocess.run(command, env=environment, cwd=TREE, capture_output=True, text=True, check=True)
    found = json.loads(told.stdout)
    assert len(found) == 4
    for functions, called in found.values():
        assert functions == 1
        assert [name for name in called if not name.startswith("llvm.")] == []
        assert "llvm.fabs.f64" in called  # what is looked for is found
