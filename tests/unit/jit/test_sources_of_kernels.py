"""What the key of a kernel knows of the sources it depends on, over the whole package."""

from __future__ import annotations

import importlib
import pkgutil
import sys

import numba
import pytest

import lcpflex
from lcpflex.jit.dispatch import callees
from lcpflex.jit.keys import source_of, sources_of

pytestmark = pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="there are no kernels")


def test_every_kernel_knows_the_sources_of_those_it_calls() -> None:
    """Else an edit would leave old code in place: each callee's file is among those that the caller's imports reach."""
    for module in pkgutil.walk_packages(lcpflex.__path__, "lcpflex."):
        if not module.name.endswith("__main__"):
            importlib.import_module(module.name)
    modules = [module for name, module in list(sys.modules.items()) if name.split(".")[0] == "lcpflex" and module]
    kernels = {id(value): value for module in modules for value in vars(module).values() if hasattr(value, "py_func")}
    assert len(kernels) > 300
    for function in kernels.values():
        source = source_of(function.py_func)
        assert source is not None, function
        known = sources_of(source)
        for called in callees(function).values():
            own = source_of(getattr(called, "py_func", called))
            assert own is None or own in known, (function, called)
