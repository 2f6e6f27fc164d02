"""The package as a user meets it: import, names, version."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

import lcpflex

HEAVY = ("numba", "scipy", "matplotlib", "skfem", "qpsolvers", "osqp", "clarabel", "meshio", "pandas", "tqdm")


def run(code: str) -> str:
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.strip()


def test_import_loads_nothing_heavy() -> None:
    loaded = run(f"import sys, lcpflex; print([name for name in {HEAVY} if name in sys.modules])")
    assert loaded == "[]"


def test_import_takes_less_than_six_tenths_of_a_second() -> None:
    clock = "import time; t = time.process_time(); import lcpflex; print(time.process_time() - t)"
    assert min(float(run(clock)) for _ in range(3)) < 0.6


def test_building_a_scene_compiles_nothing() -> None:
    scene = "import lcpflex as lf; s = lf.Scene(); s.add(lf.Disc(radius=0.1, mass=1.0), name='disc')"
    loaded = run(f"import sys; {scene}; print('numba' in sys.modules, 'matplotlib' in sys.modules)")
    assert loaded == "False False"


@pytest.mark.parametrize("name", lcpflex.__all__)
def test_every_public_name_loads_and_is_documented(name: str) -> None:
    value = getattr(lcpflex, name)
    assert name in dir(lcpflex)
    if name != "__version__":
        assert value.__doc__


@pytest.mark.parametrize("name", lcpflex.laws.__all__)
def test_every_law_loads_and_is_documented(name: str) -> None:
    assert name in dir(lcpflex.laws)
    assert getattr(lcpflex.laws, name).__doc__


def test_simulate_stays_the_function_after_its_module_is_imported() -> None:
    code = (
        "import lcpflex as lf; import lcpflex.runs.simulate; print(callable(lf.simulate), type(lf.simulate).__name__)"
    )
    assert run(code) == "True function"


def test_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="Bream"):
        _ = lcpflex.Bream  # type: ignore[attr-defined]


def test_version_agrees_with_the_packaging() -> None:
    import tomllib

    project = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert project["version"] == lcpflex.__version__


def test_packaging_lists_every_package() -> None:
    import tomllib

    root = Path(__file__).parents[2]
    listed = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["setuptools"]["packages"]
    rooms = {path.parent.relative_to(root).parts for path in (root / "lcpflex").glob("**/__init__.py")}
    solvers = {("lcpflex", *path.parent.relative_to(root).parts) for path in (root / "solvers").glob("**/__init__.py")}
    assert set(listed) == {".".join(parts) for parts in rooms | solvers}


@pytest.mark.parametrize(
    ("module", "typo", "meant"),
    [
        ("", "Bream", "Beam"),
        ("", "Simulate", "simulate"),
        ("solvers", "Lemkes", "Lemke"),
        ("laws", "Herz", "Hertz"),
        ("studies", "right_sized", "right_size"),
    ],
)
def test_unknown_name_tells_the_nearest_one(module: str, typo: str, meant: str) -> None:
    with pytest.raises(AttributeError, match=f"{typo}.*did you mean '{meant}'"):
        getattr(getattr(lcpflex, module) if module else lcpflex, typo)


@pytest.mark.parametrize("module", ["", "solvers", "studies", "laws", "gallery", "meshes", "resolution_rules"])
def test_dir_shows_public_names_only(module: str) -> None:
    package = getattr(lcpflex, module) if module else lcpflex
    shown = set(dir(package))
    assert shown >= set(package.__all__)
    assert not shown & {"sys", "Any", "ModuleType", "TYPE_CHECKING", "import_module", "annotations", "np", "math"}
    assert not [name for name in shown if name.startswith("_") and name != "__version__"]
