"""Linking of kernels: the kernels that a kernel calls are linked into it and optimised only there.

numba optimises each function together with everything that it calls: a function eight calls deep is optimised eight
times, which was two thirds of the time of compiling. So each kernel is compiled as two functions: the *whole*, which
Python calls, and the *part*, which other kernels call. A part is typed and lowered, but optimised and made executable
only inside the wholes of its callers. Only wholes are stored on disk.

This depends on numba's `pipeline_class` and on a few private methods of its code libraries [numba/core/codegen.py].
`linking_works` tries it; where it does not work, kernels are compiled in numba's own way, which takes longer.
"""

import gc
import warnings
from functools import cache
from typing import Any

import numba
import numpy as np
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.errors import NumbaError
from numba.core.types import unliteral


@cache
def whole_compiler() -> Any:
    """A numba compiler class that disables garbage collection while compiling, as its objects stay alive."""

    class WholeCompiler(Compiler):
        def compile_extra(self, function: Any) -> Any:
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
    part = njit(no_cpython_wrapper=True, pipeline_class=part_compiler(), **options)(function)

    def general_template(arguments: Any, keywords: Any) -> Any:
        return part.get_call_template(
            [unliteral(a) for a in arguments], {name: unliteral(name_type) for name, name_type in keywords.items()}
        )

    whole.get_call_template = general_template
    whole.get_overload = part.get_overload
    return whole


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
        if linked(outer, options, stored=False)(np.arange(4.0)) == 2.0 + 2.0 / 3.0 + 1.0:
            return True
        reason = "a kernel that calls two others computes something else"
    except (NumbaError, AttributeError, TypeError, ValueError, LookupError, RuntimeError, AssertionError) as error:
        reason = f"{type(error).__name__}: {error}"
    warnings.warn(
        f"numba {numba.__version__} does not link kernels as kabo asks it to ({reason.splitlines()[0]}): plans are the "
        "same, but kernels take longer to compile when kabo runs for the first time",
        RuntimeWarning,
        stacklevel=2,
    )
    return False
