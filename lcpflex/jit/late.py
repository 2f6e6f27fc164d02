"""Kernels that are compiled when they are first called, by kernels as well: what a run does not need costs it nothing.

A kernel compiles all that it calls before it runs. A call of a late kernel is compiled without it, as that of a
function in a shared library: through a pointer, which is null at first. Then the call comes to Python, which compiles
the late kernel, or takes it from its file, and the pointer is that to the kernel from then on.
"""

from __future__ import annotations

import base64
import ctypes
import pickle
import zlib
from _thread import interrupt_main
from collections.abc import Callable
from functools import partial
from threading import Timer
from typing import Any

import llvmlite.ir
import numba.core.types
from llvmlite import binding as llvm
from numba.core import cgutils
from numba.core.typing import make_concrete_template, signature

from lcpflex.errors import LcpflexError
from lcpflex.jit.keys import derived
from lcpflex.jit.leaf import dispatcher_of
from lcpflex.jit.thin import PROCESS, ThinLibrary, late_calls
from lcpflex.jit.thin_dispatcher import ThinDispatcher

__all__ = ["LateDispatcher", "compile_all"]

ir: Any = llvmlite.ir  # without types
types: Any = numba.core.types
POINTER = ir.IntType(8).as_pointer()
WORD = 8  # bytes
SOON = 0.05  # after which Ctrl-C takes effect [s]: when compiled code goes on
RESOLVE = "lcpflex_late_kernel"  # how compiled code calls Python
NUMBERS = {"bool": types.boolean, "int": types.int64, "float": types.float64}
RESULTS = {"None": types.none, **NUMBERS}

_asked: list[bytes] = []  # calls from compiled code that wait for a kernel


class NotCompiledError(LcpflexError):
    """A late kernel could not be compiled."""

    cause: BaseException | None = None  # the last one: compiled code raises this class without arguments

    def __init__(self) -> None:
        super().__init__(f"a kernel could not be compiled: {self.cause!r}")
        self.__cause__ = self.cause


class LateDispatcher(ThinDispatcher):
    """A late kernel. What it returns is told by its annotation: None, bool, int, float, or a tuple of these three."""

    def __init__(self, py_func: Callable[..., Any], targetoptions: dict[str, Any]) -> None:
        super().__init__(py_func, targetoptions)
        self.result = _result(py_func.__annotations__["return"])
        self._calls: dict[Any, str] = {}  # argument types: the name that numba's tables have for such a call

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """What a caller that is compiled must know; asked for, an ordinary kernel is compiled."""
        names, folded = self._compiler.fold_argument_types(args, kws)
        told = signature(self.result, *map(types.unliteral, folded))
        name = self.py_func.__name__
        return make_concrete_template(f"Late({name})", key=name, signatures=[told]), names, folded, {}

    def get_overload(self, sig: Any) -> str:
        """The name of a call with these argument types, with its code in numba's tables."""
        kinds = tuple(sig)
        if kinds not in self._calls:
            asked = pickle.dumps((self.py_func.__module__, self.py_func.__name__, kinds))
            call = self._calls[kinds] = f"late.{derived(asked)}"
            late_calls[call] = base64.b64encode(zlib.compress(asked)).decode()
            self.targetctx.insert_func_defn([(partial(_call, call), call, kinds)])
        return self._calls[kinds]


def _result(told: str) -> Any:
    """The type that an annotation tells."""
    if told.startswith("tuple["):
        return types.BaseTuple.from_types([NUMBERS[part.strip()] for part in told[6:-1].split(",")])
    return RESULTS[told]


def _call(call: str, context: Any, builder: Any, told: Any, values: Any) -> Any:
    """Code of a call."""
    module, library = builder.module, context.active_code_library
    if isinstance(library, ThinLibrary):
        library.late.add(call)
    else:  # of a function of others, which no other process can take from its file: it would not know the call
        cgutils.global_constant(module, f"{PROCESS}.{call}", ir.Constant(ir.IntType(8), 0), linkage="weak_odr")
    stub = module.globals.get(call) or _stub(call, context, module, told)
    status, value = context.call_conv.call_function(builder, stub, told.return_type, told.args, values)
    with cgutils.if_unlikely(builder, status.is_error):
        context.call_conv.return_status_propagate(builder, status)
    return value


def _stub(call: str, context: Any, module: Any, told: Any) -> Any:
    """A function that passes its arguments on to the late kernel."""
    kind = context.call_conv.get_function_type(told.return_type, told.args)
    stub = ir.Function(module, kind, call)
    pointer = ir.GlobalVariable(module, POINTER, f"{call}.pointer")
    pointer.initializer = ir.Constant(POINTER, None)
    stub.linkage = pointer.linkage = "private"
    builder = ir.IRBuilder(stub.append_basic_block())
    known = builder.load_atomic(pointer, "acquire", WORD)
    with builder.if_then(cgutils.is_null(builder, known), likely=False):
        resolve = cgutils.get_or_insert_function(module, ir.FunctionType(POINTER, [POINTER]), RESOLVE)
        found = builder.call(resolve, [context.insert_const_string(module, call)])
        with builder.if_then(cgutils.is_null(builder, found), likely=False):
            context.call_conv.return_user_exc(builder, NotCompiledError)
        builder.store_atomic(found, pointer, "release", WORD)
    kernel = builder.bitcast(builder.load(pointer), kind.as_pointer())
    builder.ret(builder.call(kernel, stub.args))
    return stub


def compile_all() -> None:
    """Compile the late kernels that those of this process may call, and those that these may call."""
    done: set[str] = set()
    while waiting := set(late_calls) - done:
        for call in waiting:
            _address(call)
        done |= waiting


def _address(call: str) -> Any:
    """Of the machine code of a late kernel."""
    module, name, kinds = pickle.loads(zlib.decompress(base64.b64decode(late_calls[call])))
    dispatcher = dispatcher_of(module, name)
    dispatcher.compile(kinds)
    result = dispatcher.overloads[kinds]
    returned = result.signature.return_type
    if isinstance(returned, types.IntEnumMember):
        returned = returned.dtype  # which is the same in the machine
    if returned != dispatcher.result:
        raise TypeError(f"{module}.{name} returns {returned}, not {dispatcher.result}")
    return result.library.get_pointer_to_function(result.fndesc.llvm_func_name)


@ctypes.CFUNCTYPE(ctypes.c_void_p, ctypes.c_char_p)  # type: ignore[untyped-decorator]
def _resolve(call: bytes) -> Any:
    """What compiled code calls: the address for a name, None where there is none. Ctrl-C waits for the compiler."""
    _asked.append(call)
    interrupted = False
    try:
        while True:
            try:
                return _address(call.decode())
            except KeyboardInterrupt:
                interrupted = True
    except BaseException as error:
        NotCompiledError.cause = error
        return None
    finally:
        _asked.pop()
        if interrupted:
            Timer(SOON, _interrupt).start()


def _interrupt() -> None:
    """Pass Ctrl-C on when compiled code does not wait: what is raised in a call from there is lost."""
    if _asked:
        Timer(SOON, _interrupt).start()
    else:
        interrupt_main()


llvm.add_symbol(RESOLVE, ctypes.cast(_resolve, ctypes.c_void_p).value)
