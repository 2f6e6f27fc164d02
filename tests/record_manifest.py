"""Write ``lcpflex/jit/manifest.json`` anew: which kernels each kind of run compiles, and for which types.

    python tests/record_manifest.py

Each case of the warm-up that is the first one of its kind runs in a process of its own with an empty cache; all others
follow in one process with what these have compiled, and what is new there goes under "more". Listed are the kernels
that Python calls, and those that have taken at least ``LEAST`` bytes of bytecode with what they call: half a second.
To be run when kernels or structs have changed: tests/unit/jit/test_background.py tells when too much has.
"""

from __future__ import annotations

import json
import os
import pickle
import pkgutil
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from importlib import import_module
from pathlib import Path
from typing import Any

LEAST = 2000  # bytes of bytecode; 1000 take a quarter of a second to compile


def compiled_in(names: list[int], target: str) -> None:
    """In a process of its own: run these cases of the warm-up, and keep what is compiled."""
    from lcpflex import gallery
    from lcpflex.jit.cache import KernelCache
    from lcpflex.jit.late import compile_all
    from lcpflex.runs.simulate import simulate

    found: list[tuple[str, str, Any, bool, int]] = []
    begun: list[int] = []
    load, save = KernelCache.load_overload, KernelCache.save_overload

    def load_overload(self: Any, sig: Any, context: Any) -> Any:
        loaded = load(self, sig, context)
        if loaded is None:
            begun.append(len(found))
        return loaded

    def save_overload(self: Any, sig: Any, data: Any) -> None:
        save(self, sig, data)
        function, first = self._py_func, begun.pop()
        size = len(function.__code__.co_code) + sum(entry[4] for entry in found[first:] if entry[3])
        for at in range(first, len(found)):  # they are part of this one from now on
            found[at] = (*found[at][:3], False, found[at][4])
        found.append((function.__module__, function.__qualname__, tuple(sig), True, size))

    KernelCache.load_overload, KernelCache.save_overload = load_overload, save_overload  # type: ignore[method-assign]
    cases = gallery.warmup_cases()
    for name in names:
        simulate(cases[name].build(), cases[name].duration, cases[name].stepper, progress=False, project=True)
    if len(names) > 1:
        compile_all()
    listed = [entry[:3] for entry in found if entry[3] or entry[4] >= LEAST]
    Path(target).write_bytes(pickle.dumps(listed))


def record(names: list[int], cache: Path) -> list[tuple[str, str, Any]]:
    """What these cases compile with the kernels of a folder."""
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "found"
        environment = {**os.environ, "LCPFLEX_CACHE_PATH": str(cache), "LCPFLEX_COMPILERS": "1"}
        job = [sys.executable, __file__, "--cases", json.dumps(names), str(target)]
        subprocess.run(job, env=environment, check=True)
        listed: list[tuple[str, str, Any]] = pickle.loads(target.read_bytes())
        return listed


def modules_of_leaves() -> list[str]:
    """All modules of the package that give a kernel to a leaf, but for those in space, which leaves load themselves."""
    import lcpflex
    from lcpflex.jit.leaf import Leaf

    for found in pkgutil.walk_packages(lcpflex.__path__, "lcpflex."):
        if not found.name.endswith("__main__"):
            import_module(found.name)
    loaded = [vars(module) for name, module in sys.modules.items() if name.startswith("lcpflex.")]
    leaves = [value for names in loaded for value in names.values() if isinstance(value, Leaf)]
    return sorted({kernel.__module__ for leaf in leaves for kernel in leaf.kernels.values()})


def main() -> None:
    """Record all kinds and write the list."""
    from lcpflex import gallery
    from lcpflex.jit.manifest import FILE, Types
    from lcpflex.runs.simulate import kind_of_run

    first_ones: dict[str, int] = {}
    for at, case in enumerate(gallery.warmup_cases()):
        if kind := kind_of_run(case.build(), case.stepper):
            first_ones.setdefault(kind, at)
    rest = sorted(set(range(len(gallery.warmup_cases()))) - set(first_ones.values()))
    types = Types({})
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(os.cpu_count()) as pool:
        jobs = [pool.submit(record, [first], Path(folder) / str(first)) for first in first_ones.values()]
        runs = {kind: job.result() for kind, job in zip(first_ones, jobs, strict=True)}
        known = os.pathsep.join([f"{folder}/more", *(f"{folder}/{first}" for first in first_ones.values())])
        runs["more"] = record(rest, Path(known))
    told = {}
    for kind, entries in runs.items():
        told[kind] = []
        for module, name, arguments in entries:
            try:
                told[kind].append(" ".join([f"{module}:{name}", *map(types.told, arguments)]))
            except ValueError as error:
                print(f"left out: {module}.{name} with {error}")
        print(f"{kind}: {len(told[kind])} listed")
    known = {"runs": told, "structs": types.structs, "modules": modules_of_leaves()}
    FILE.write_text(json.dumps(known, indent=1) + "\n")


if __name__ == "__main__":
    if sys.argv[1:2] == ["--cases"]:
        compiled_in(json.loads(sys.argv[2]), sys.argv[3])
    else:
        main()
