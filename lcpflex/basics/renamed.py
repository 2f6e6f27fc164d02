"""Public names that have changed: the old ones go on working for one version, and say what they are called now.

To rename something public: its old name goes into the table of its module (``renamed_name`` in the ``__getattr__`` of a
package), beside the function that takes it as a keyword (``renamed_keyword``) or into the class that has it
(``renamed_property``), a module into :data:`MODULES`; and a line into CHANGELOG.md, "Changed names".
"""

from __future__ import annotations

import functools
import sys
import warnings
from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any, TypeVar

__all__ = ["GONE", "MODULES", "OldModules", "renamed_keyword", "renamed_name", "renamed_property"]

GOES = "0.3"  # the version without the old names
MODULES = {  # and what is in them
    "lcpflex.advice": "lcpflex.checks.resolution_rules",
    "lcpflex.bodies.meshes": "lcpflex.bodies.fem.meshes",
    "lcpflex.clearances": "lcpflex.scene.clearances",
    "lcpflex.compiled": "lcpflex.compile.compiled_scene",
    "lcpflex.contact.laws": "lcpflex.force_laws",
    "lcpflex.energy": "lcpflex.results.energy_balance",
    "lcpflex.joints": "lcpflex",
    "lcpflex.loads": "lcpflex",
    "lcpflex.recorder": "lcpflex.results.problem_log",
    "lcpflex.result": "lcpflex.results.result",
    "lcpflex.simulate": "lcpflex.runs.simulate",
    "lcpflex.slots": "lcpflex.scene.slots",
    "lcpflex.summary": "lcpflex.results.summary",
    "lcpflex.solvers.files": "lcpflex.solvers.benchmark.files",
    "lcpflex.solvers.friction": "lcpflex.solvers.contact.problem",
    "lcpflex.solvers.gallery": "lcpflex.solvers.benchmark.gallery",
    "lcpflex.user_system": "lcpflex.scene.user_system",
}

GONE = {  # attributes of results, and where what they told is now
    name: f"it was a sum of local errors, and far off; result.verify() measures the error, result.error.{now}"
    for name, now in (("place_error", "place"), ("speed_error", "speed"))
}

F = TypeVar("F", bound=Callable[..., Any])


def _warn(old: str, new: str, level: int) -> None:
    """Tell the line that is ``level`` calls above this one; Python shows it once for each such line."""
    words = f"{old} is now called {new}; the old name goes with version {GOES}"
    warnings.warn(words, DeprecationWarning, stacklevel=level + 1)


def renamed_name(module: str, old: str, names: Mapping[str, str], label: str = "") -> Any:
    """What ``module``, in messages ``label``, calls ``old`` now, by the table ``names``; for its ``__getattr__``."""
    new, label = names[old], label or module
    _warn(f"{label}.{old}", f"{label}.{new}", 3)
    return getattr(import_module(module), new)


def renamed_keyword(**names: str) -> Callable[[F], F]:
    """Decorator of a function that takes keywords by their old names, too: ``@renamed_keyword(old="new")``."""

    def decorate(function: F) -> F:
        @functools.wraps(function)
        def call(*given: Any, **keywords: Any) -> Any:
            for old in names.keys() & keywords.keys():
                if names[old] in keywords:
                    from lcpflex.errors import ModelError

                    raise ModelError(f"{old}: it was given beside {names[old]}, which is its name now; expected one")
                _warn(f"the argument {old} of {function.__name__}", names[old], 2)
                keywords[names[old]] = keywords.pop(old)
            return function(*given, **keywords)

        return call  # type: ignore[return-value]

    return decorate


def renamed_property(old: str, new: str) -> property:
    """A property that gives the attribute ``new``, where ``old`` is asked for."""

    def value(self: Any) -> Any:
        _warn(f"{type(self).__name__}.{old}", new, 2)
        return getattr(self, new)

    return property(value, doc=f"The old name of ``{new}``.")


class OldModules:
    """Finds the modules that are elsewhere now, by the table MODULES.

    It is asked first: the new package would else load what is in it a second time, under the old name.
    """

    def find_spec(
        self, fullname: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        new = self._new(fullname)
        if new is None:
            return None
        if fullname in MODULES:
            _warn(f"the module {fullname}", new, 2)
        return ModuleSpec(fullname, self)  # type: ignore[arg-type]  # a loader by its methods: the class costs 5 ms

    def create_module(self, spec: ModuleSpec) -> None:
        """An empty one, which takes no part."""

    def exec_module(self, module: ModuleType) -> None:
        sys.modules[module.__name__] = import_module(str(self._new(module.__name__)))

    @staticmethod
    def _new(name: str) -> str | None:
        """The name of a module that is, or is in, one of the table."""
        for old, new in MODULES.items():
            if name == old or name.startswith(f"{old}."):
                return new + name.removeprefix(old)
        return None
