"""The law that docs/contact_problem.md adds, added to a copy of the package and asked for its forces."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "contact_problem.md"
TABLE = 'NAMES = (\n    "coulomb",\n    "half_line",\n    "bilateral",\n    "loaded",\n'
ASKED = """
import numpy as np
from lcpflex.solvers.contact.laws import limited
from lcpflex.solvers.contact.units import solve_units

J = np.random.default_rng(1).normal(size=(6, 9))
W, free = J @ J.T, J @ np.ones(9)
W, free = W[:6:2, :6:2], free[:6:2]  # one row a drive
for rows in (2, 3):
    full, given = np.zeros((3 * rows, 3 * rows)), np.zeros((3, rows))
    full[::rows, ::rows], given[:, 0] = W, free
    held = -np.linalg.solve(W, free)
    bound = 0.3 * np.abs(held).max()
    for f in (1e6, bound):
        found = solve_units(full, given, [limited] * 3, floor=f)
        assert found.solved, found
        p, v = found.p[:, 0], found.v[:, 0]
        assert np.abs(p).max() <= f * (1.0 + 1e-9)
        assert np.abs(np.where(np.abs(p) < f * (1.0 - 1e-9), v, 0.0)).max() <= 1e-8
        assert (p * v <= 1e-8).all()
        if f > bound:
            np.testing.assert_allclose(p, held, rtol=1e-7)
        else:
            assert np.abs(p).max() >= f * (1.0 - 1e-9)
"""


def test_the_law_of_the_page_is_a_file_and_a_line(tmp_path: Path) -> None:
    """As it is printed there; the contract of laws holds it, too."""
    page = PAGE.read_text()
    law, line = re.findall(r"```python\n(.*?)```", page, re.DOTALL)[1:3]
    copy = tmp_path / "tree"
    shutil.copytree(ROOT / "lcpflex", copy / "lcpflex", symlinks=False, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copytree(ROOT / "tests", copy / "tests", ignore=shutil.ignore_patterns("__pycache__"))
    laws = copy / "lcpflex" / "solvers" / "contact" / "laws"
    (laws / "limited.py").write_text(law)
    table = laws / "__init__.py"
    source = table.read_text()
    assert TABLE in source
    assert TABLE + '    "limited",\n' in line
    table.write_text(source.replace(TABLE, TABLE + '    "limited",\n'))
    environment = os.environ | {"PYTHONPATH": str(copy), "NUMBA_DISABLE_JIT": "1"}
    for command in (["-c", ASKED], ["-m", "pytest", "-q", "-p", "no:cacheprovider", "tests/unit/solvers/test_laws.py"]):
        done = subprocess.run(
            [sys.executable, *command], env=environment, cwd=copy, capture_output=True, text=True, check=False
        )  # fmt: skip
        assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]


def test_the_page_is_one_page() -> None:
    """Names of files that it tells are there."""
    page = PAGE.read_text()
    for path in re.findall(r"`(solvers/[\w/.]+|dynamics/[\w/.]+|tests/[\w/.]+)`", page):
        if path.endswith("limited.py"):
            continue
        assert (ROOT / path).exists() or (ROOT / "lcpflex" / path).exists(), path


if __name__ == "__main__":
    pytest.main([__file__])
