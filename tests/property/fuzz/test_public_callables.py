"""Every public callable with every argument replaced by strange values: a sound result, or an error that helps.

What must hold of each call: it ends within ten seconds, in a result that such a value can have, or in a LcpflexError
that names an argument of the call and says what was expected in less than 500 characters. What does not is in ``KNOWN``
(tests/property/fuzz/known.py), each entry of which is tried: one that has been mended must go from there.
"""

from __future__ import annotations

import collections
import inspect
import random

import pytest

import lcpflex as lf
from lcpflex import gallery, laws, meshes, solvers, studies
from lcpflex.checks import resolution_rules as advice
from tests import libs
from tests.property.fuzz.bad_values import NUMBERS, WRONG
from tests.property.fuzz.callables import INTERNAL, OUTPUTS, PLAIN, SLOW, faces
from tests.property.fuzz.judge import ending_of, limited_memory
from tests.property.fuzz.known import ADMITTED, ARRAYS, KNOWN, NUMBERS_OF_LAWS, TAKEN

VALUES = {**WRONG, **NUMBERS}
OF_SLOW = 5  # of a hundred calls in the default and the slow test, so many are of callables that take long


def annotation(face, argument):
    """The annotation of an argument, as text."""
    return str(inspect.signature(face.function).parameters[argument].annotation)


def may_take(face, argument, label):
    """Whether a result is what such a value can have: numbers and what the annotation or ``TAKEN`` admits."""
    if face.name.endswith(".refuses"):  # it says why in a sentence
        return True
    if face.name.split(".")[-1] in NUMBERS_OF_LAWS and label in ARRAYS:
        return True
    if label in NUMBERS or label in TAKEN.get((face.name, argument), ()):
        return True
    told = annotation(face, argument)
    return any(part in told and label in labels for part, labels in ADMITTED.items())


def wrong_ending(face, argument, label):
    """How it ended, and what is wrong with that; empty if nothing is."""
    make = VALUES[label]
    with limited_memory():
        end = ending_of(lambda: face.call(**{argument: make()}), argument, [*face.parameters(), argument.rstrip("s")])
    libs.plt.close("all")
    if end.kind == "result":
        return end.kind, "" if may_take(face, argument, label) else "a result"
    return end.kind, "" if end.kind == "refused" else f"{end.kind}: {end.said}"


def tried(cases):
    """How many calls ended how, and those that did so wrongly and are not known to."""
    ends, wrong = collections.Counter(), []
    for face, argument, label in cases:
        kind, trouble = wrong_ending(face, argument, label)
        ends[kind] += 1
        if trouble and (face.name, argument) not in KNOWN:
            wrong.append((face.name, argument, label, trouble))
    print(f"{len(cases)} calls: {dict(ends)}, {len(wrong)} wrong that are not known")
    return wrong


def combinations(slow):
    """All of the quick callables, or of the slow ones."""
    return [
        (face, argument, label)
        for face in faces()
        if (face.name in SLOW) == slow
        for argument in face.parameters()
        for label in VALUES
    ]


def sample(seed, count):
    """So many calls, the greater part of quick callables."""
    rng = random.Random(seed)
    few = count * OF_SLOW // 100
    return rng.sample(combinations(False), count - few) + rng.sample(combinations(True), few)


@pytest.fixture(autouse=True)
def somewhere(tmp_path, monkeypatch):
    """Files that are written go to a folder of the test."""
    monkeypatch.chdir(tmp_path)
    libs.mpl.use("Agg")


def test_every_public_callable_is_in_the_table():
    names = {face.name for face in faces()}
    heads = {name.split(".")[-1] for name in names} | {name.split(".")[0] for name in names} | names
    for module in (lf, solvers, studies, laws, meshes, advice, gallery):
        for name in module.__all__:
            if inspect.ismodule(getattr(module, name)):
                continue  # its own names are looked at
            assert name in heads | OUTPUTS | PLAIN, f"{module.__name__}.{name}"


def test_every_public_method_is_in_the_table():
    names = {face.name for face in faces()}
    for module in (lf, solvers, studies, laws, meshes, advice):
        for kind in (getattr(module, name) for name in module.__all__ if name not in PLAIN):
            for name, method in inspect.getmembers(kind, inspect.isroutine) if inspect.isclass(kind) else ():
                inner = name.startswith("_") or name in INTERNAL or hasattr(BaseException, name) or hasattr(tuple, name)
                if not inner and len(inspect.signature(method).parameters) > 1:
                    assert f"{kind.__name__}.{name}" in names, f"{module.__name__}.{kind.__name__}.{name}"


def test_strange_arguments():
    rng = random.Random(1)
    wrong = tried(rng.sample(combinations(False), 300))
    assert not wrong, wrong[:10]


@pytest.mark.slow
def test_ten_thousand_strange_arguments():
    wrong = tried(sample(2, 10_000))
    assert not wrong, wrong[:10]


@pytest.mark.campaign
@pytest.mark.parametrize("name", sorted({face.name for face in faces()}))
def test_every_strange_argument_of(name):
    every = combinations(False) + combinations(True)
    wrong = tried([case for case in every if case[0].name == name])
    assert not wrong, wrong[:10]


@pytest.mark.slow
def test_what_is_known_to_fail_still_does():
    table = {face.name: face for face in faces()}
    mended = [
        (name, argument, label)
        for (name, argument), label in KNOWN.items()
        if not wrong_ending(table[name], argument, label)[1]
    ]
    assert not mended, f"take them out of tests/property/fuzz/known.py: {mended}"
