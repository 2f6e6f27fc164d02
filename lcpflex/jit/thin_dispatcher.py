"""Numba's dispatcher for kernels that are linked thinly: callable from Python once Python asks."""

from __future__ import annotations

from typing import Any

from numba.core.compiler_lock import global_compiler_lock
from numba.core.registry import CPUDispatcher

from lcpflex.basics.garbage import without_collections
from lcpflex.basics.progress import look
from lcpflex.jit import loading, thin
from lcpflex.jit.cache import KernelCache, keep, read_anywhere
from lcpflex.jit.kernel_file import KernelFile
from lcpflex.jit.keys import derived, machines
from lcpflex.jit.literals import without_literals
from lcpflex.jit.thin import InlineCompiler, ThinCompiler, ThinLibrary

__all__ = ["ThinDispatcher"]


class ThinDispatcher(CPUDispatcher):  # type: ignore[misc]
    """A kernel.

    An overload that only other kernels call has no function that takes Python objects: that would be a seventh of the
    time of compiling. The table from which C finds overloads for Python gets it when Python asks for it first.
    """

    def __init__(self, py_func: Any, targetoptions: dict[str, Any], inline: bool = False) -> None:
        compiler = InlineCompiler if inline else ThinCompiler
        super().__init__(py_func=py_func, targetoptions=targetoptions, pipeline_class=compiler)
        self._cache = KernelCache(py_func, thin.LARGEST, _load, _file_of)
        self._for_python: set[Any] = set()  # overloads that Python can call

    def add_overload(self, cres: Any) -> None:
        """Known to callers that are compiled; not yet to C, which would call a null pointer."""
        if isinstance(cres.library, ThinLibrary):
            self.overloads[tuple(cres.signature.args)] = cres
        else:
            super().add_overload(cres)

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """What a caller that is compiled must know."""
        return super().get_call_template(*without_literals(args, kws))

    def compile(self, sig: Any) -> Any:
        """The overload for argument types, by the name that callers find it under."""
        cache = self._cache
        with without_collections():
            depth = cache.depth
            try:
                return super().compile(sig)
            finally:
                cache.leave(depth)
                look()  # a run may compile for minutes

    def _compile_for_args(self, *args: Any, **kws: Any) -> Any:
        """What Python calls for these arguments."""
        with global_compiler_lock:  # also for threads that ask at the same time
            entry = super()._compile_for_args(*args, **kws)
            for types, result in list(self.overloads.items()):
                if result.entry_point is entry and types not in self._for_python:
                    if isinstance(result.library, ThinLibrary):
                        entry = self._opened(types, result)
                    self._for_python.add(types)  # not before: an interrupted one is opened again
        return entry

    def _opened(self, types: Any, result: Any) -> Any:
        """An overload with a function that takes Python objects; its name changes with that."""
        context, descriptor = result.target_context, result.fndesc
        library = _python_face(result)
        entry = context.get_executable(library, descriptor, result.environment)
        self.targetctx.insert_user_function(entry, descriptor, [result.library])
        self.overloads[types] = result._replace(entry_point=entry)
        self._insert([kind._code for kind in types], entry, False)
        return entry


def _python_face(result: Any) -> ThinLibrary:
    """The library with the function that takes Python objects and calls a kernel."""
    context, kernel, descriptor = result.target_context, result.library, result.fndesc
    codegen = context.codegen()
    keys = [derived(kernel.key, "from Python", *magic) for magic in machines(codegen.magic_tuple())]
    library = ThinLibrary(codegen, f"{descriptor.qualname} from Python", keys[0], small=False)
    for key in keys:
        if loading.bring_in(key, read_anywhere) is not None:
            return library
    context.refresh()  # boxing needs what a kernel that is kept was loaded without
    with context.push_code_library(library):  # what boxes a constant takes code in
        context.create_cpython_wrapper(library, descriptor, result.environment, None, release_gil=True)
    library.add_linking_library(kernel)
    library.finalize()
    file = loading.file_of(library)
    if file is not None:
        keep(file)
    return library


def _load(key: str, context: Any) -> Any:
    return loading.overload(key, read_anywhere, context)


def _file_of(key: str, result: Any) -> KernelFile | None:
    if not isinstance(result.library, ThinLibrary) or result.environment.consts:
        return None
    return loading.file_of(result.library, loading.entry_of(result))
