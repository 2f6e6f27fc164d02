"""Whether the inner parts of numba that thin linking uses are those it was written for.

Thin linking (:mod:`lcpflex.jit.thin`) stands on names that numba does not promise. They are the same in the versions
that were tested; with any other, kernels are linked as numba does, which takes longer and is right.
"""

from __future__ import annotations

import importlib
from functools import cache

__all__ = ["why_not_thin"]

TESTED = {"numba": ("0.68.",), "llvmlite": ("0.50.",)}
NAMES = {
    "numba.core.caching:_Cache": "enable disable flush load_overload save_overload",
    "numba.core.codegen:JITCodeLibrary": "_optimize_final_module _finalize_final_module _get_module_for_linking "
    "_raise_if_finalized _get_compiled_object enable_object_caching get_pointer_to_function add_linking_library",
    "numba.core.codegen:JITCPUCodegen": "magic_tuple set_env _check_llvm_bugs _create_empty_module",
    "numba.core.codegen:JitEngine": "finalize_object is_symbol_defined",
    "numba.core.compiler:CompilerBase": "define_pipelines compile_extra",
    "numba.core.compiler:DefaultPassBuilder": "define_nopython_pipeline",
    "numba.core.compiler:compile_result": "",
    "numba.core.compiler_lock:global_compiler_lock": "is_locked",
    "numba.core.cpu:CPUContext": "create_cpython_wrapper get_executable insert_user_function "
    "insert_func_defn insert_const_string call_conv subtarget codegen",
    "numba.core.callconv:CPUCallConv": "call_function get_function_type return_status_propagate return_user_exc",
    "numba.core.environment:lookup_environment": "",
    "numba.core.funcdesc:PythonFunctionDescriptor": "llvm_cpython_wrapper_name llvm_func_name env_name",
    "numba.core.registry:CPUDispatcher": "add_overload compile _compile_for_args _insert "
    "get_call_template get_overload",
    "numba.core.serialize:dumps": "",
    "llvmlite.binding:ObjectFileRef": "from_data",
    "llvmlite.binding:ExecutionEngine": "add_object_file finalize_object",
    "llvmlite.binding:address_of_symbol": "",
    "llvmlite.binding:add_symbol": "",
}


@cache
def why_not_thin() -> str:
    """Why kernels cannot be linked thinly with what is installed, in words; empty where they can."""
    for package, versions in TESTED.items():
        version = importlib.import_module(package).__version__
        if not version.startswith(versions):
            return f"{package} {version} is installed, {' or '.join(f'{known}*' for known in versions)} is known"
    for place, attributes in NAMES.items():
        module, name = place.split(":")
        try:
            found = getattr(importlib.import_module(module), name)
            for attribute in attributes.split():
                getattr(found, attribute)
        except (ImportError, AttributeError) as error:
            return f"numba has changed inside ({error})"
    return ""
