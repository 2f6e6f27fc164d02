"""Compiled kernels: the decorator and its cache, structs that kernels share, Python functions in place of kernels.

Everything that touches numba beyond its public face is here, each with a test that says what breaks when it changes.
To add a kernel: decorate a function of arrays, numbers and structs with ``kernel`` (:mod:`lcpflex.jit.kernel`); one
that many runs do not need, with ``late_kernel``, where the condition of its call is.
To add a struct: :mod:`lcpflex.jit.struct`. To go to another numba: :mod:`lcpflex.jit.private`.
"""
