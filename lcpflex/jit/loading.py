"""Kernels of files in the engine that runs them, and kernels of the engine as files.

A kernel that was linked thinly calls others by their symbols. LLVM ends the process where one of them is missing, so
all that a kernel needs is read and looked up before any of it is handed over.
"""

from __future__ import annotations

import pickle
from collections.abc import Callable
from typing import Any

from llvmlite import binding as llvm
from numba.core.compiler import CompileResult, compile_result
from numba.core.compiler_lock import global_compiler_lock
from numba.core.serialize import dumps

from lcpflex.jit.kernel_file import KernelFile
from lcpflex.jit.thin import ThinLibrary, late_calls

__all__ = ["bring_in", "entry_of", "file_of", "overload"]

_present: dict[str, KernelFile | None] = {}  # the kernels of the engine; None for those that are of this process only


def file_of(library: ThinLibrary, entry: bytes = b"") -> KernelFile | None:
    """A kernel that was compiled here, as a file; None where it holds addresses of this process.

    It counts as present from then on.
    """
    module = library._final_module
    values = [*module.functions, *module.global_variables]
    declared = {value.name for value in values if value.is_declaration and not value.name.startswith("llvm.")}
    local = (llvm.Linkage.internal, llvm.Linkage.private)
    file = None
    if library.kept:
        file = KernelFile(
            key=library.key,
            big=library.big,
            symbols=library.symbols,
            needs=library.needs,
            late={call: late_calls[call] for call in sorted(library.late)},
            outside=tuple(sorted(declared - set(library.needs))),
            defined=tuple(v.name for v in values if not v.is_declaration and v.linkage not in local),
            code=library._get_compiled_object(),
            entry=entry,
        )
    _present[library.key] = file
    return file


def entry_of(result: CompileResult) -> bytes:
    """What a caller that is compiled must know of a kernel."""
    library, descriptor = result.library, result.fndesc
    descriptor.typemap = descriptor.calltypes = None  # as numba: not needed any more, and not to be stored
    code = None if library.big else library.linkable().as_bitcode()
    entry: bytes = dumps((library.name, descriptor, result.environment, result.signature, result.reload_init, code))
    return entry


def bring_in(key: str, read: Callable[[str], KernelFile | None]) -> KernelFile | None:
    """Put the code of a kernel and of all that it calls into the engine.

    None, and nothing is put there, where a file or a symbol is missing.
    """
    from numba.core.registry import cpu_target

    found: dict[str, KernelFile] = {}
    waiting = [key]
    while waiting:
        name = waiting.pop()
        if name in found or name in _present:
            continue
        file = read(name)
        if file is None or not all(map(llvm.address_of_symbol, file.outside)):
            return None
        found[name] = file
        waiting += file.needs.values()
    with global_compiler_lock:
        engine = cpu_target.target_context.codegen()._engine
        for file in found.values():
            engine._ee.add_object_file(llvm.ObjectFileRef.from_data(file.code))
            engine._defined_symbols.update(file.defined)
            late_calls.update(file.late)
        engine.finalize_object()  # when all are in: here the symbols are looked up
        _present.update(found)
    return _present[key]


def overload(key: str, read: Callable[[str], KernelFile | None], context: Any) -> CompileResult | None:
    """The kernel of a key as numba has it after compiling; None where it is not to be had.

    Raises
    ------
    Exception
        Of any kind, for an entry that cannot be unpickled: types of a module that is gone.
    """
    file = _present.get(key) or read(key)
    if file is None or not file.entry:
        return None
    name, descriptor, environment, signature, reload_init, code = pickle.loads(file.entry)
    for prepare in reload_init:
        prepare()
    if bring_in(key, read) is None:
        return None
    library = LoadedLibrary(context.codegen(), name, file, code)
    return compile_result(
        target_context=context,
        typing_context=context.typing_context,
        library=library,
        environment=environment,
        entry_point=context.get_executable(library, descriptor, environment),
        fndesc=descriptor,
        signature=signature,
        objectmode=False,
        lifted=(),
        reload_init=reload_init,
        referenced_envs=[],
    )


class LoadedLibrary(ThinLibrary):
    """A kernel that came from a file; what callers take in is read when the first one is compiled."""

    def __init__(self, codegen: Any, name: str, file: KernelFile, code: bytes | None) -> None:
        super().__init__(codegen, name, file.key)
        self.big = file.big
        self.symbols = file.symbols
        self.needs = file.needs
        self.late = set(file.late)
        self._shared_module: Any = None
        self._code = code
        self._finalized = True
        self._disable_inspection = True

    def linkable(self) -> Any:
        """The module that callers of the package take in."""
        if self._shared_module is None:
            self._shared_module = llvm.parse_bitcode(self._code)
        return self._shared_module
