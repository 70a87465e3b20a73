"""Linking of kernels: the kernels that a kernel calls are linked into it and optimised only there.

numba optimises each function together with everything that it calls: a function eight calls deep is optimised eight
times, which was two thirds of the time of compiling. So each kernel is compiled as two functions: the *whole*, which
Python calls, and the *part*, which other kernels call. A part is typed and lowered, but optimised and made executable
only inside the wholes of its callers. Only wholes are stored on disk.

This depends on numba's `pipeline_class` and on a few private methods of its code libraries [numba/core/codegen.py].
`linking_works` tries it; where it does not work, kernels are compiled in numba's own way, which takes longer to compile
and to load.
"""

import gc
import warnings
from functools import cache
from typing import Any

import numba
import numpy as np
from llvmlite import ir
from llvmlite.binding import Linkage, parse_assembly, parse_bitcode
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.errors import NumbaError
from numba.core.types import unliteral


@cache
def whole_compiler() -> Any:
    """A numba compiler class that disables garbage collection while compiling, as its objects stay alive.

    numba stores, beside the machine code, the bitcode that other functions would link, and reads it again with each
    load: a third of the time of loading. Nothing links a whole, so only the names are stored that numba looks for.
    """

    class WholeLibrary(JITCodeLibrary):
        def _get_module_for_linking(self) -> Any:
            self._ensure_finalized()
            names, nothing = self._codegen._create_empty_module(self.name), ir.FunctionType(ir.VoidType(), ())
            for each in self._final_module.functions:
                if not each.is_declaration and each.linkage == Linkage.external:
                    ir.IRBuilder(ir.Function(names, nothing, each.name).append_basic_block()).ret_void()
            return parse_assembly(str(names))

    class WholeCompiler(Compiler):
        def compile_extra(self, function: Any) -> Any:
            self.state.library = WholeLibrary(self.state.targetctx.codegen(), function.__qualname__)
            self.state.library.enable_object_caching()
            collecting = gc.isenabled()
            gc.disable()
            try:
                return super().compile_extra(function)
            finally:
                if collecting:
                    gc.enable()

    return WholeCompiler


@cache
def part_compiler() -> Any:
    """A numba compiler class that types and lowers a function, but does not optimise it."""

    class WithoutEnvironment:
        """A code generator that sets no environment, for libraries without machine code."""

        def __init__(self, generator: Any) -> None:
            self._generator = generator

        def set_env(self, name: str, environment: Any) -> None:
            """Does nothing: only code that calls Python needs an environment."""

        def __getattr__(self, name: str) -> Any:
            return getattr(self._generator, name)

    class PartLibrary(JITCodeLibrary):
        """A library that is linked, as numba's own `finalize` does it, but neither optimised nor made executable."""

        @property
        def codegen(self) -> Any:
            return WithoutEnvironment(self._codegen)

        def _optimize_final_module(self) -> None:
            """Does nothing: the wholes that this is linked into are optimised."""

        def _finalize_final_module(self) -> None:
            self._finalized = True

        def get_pointer_to_function(self, name: str) -> int:
            self._ensure_finalized()
            return 0

    class PartCompiler(Compiler):
        def compile_extra(self, function: Any) -> Any:
            self.state.library = PartLibrary(self.state.targetctx.codegen(), function.__qualname__)
            self.state.library.enable_object_caching()
            return super().compile_extra(function)

    return PartCompiler


def linked(function: Any, options: dict[str, Any], *, stored: bool) -> Any:
    """A kernel linked from the separately compiled parts of all kernels that it calls; stored on disk if `stored`.

    A call with constant arguments uses the code compiled for the type of the constants; otherwise each combination
    of constants would be compiled separately.
    """
    njit: Any = numba.njit  # its types know nothing of its private options
    whole = njit(cache=stored, pipeline_class=whole_compiler(), **options)(function)

    @cache
    def part() -> Any:  # only when a caller is compiled, which is seldom
        return njit(no_cpython_wrapper=True, pipeline_class=part_compiler(), **options)(function)

    def general_template(arguments: Any, keywords: Any) -> Any:
        return part().get_call_template(
            [unliteral(a) for a in arguments], {name: unliteral(name_type) for name, name_type in keywords.items()}
        )

    whole.get_call_template = general_template
    whole.get_overload = lambda signature: part().get_overload(signature)
    return whole


def _stores_its_entries(whole: Any) -> bool:
    """Whether what numba would store of a kernel names the functions by which Python and compiled code enter it."""
    (compiled,) = whole.overloads.values()
    _, _, (_, bitcode) = compiled.library.serialize_using_object_code()
    names = {each.name for each in parse_bitcode(bitcode).functions if not each.is_declaration}
    return names >= {compiled.fndesc.llvm_func_name, compiled.fndesc.llvm_cpython_wrapper_name}


def linking_works(options: dict[str, Any]) -> bool:
    """Whether the installed numba can link separately compiled kernels; warns if it cannot.

    The test compiles a kernel that calls one kernel with arrays and one without arrays.
    """

    def scaled(values: Any, factor: Any) -> Any:
        return values * factor

    def third(number: Any) -> Any:
        return number / 3.0

    def outer(values: Any) -> Any:
        return times(values, 2)[1] + divided(values[2]) + divided(3)

    try:
        times, divided = (
            linked(scaled, options, stored=False),
            linked(third, {**options, "_nrt": False}, stored=False),
        )
        tried = linked(outer, options, stored=False)
        if tried(np.arange(4.0)) != 2.0 + 2.0 / 3.0 + 1.0:
            reason = "a kernel that calls two others computes something else"
        elif not _stores_its_entries(tried):
            reason = "a stored kernel lacks its entries"
        else:
            return True
    except (NumbaError, AttributeError, TypeError, ValueError, LookupError, RuntimeError, AssertionError) as error:
        reason = f"{type(error).__name__}: {error}"
    warnings.warn(
        f"numba {numba.__version__} does not link kernels as kabo asks it to ({reason.splitlines()[0]}): plans are the "
        "same, but kernels take longer to compile when kabo runs for the first time",
        RuntimeWarning,
        stacklevel=2,
    )
    return False
