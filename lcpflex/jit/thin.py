"""Kernels that call others instead of taking their code in: thin linking.

Numba copies the code of all that a function calls into it, optimises it again and stores it again: with kernels in ten
floors, the code of the lowest is compiled ten times. Here a callee of more than ``LARGEST`` instructions is declared
and called; the smaller ones are taken in, so that loops over them are optimised as before. LLVM may still call one of
these, where it has two callers or is large: kernels that are declared as inline are copied wherever they are used.

The symbols of a kernel hold its key (:mod:`lcpflex.jit.keys`) in place of numba's counter, so that the machine code of
one process fits that of another. All other functions of a module, which have such counters, are local to it.
"""

from __future__ import annotations

from typing import Any

from llvmlite import binding as llvm
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_lock import require_global_compiler_lock
from numba.core.environment import lookup_environment

from lcpflex.jit.keys import key_of

__all__ = ["PROCESS", "InlineCompiler", "ThinCompiler", "ThinLibrary", "late_calls"]

LARGEST = 700  # instructions of a callee that is taken in
ENVIRONMENT = "_ZN08NumbaEnv"  # how the places of Python constants begin
LATE = ".numba.unresolved$"  # calls in a circle: addresses of this process
PROCESS = "numba.dynamic.globals"  # a symbol that begins so keeps numba from storing what is linked with it

late_calls: dict[str, str] = {}  # of late kernels, by the kernels of this process: what is called (lcpflex.jit.late)


class ThinLibrary(JITCodeLibrary):  # type: ignore[misc]
    """The code of one kernel.

    Attributes
    ----------
    key
        Of the kernel.
    big
        Whether callers call it.
    symbols
        The functions by which it is called.
    needs
        The functions of other kernels that it calls, and their keys.
    late
        Its calls of late kernels.
    kept
        Whether its code holds for other processes.
    """

    def __init__(self, codegen: Any, name: str, key: str, small: bool = True, inline: bool = False) -> None:
        super().__init__(codegen, name)
        self.enable_object_caching()
        self.key = key
        self.big = False
        self.symbols: tuple[str, ...] = ()
        self.needs: dict[str, str] = {}
        self.late: set[str] = set()
        self.kept = True
        self._takes_in = small  # whether small callees are taken in
        self._inline = inline  # whether callers copy its code

    def finalize(self) -> None:
        """Link, optimise and compile, as numba does, but for the callees that are called."""
        require_global_compiler_lock()
        self._codegen._check_llvm_bugs()
        self._raise_if_finalized()
        own = {value.name for value in _defined(self._final_module)}
        self.symbols = tuple(function.name for function in self._final_module.functions if function.name in own)
        outside = self._link()
        self._optimize_final_module()
        self._make_local(own)
        self._final_module.verify()
        declared = [function.name for function in self._final_module.functions if function.is_declaration]
        self.needs = {name: outside[name] for name in declared if name in outside}
        if self._inline:
            self._ask_for_copies()
        else:
            self.big = sum(str(function).count("\n  ") for function in self._final_module.functions) > LARGEST
        self._finalize_final_module()
        self.kept &= not self._dynamic_globals

    def _link(self) -> dict[str, str]:
        """Take in what is small; the symbols of the rest, with the keys of their kernels."""
        outside: dict[str, str] = {}
        for library in dict.fromkeys(self._linking_libraries):
            self._reload_init.update(library._reload_init)
            if not isinstance(library, ThinLibrary):
                self._final_module.link_in(library._get_module_for_linking(), preserve=True)
            elif library.big or not self._takes_in:
                outside.update(dict.fromkeys(library.symbols, library.key))
            else:
                outside.update(library.needs)
                self.late |= library.late
                self._final_module.link_in(library.linkable(), preserve=True)
        return outside

    def _ask_for_copies(self) -> None:
        """Have LLVM copy its functions wherever it meets a call of them."""
        for name in self.symbols:
            self._final_module.get_function(name).add_function_attribute("alwaysinline")

    def _make_local(self, own: set[str]) -> None:
        """Take the names from all but its own symbols: another process may have given them to other functions.

        Private functions have no name in the object code. Internal ones have one, and the engine would take them for
        the kernel of that name, though LLVM has fitted them to their one caller, down to the arguments.
        """
        for value in _defined(self._final_module):
            name = value.name
            if name.startswith(ENVIRONMENT):
                environment = lookup_environment(name)
                if environment is not None and environment.consts:  # found by its name: it stays visible
                    self.kept = False
                    continue
            if name.startswith(LATE):
                self.kept = False
            elif name not in own and not name.startswith((PROCESS, "llvm.")):
                value.linkage = "private"

    def linkable(self) -> Any:
        """The module that callers of the package take in."""
        return super()._get_module_for_linking()

    def _get_module_for_linking(self) -> Any:
        """The module that callers of other packages take in.

        If it calls kernels that are not in it, numba must not store these callers: they would look for symbols that
        nobody has loaded, or for late kernels that nobody has told of.
        """
        self._ensure_finalized()
        if not self.big and not self.needs and not self.late:
            return self.linkable()
        marked = llvm.parse_assembly(
            f'target triple = "{self._codegen._llvm_module.triple}"\n'
            f'target datalayout = "{self._codegen._data_layout}"\n'
            f'@"{PROCESS}.{self.key}" = weak_odr global i8 0\n'
        )
        if not self.big:
            marked.link_in(self.linkable(), preserve=True)
        return marked


def _defined(module: Any) -> list[Any]:
    """Functions and variables that a module defines for others."""
    values = [*module.functions, *module.global_variables]
    local = (llvm.Linkage.internal, llvm.Linkage.private)
    return [value for value in values if not value.is_declaration and value.linkage not in local]


class ThinCompiler(CompilerBase):  # type: ignore[misc]
    """Numba's compiler with the library above, for kernels that have a key."""

    inline = False

    def define_pipelines(self) -> list[Any]:
        """The usual pipeline, without functions for callers in C and Python: they are made when Python asks."""
        state = self.state
        codegen = state.targetctx.codegen()
        key = key_of(state.func_id.func, state.args, state.return_type, codegen.magic_tuple(), LARGEST)
        if key is not None:
            state.library = ThinLibrary(codegen, state.func_id.func_qualname, key, inline=self.inline)
            state.func_id.unique_id = int(key[:15], 16)  # the same symbols in every process
            state.flags.no_cpython_wrapper = True
        return [DefaultPassBuilder.define_nopython_pipeline(state)]


class InlineCompiler(ThinCompiler):
    """The same for kernels whose code is copied into each caller."""

    inline = True
