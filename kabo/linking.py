"""Kernels inside kernels: what a kernel calls is linked into it, and optimised there, once.

numba optimises each function together with all that it calls, and makes machine code of it: a function eight calls
deep is optimised eight times, which was two thirds of compiling. So each kernel is two: the *whole* that Python calls,
and the *part* that other kernels call. A part is typed and lowered, but neither optimised nor made executable; its
callers' wholes do that. Only wholes are stored on disk.

This leans on numba's `pipeline_class` and on four methods of its code libraries [numba/core/codegen.py].
"""

import gc
from functools import cache
from typing import Any


@cache
def whole_compiler() -> Any:
    """Compiles without collections of garbage: it makes millions of objects that live until it ends."""
    from numba.core.compiler import Compiler

    class WholeCompiler(Compiler):  # type: ignore[misc]  # numba has no types
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
    """A compiler that stops before anything is optimised."""
    from numba.core.codegen import JITCodeLibrary
    from numba.core.compiler import Compiler

    class WithoutEnvironment:
        """A code generator that does not look for the machine code of what has none."""

        def __init__(self, generator: Any) -> None:
            self._generator = generator

        def set_env(self, name: str, environment: Any) -> None:
            """Nothing: only code that calls Python has use for an environment."""

        def __getattr__(self, name: str) -> Any:
            return getattr(self._generator, name)

    class PartLibrary(JITCodeLibrary):  # type: ignore[misc]  # numba has no types
        @property
        def codegen(self) -> Any:
            return WithoutEnvironment(self._codegen)

        def finalize(self) -> None:
            self._raise_if_finalized()
            for library in dict.fromkeys(self._linking_libraries):
                self._reload_init.update(library._reload_init)
                self._final_module.link_in(library._get_module_for_linking(), preserve=True)
            self._finalized = True

        def get_pointer_to_function(self, name: str) -> int:
            self._ensure_finalized()
            return 0

    class PartCompiler(Compiler):  # type: ignore[misc]  # numba has no types
        def compile_extra(self, function: Any) -> Any:
            self.state.library = PartLibrary(self.state.targetctx.codegen(), function.__qualname__)
            self.state.library.enable_object_caching()
            return super().compile_extra(function)

    return PartCompiler


def stand_in(whole: Any, part: Any) -> Any:
    """The whole, for which the part stands in where other kernels call it.

    Calls with constants use the code for any number: else each combination of constants would be compiled once more.
    """
    from numba.core.types import unliteral

    def general_template(arguments: Any, keywords: Any) -> Any:
        return part.get_call_template(
            [unliteral(a) for a in arguments], {name: unliteral(a) for name, a in keywords.items()}
        )

    whole.get_call_template = general_template
    whole.get_overload = part.get_overload
    return whole
