"""Tests: where each stands, and how they are shared between processes.

unit/<room>  one room of lcpflex or of solvers, by the name of its folder
contract     what every solver owes, whichever it is
analytic     motions against closed forms and published numbers
convergence  rates, of steps, tolerances, modes and meshes
property     random scenes, problems and calls (fuzz), judged by what must always hold
failures     where methods fail: each such scene, and a method that gets it right
benchmarks   ratios of speeds; not collected by a plain ``pytest``
comparison   what ``tests/compare.py`` is made of, which compares two checkouts scene by scene; no tests

Between processes: file by file, because fixtures are dear; examples one by one.
"""

from __future__ import annotations

import gc
import logging
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

# Read when numpy is loaded, which no plugin does before. Processes share the cores, and threads of BLAS that wait for
# work of small eigenproblems take them away from each other: nine tenths of the time of test_reductions.py.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# Where no bytecode is to lie beside the sources, it goes to pytest's own cache: to read and rewrite four hundred files
# anew takes each process five seconds, two thirds of collecting.
if sys.dont_write_bytecode and sys.pycache_prefix is None:
    sys.pycache_prefix = str(Path(__file__).parents[1] / ".pytest_cache" / "bytecode")
    sys.dont_write_bytecode = False

# Processes that run tests share the cores; what they need is compiled before they begin.
COMPILERS = os.environ.get("LCPFLEX_COMPILERS")
os.environ.setdefault("LCPFLEX_COMPILERS", "1")

# What the list of kernels does not have, every process compiles that no other one has finished: each of these files
# needs one stepper alone.
FIRST = (
    "tests/analytic/test_event_driven_closed_forms.py",
    "tests/unit/steppers/test_moreau_jean.py",
    "tests/unit/force_laws/test_elastic_laws.py",
    "tests/unit/steppers/test_generalized_alpha.py",
    "tests/unit/steppers/test_massless_compliance.py",
    "tests/unit/force_laws/test_dissipation.py",
)


@pytest.hookimpl(tryfirst=True)
def pytest_sessionstart(session: pytest.Session) -> None:
    """Kernels for all processes, once, in two processes, where the whole suite is to be run in several."""
    config = session.config
    chosen = config.option.collectonly or config.option.keyword or config.getoption("lf", False)
    whole = config.args_source is config.ArgsSource.TESTPATHS and not chosen
    several = getattr(config.option, "numprocesses", None) and not hasattr(config, "workerinput")
    if not several or not whole or os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0"):
        return
    print("compiling what is not compiled yet ...", flush=True)
    environment = {**os.environ, "LCPFLEX_COMPILERS": COMPILERS or "2"}  # nothing else runs yet
    bars = None if sys.stderr.isatty() else subprocess.DEVNULL
    subprocess.run([sys.executable, "-m", "lcpflex", "warmup"], env=environment, stderr=bars)


LOADED = pytest.StashKey[set[str]]()


def pytest_collection(session: pytest.Session) -> None:
    """Collected tests stay: to look for what of them is garbage takes a third of the collection."""
    session.config.stash[LOADED] = set(sys.modules)
    gc.disable()


def pytest_collection_finish(session: pytest.Session) -> None:
    session.config.stash[LOADED] = set(sys.modules) - session.config.stash[LOADED]
    gc.freeze()
    gc.enable()


@pytest.fixture(scope="session")
def loaded_by_collecting(pytestconfig: pytest.Config) -> set[str]:
    """Names of the modules that the files of tests load, all of those that are collected with this one."""
    return pytestconfig.stash[LOADED]


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """``--dist loadfile`` but for the examples, which would be the longest file; the smallest pieces are run last."""
    if config.getvalue("dist") != "loadfile":
        return None
    from xdist.scheduler import LoadFileScheduling

    class Scheduling(LoadFileScheduling):
        ordered = False

        def _split_scope(self, nodeid: str) -> str:
            return nodeid if "test_examples.py" in nodeid else super()._split_scope(nodeid)

        def _assign_work_unit(self, node: Any) -> None:
            if not self.ordered:
                self.ordered = True
                for scope in reversed(FIRST):
                    if scope in self.workqueue:
                        self.workqueue.move_to_end(scope, last=False)
            super()._assign_work_unit(node)

    return Scheduling(config, log)


@pytest.fixture
def always(monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture) -> pytest.LogCaptureFixture:
    """Words of progress: a line is due whenever somebody looks."""
    from lcpflex.basics import progress  # when the environment of this process is set

    monkeypatch.setattr(progress, "EVERY", 0.0)
    monkeypatch.setattr(progress, "now", lambda: 0.0)
    caplog.set_level(logging.INFO, "lcpflex")
    return caplog
