"""Old public names: each does what it did, and says once a use what it is called now."""

from __future__ import annotations

import subprocess
import sys
import warnings
from dataclasses import fields, replace
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

import lcpflex as lf
from lcpflex.basics.renamed import GOES, MODULES
from lcpflex.results.result import Result
from lcpflex.studies.model_order.report import FidelityRun

GOES_WITH = f"the old name goes with version {GOES}"


@pytest.mark.parametrize(
    ("package", "old", "new"),
    [
        ("lcpflex", "Energetic", "Stronge"),
        ("lcpflex", "advice", "resolution_rules"),
        ("lcpflex.laws", "OwnLaw", "UserLaw"),
        ("lcpflex.solvers", "OwnSolver", "UserSolver"),
        ("lcpflex.bodies", "Rung", "FidelityLevel"),
        ("lcpflex.studies", "NextRung", "NextLevel"),
        ("lcpflex.compile.compiled_scene", "Compiled", "CompiledScene"),
    ],
)
def test_classes(package: str, old: str, new: str) -> None:
    home = lf.laws if package == "lcpflex.laws" else import_module(package)
    with pytest.warns(
        DeprecationWarning, match=rf"{package}\.{old} is now called {package}\.{new}; {GOES_WITH}"
    ) as told:
        assert getattr(home, old) is getattr(home, new)
    assert told[0].filename == __file__
    assert old not in dir(home)
    assert new in home.__all__


@pytest.mark.parametrize(("old", "new"), MODULES.items())
def test_modules(old: str, new: str) -> None:
    package, _, name = old.rpartition(".")
    kept = vars(import_module(package)).get(name)
    with pytest.warns(DeprecationWarning, match=f"the module {old} is now called {new}; {GOES_WITH}"):
        assert import_module(old) is import_module(new)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        import_module(old)  # loaded by now
    sys.modules.pop(old)
    if kept is None:  # else the next test would find it where only its old name is
        vars(import_module(package)).pop(name, None)


def test_what_is_in_an_old_module_is_the_same_and_not_loaded_twice() -> None:
    """In a process of its own: also lcpflex.simulate, which is a function, and stays it."""
    program = """
import warnings
with warnings.catch_warnings(record=True) as told:
    warnings.simplefilter("always")
    from lcpflex.contact.laws.elastic.hertz import Hertz
    from lcpflex.joints import Revolute
    import lcpflex.simulate
    from lcpflex.solvers.friction import ContactProblem
import lcpflex as lf
assert Hertz is lf.laws.Hertz and Revolute is lf.Revolute and ContactProblem is lf.solvers.ContactProblem
assert lf.simulate.__module__ == "lcpflex.runs.simulate" and callable(lf.simulate)
assert [str(one.message).split()[2] for one in told] == [
    "lcpflex.contact.laws", "lcpflex.joints", "lcpflex.simulate", "lcpflex.solvers.friction"], told
assert all(one.filename == "<string>" for one in told)
try:
    import lcpflex.contact.lawsuit
except ModuleNotFoundError as error:
    print(error)
"""
    root = Path(__file__).parents[2]
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, cwd=root, check=False)
    assert done.returncode == 0, done.stderr
    assert "lcpflex.contact.lawsuit" in done.stdout


def test_the_argument_of_contacts() -> None:
    def declared(**choice: Any) -> Any:
        scene = lf.Scene()
        a, b = (scene.add(lf.Box(1.0, 1.0, mass=1.0), position=(0.0, 1.1 * k)).surface() for k in range(2))
        scene.contact(a, b, **dict.fromkeys(choice, b))
        return scene.compiled().model.contacts

    with pytest.warns(
        DeprecationWarning, match=f"the argument slave of contact is now called node_side; {GOES_WITH}"
    ) as t:
        old = declared(slave=True)
    assert t[0].filename == __file__
    new = declared(node_side=True)
    assert old.pass_node.tolist() == new.pass_node.tolist() == [1]
    with pytest.raises(lf.ModelError, match="slave: it was given beside node_side"):
        declared(slave=True, node_side=True)


def test_levels_of_a_body_written_by_hand() -> None:
    parts = {part.name: getattr(lf.Disc(0.1, mass=2.0), part.name) for part in fields(lf.bodies.Body)}
    levels = parts.pop("fidelity_levels")
    with pytest.warns(DeprecationWarning, match=f"the argument ladder of __init__ is now called .*{GOES_WITH}"):
        body = lf.bodies.Body(**parts, ladder=tuple)
    assert body.fidelity_levels is tuple
    assert levels is None
    assert replace(body, mass=3.0).fidelity_levels is tuple


def test_properties_of_results_and_studies() -> None:
    result = Result.load(Path(__file__).parent / "results" / "result_of_first_format.npz")
    run = FidelityRun({"beam": "rigid"}, 3, 10, 0.1, {})
    body = lf.Beam(1.0, 0.05, 0.01, 1000.0, 2e8).reduce(2)
    for owner, old, new in (
        (result, "spots", "contact_points"),
        (result, "by_law", "compliant"),
        (result, "all_by_law", "all_compliant"),
        (run, "rungs", "levels"),
        (body, "ladder", "fidelity_levels"),
    ):
        with pytest.warns(DeprecationWarning, match=f"{type(owner).__name__}.{old} is now called {new}; {GOES_WITH}"):
            found = getattr(owner, old)
        assert found is getattr(owner, new)
    assert isinstance(replace(result, notes=("again",)), Result)


def test_once_for_each_line() -> None:
    """By Python's usual filter, whatever the number of calls."""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("default")
        for _ in range(3):
            assert lf.Energetic is lf.Stronge
    assert len(told) == 1
