"""Kernels as Python has them: functions whose dispatcher is made when it is first needed."""

from __future__ import annotations

import copy
import pickle
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import numba
import pytest

from lcpflex.jit import kernel as kernels
from lcpflex.jit.kernel import Kernel, kernel
from lcpflex.kinematics.spatial import rotations
from lcpflex.steppers.scheme import set_length

pytestmark = pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="there are no kernels")


@kernel
def twice(x: float) -> float:
    """Two times x."""
    return 2.0 * x


def test_a_kernel_tells_what_it_is() -> None:
    assert (twice.__name__, twice.__doc__) == ("twice", "Two times x.")
    assert repr(twice) == f"<kernel {__name__}.twice>"
    assert twice.py_func(2.0) == 4.0  # type: ignore[attr-defined]
    assert hasattr(twice, "overloads")
    assert not hasattr(twice, "__path__")


def test_a_kernel_is_copied_and_pickled_as_itself() -> None:
    known = rotations.exponential
    assert copy.copy(known) is copy.deepcopy(known) is pickle.loads(pickle.dumps(known)) is known


def test_one_dispatcher_for_all_threads() -> None:
    made = Kernel(lambda x: x, late=False)
    with ThreadPoolExecutor(8) as pool:
        assert len({id(found) for found in pool.map(lambda _: made.made, range(32))}) == 1


def test_what_numba_lacks_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """A property that raises AttributeError looks to Python as if it were not there."""

    def broken(*_: object) -> None:
        raise AttributeError("module 'numpy' has no attribute 'bool'")

    monkeypatch.setattr(kernels, "_dispatcher", broken)
    with pytest.raises(ImportError, match=r"numba cannot be used .* no attribute 'bool'"):
        Kernel(lambda x: x, late=False)(1.0)


def test_leaves_have_a_type() -> None:
    """Also for a user's function that names one before any kernel was made."""
    assert numba.typeof(set_length).leaf is set_length


@pytest.mark.parametrize(("told", "python"), [("1", True), ("0", False), ("", False), ("false", False)])
def test_plain_functions_where_numba_does_not_compile(told: str, python: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NUMBA_DISABLE_JIT", told)
    assert isinstance(kernel(len), Kernel) is not python


def test_keys_make_no_dispatchers() -> None:
    """What a run looks up in its cache costs it nothing of numba."""
    code = (
        "import gc; import lcpflex.steppers.moreau_jean.stepper; from lcpflex.jit.kernel import Kernel\n"
        "from lcpflex.jit import keys; from lcpflex.steppers.fixed_steps import advance\n"
        "keys.content(advance.py_func, frozenset({'MoreauJeanScheme', 'Model', 'Workspace'}))\n"
        "print(sum(found._made is not None for found in gc.get_objects() if isinstance(found, Kernel)))"
    )
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert ran.stdout == "0\n", ran.stderr
