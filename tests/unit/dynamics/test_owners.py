"""Who writes to which part of a workspace, in all sources, against the one table of those who may."""

from __future__ import annotations

from pathlib import Path

import pytest

import lcpflex
from lcpflex.dynamics import owners, rows, workspace
from lcpflex.dynamics.owners import WRITERS
from tests.owners import OWNERS, Write, all_writes, foreign


@pytest.fixture(scope="module")
def writes() -> list[Write]:
    """All that the modules of the package write."""
    root = Path(lcpflex.__file__).parent
    paths = [*root.rglob("*.py"), *(root / "solvers").resolve().rglob("*.py")]
    named = {_name(path, root): path.read_text() for path in paths}
    assert len(named) > 500
    found = all_writes({name: text for name, text in named.items() if "work" in text or "kernel" in text})
    assert len(found) > 400
    return found


def _name(path: Path, root: Path) -> str:
    solvers = (root / "solvers").resolve()
    inside = Path("solvers") / path.relative_to(solvers) if path.is_relative_to(solvers) else path.relative_to(root)
    return ".".join(("lcpflex", *inside.with_suffix("").parts)).removesuffix(".__init__")


def test_every_owner_is_written_by_those_who_may(writes: list[Write]) -> None:
    assert foreign(writes, WRITERS) == []


def test_nobody_may_write_who_does_not(writes: list[Write]) -> None:
    """What has no reason any more leaves the table."""
    for target, names in WRITERS.items():
        those = [write for write in writes if f"{write.target}.".startswith(f"{target}.")]
        assert [name for name in names if not any(write.by([name]) for write in those)] == [], target


def test_the_owners_are_those_of_the_workspace() -> None:
    kinds = [kind for kind in workspace.Workspace.__annotations__.values() if kind != "CompliantContacts"]
    assert tuple(kinds) == OWNERS == tuple(target for target in WRITERS if "." not in target)
    for target in WRITERS:
        owner, _, field = target.partition(".")
        declared = getattr(rows if owner == "Rows" else owners, owner)
        assert not field or field in declared.__annotations__


STRUCTS = """
@struct
class Rows:
    J: FloatArray
    n_joint: int

@struct
class Impulses:
    p: FloatArray
    solver: Solver

@struct
class Solver:
    force: FloatArray

@struct
class Workspace:
    rows: Rows
    impulses: Impulses
"""
FILL = """
def put(x: FloatArray) -> None:
    x[0] = 1.0

def put_through(y: FloatArray) -> None:
    put(y[1:])

@kernel
def fill(rows: Rows) -> None:
    rows.J[0] = 1.0
"""
READS = "p, n = work.impulses.p, work.rows.n_joint\n    q = p[n:]\n    n += 1\n    x[0] = q[0]\n    fill(work.rows)"


@pytest.mark.parametrize(
    ("line", "target"),
    [
        ("work.rows.n_joint = 1", "Rows.n_joint"),
        ("work.rows.J[0] += 1.0", "Rows.J"),
        ("p = work.impulses.p\n    p[0] = 1.0", "Impulses.p"),
        ("p, J = work.impulses.p, work.rows.J\n    J[0], p[0] = x[0], 1.0", "Impulses.p Rows.J"),
        ("p = work.impulses.p\n    p += 1.0", "Impulses.p"),
        ("rows = work.rows\n    J = rows.J[1:]\n    J[0] = 1.0", "Rows.J"),
        ("work.impulses.solver.force[0] = 1.0", "Impulses.solver"),
        (
            "group = work.impulses.solver.group\n    p = group.p\n    p[0] = 1.0",
            "Impulses.solver",
        ),  # of a solver in space
        ("put(work.rows.J)", "Rows.J"),
        ("p = work.impulses.p\n    put_through(p[2:])", "Impulses.p"),
        ("work.rows.J.fill(0.0)", "Rows.J"),
        (READS, ""),
    ],
)
@pytest.mark.parametrize("kind", ["Workspace", "SpatialWork", "Any"])
def test_a_foreign_write_is_found(line: str, target: str, kind: str) -> None:
    """In a module that may write nothing; and whoever may write is left alone."""
    imports = "from lib.fill import fill, put, put_through\n\n"
    step = f"{imports}@kernel\ndef step(work: {kind}, x: FloatArray) -> None:\n    {line}\n"
    sources = {"lib.structs": STRUCTS, "lib.fill": FILL, "other.step": step}
    may = dict.fromkeys(OWNERS, ("lib.structs",)) | {"Rows": ("lib.fill",) if not target else ()}
    writes = all_writes(sources)
    found = foreign(writes, may)
    own = [place for place in found if place.startswith("other.step")]
    assert " ".join(sorted({place.split(": ")[1].split(" ")[0] for place in own})) == target
    assert foreign(writes, {**dict.fromkeys(OWNERS, ("other",)), "Rows": ("other", "lib.fill")}) == []
    last = len(step.splitlines())
    assert not target or any(f"line {last}:" in place for place in own)
