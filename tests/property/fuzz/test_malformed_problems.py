"""Malformed problems: each is refused with its argument's name in a short message, or is a sound problem after all."""

from __future__ import annotations

import collections
import contextlib

import numpy as np
import pytest

from lcpflex import solvers
from lcpflex.errors import ModelError
from tests.property.fuzz.judge import ending_of, limited_memory
from tests.property.fuzz.malformed import attempts


def plain(value):
    """Whether an argument is what a problem of real numbers can be made of."""
    if value is None or isinstance(value, (float, int)) or hasattr(value, "tocsr"):
        return True
    array = np.asarray(value)
    return not isinstance(value, np.ma.MaskedArray) and (array.dtype.kind in "iuf" or not array.size)


def judged(seed, count):
    """How many ended how; and what is wrong."""
    ends, wrong = collections.Counter(), []
    for label, kind, arguments in attempts(seed, count):
        made = []

        def call(kind=kind, arguments=arguments, made=made):
            problem = kind(**arguments)
            made.append(problem)
            if kind is solvers.SpatialContactProblem:
                problem.residual(np.zeros(problem.size))
            return solvers.Auto().solve(problem)

        end = ending_of(call, "")
        ends[end.kind] += 1
        named = any(name in end.said for name in arguments)
        if end.kind == "result":
            for name, value in arguments.items():
                if name not in ("keys", "free") and not plain(value):
                    wrong.append((kind.__name__, label, f"accepted {name}"))
        elif end.kind != "refused" or not named:
            wrong.append((kind.__name__, label, end))
    return ends, wrong


@pytest.fixture(scope="module", autouse=True)
def compiled():
    """All kernels that these problems need, so that no call has to wait for them."""
    for _, kind, arguments in attempts(0, 500):
        with contextlib.suppress(ModelError):
            solvers.Auto().solve(kind(**arguments))


def check(seed, count):
    with limited_memory():
        ends, wrong = judged(seed, count)
    print(f"{count} problems: {dict(ends)}, {len(wrong)} wrong")
    assert not wrong, wrong[:20]
    assert ends["refused"] > 0.4 * count
    assert ends["result"] > 0.05 * count


def test_malformed_problems_are_refused_by_name():
    check(1, 1500)


@pytest.mark.slow
def test_many_malformed_problems():
    check(2, 15_000)


@pytest.mark.campaign
@pytest.mark.parametrize("seed", range(10, 20))
def test_a_hundred_thousand_malformed_problems(seed):
    check(seed, 10_000)
