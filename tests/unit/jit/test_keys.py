"""What the key of a kernel knows of the code and the values that it depends on."""

from __future__ import annotations

import importlib
import pkgutil
import subprocess
import sys
import types
from collections import namedtuple
from typing import Any

import numba
import pytest

import lcpflex
from lcpflex.jit.keys import content, key_of

pytestmark = pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="there are no kernels")

MAGIC = ("x86_64-unknown-linux-gnu", "x86-64", "")
SOURCE = """
import math
from enum import IntEnum
from typing import NamedTuple
import numpy as np
from lcpflex.jit.kernel import kernel

FACTOR = 2.0
SIZES = (1, 2)
TABLE = np.array([1.0, 2.0])

class Status(IntEnum):
    DONE = 0
    FAILED = 1

class Point(NamedTuple):
    x: float
    y: float = 5.0

@kernel
def low(x, tolerance=1e-3):
    'What low does.'
    return math.sin(x) + sum([tolerance * k for k in (1, 2, 3)])

@kernel
def high(x):
    if x > FACTOR:
        return float(Status.FAILED)
    return low(x) + SIZES[0] + TABLE[1] + Point(x).y  # all of it

@kernel
def other(x):
    return 7.0 * x
"""


def module(source: str) -> types.ModuleType:
    """A module of the package with this source."""
    made = types.ModuleType("lcpflex.tiny_keys")
    made.__dict__["__name__"] = made.__name__
    sys.modules[made.__name__] = made  # classes look for it
    try:
        exec(compile(source, "tiny_keys.py", "exec"), made.__dict__)
    finally:
        del sys.modules[made.__name__]
    return made


def contents(source: str) -> list[str]:
    """Of the three kernels of such a source."""
    made = module(source)
    return [content(function.py_func) for function in (made.low, made.high, made.other)]


def test_a_profiler_changes_no_key() -> None:
    """To show a kernel to a profiler, numba clears flags of its code: kernels would be compiled once more."""
    job = (
        "import cProfile; from lcpflex.jit import keys\n"
        "from lcpflex.kinematics.spatial.rotations import exponential as kernel\n"
        "known = keys.content(kernel.py_func); keys._own.cache_clear(); keys.content.cache_clear()\n"
        "flags = kernel.py_func.__code__.co_flags; kernel(0.1, 0.2, 0.3)\n"
        "cProfile.Profile().runcall(kernel, 0.1, 0.2, 0.3)\n"
        "assert kernel.py_func.__code__.co_flags != flags, 'numba leaves them alone now: the mask may go'\n"
        "assert keys.content(kernel.py_func) == known"
    )
    ran = subprocess.run([sys.executable, "-c", job], capture_output=True, text=True)
    assert ran.returncode == 0, ran.stderr


EDITS = {  # which of the three kernels change with it
    "a callee": ("math.sin(x)", "math.cos(x)", (True, True, False)),
    "a number in it": ("in (1, 2, 3)", "in (1, 2, 4)", (True, True, False)),
    "its default value": ("tolerance=1e-3", "tolerance=1e-4", (True, True, False)),
    "a constant": ("FACTOR = 2.0", "FACTOR = 3.0", (False, True, False)),
    "the type of a constant": ("FACTOR = 2.0", "FACTOR = 2", (False, True, False)),
    "the sign of zero": ("FACTOR = 2.0", "FACTOR = -0.0", (False, True, False)),
    "a tuple": ("SIZES = (1, 2)", "SIZES = (3, 2)", (False, True, False)),
    "an array": ("[1.0, 2.0]", "[1.0, 4.0]", (False, True, False)),
    "a member of an enumeration": ("FAILED = 1", "FAILED = 2", (False, True, False)),
    "a field that is left out": ("y: float = 5.0", "y: float = 6.0", (False, True, False)),
    "the order of fields": ("x: float", "z: float", (False, True, False)),
    "the caller": ("Point(x).y", "Point(2.0 * x).y", (False, True, False)),
    "another kernel": ("7.0 * x", "8.0 * x", (False, False, True)),
    "a docstring": ("What low does", "What it does", (False, False, False)),
    "a comment": ("# all of it", "# nearly all\n\n", (False, False, False)),
    "lines above": ("FACTOR = 2.0", "\n\nFACTOR = 2.0", (False, False, False)),
}


@pytest.mark.parametrize("edit", EDITS)
def test_edits(edit: str) -> None:
    """A kernel has another key when its own code changed, or what it reaches; else the same."""
    old, new, expected = EDITS[edit]
    assert SOURCE.count(old) == 1
    before, after = contents(SOURCE), contents(SOURCE.replace(old, new))
    assert tuple(one != other for one, other in zip(before, after, strict=True)) == expected
    assert contents(SOURCE) == before


def test_types_of_arguments() -> None:
    """The name that numba gives to a named tuple is without its fields, also in another tuple."""
    function = module(SOURCE).other.py_func
    fields = "x y", "y x"
    kinds: list[Any] = [numba.types.NamedUniTuple(numba.float64, 2, namedtuple("Pair", names)) for names in fields]
    kinds += [numba.types.Tuple((kind, numba.float64)) for kind in kinds]
    kinds += [numba.float64, numba.int64, numba.types.UniTuple(numba.float64, 2)]
    keys = [key_of(function, [kind], None, MAGIC, 400) for kind in kinds]
    assert None not in keys
    assert len(set(keys)) == len(keys)
    assert keys == [key_of(function, [kind], None, MAGIC, 400) for kind in kinds]


def test_what_has_no_key() -> None:
    """Functions of others, closures, and what names things that no other process can compare."""
    known = module(SOURCE)
    assert key_of(known.high.py_func, [numba.float64], None, MAGIC, 400) is not None
    for value in ("object()", "print", "__import__('lcpflex.errors')", "__import__('os').path.join"):
        strange = module(SOURCE.replace("FACTOR = 2.0", f"FACTOR = {value}"))
        found = key_of(strange.high.py_func, [numba.float64], None, MAGIC, 400)
        assert (found is None) == (value != "print"), value
    factor = 2.0

    def closure(x: float) -> float:
        return factor * x

    closure.__module__ = "lcpflex.mine"
    assert key_of(closure, [numba.float64], None, MAGIC, 400) is None
    closure.__qualname__ = "closure"
    assert key_of(closure, [numba.float64], None, MAGIC, 400) is None
    assert key_of(test_what_has_no_key, [], None, MAGIC, 400) is None


def test_every_kernel_of_the_package_has_one() -> None:
    """Else it would be compiled in each process."""
    for found in pkgutil.walk_packages(lcpflex.__path__, "lcpflex."):
        if not found.name.endswith("__main__"):
            importlib.import_module(found.name)
    modules = [module for name, module in list(sys.modules.items()) if name.split(".")[0] == "lcpflex" and module]
    kernels = {id(value): value for module in modules for value in vars(module).values() if hasattr(value, "py_func")}
    assert len(kernels) > 300
    for function in kernels.values():
        assert key_of(function.py_func, [], None, MAGIC, 400) is not None, function
