"""Kernels that call kernels: one whole is made of them, whatever was called before."""

import gc
import json
import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from llvmlite.binding import parse_bitcode

from kabo.compilation import kernel, lean_kernel

KERNELS = """
import sys
import numpy as np
import kabo.compilation.linking

if sys.argv[1] == "without linking":
    def part_compiler():
        raise AttributeError("'JITCodeLibrary' object has no attribute '_renamed'")

    kabo.compilation.linking.part_compiler = part_compiler

from kabo.compilation import kernel, lean_kernel

@lean_kernel
def third(x):
    return x / 3.0

@lean_kernel
def total(values):
    result = 0.0
    for i in range(values.shape[0]):
        result += values[i]
    return result

@kernel
def scaled(values, factor):
    return values * factor

@kernel
def outer(values):
    return third(total(scaled(values, 3))) + third(1) + total(values[:1])

if __name__ == "__main__":
    import json
    values = np.arange(5.0)
    first = [third(3.0), total(values)] if sys.argv[1] == "inner first" else []
    print(json.dumps([outer(values), third(3.0), total(values), scaled(values, 2.0).tolist(),
        sum(outer.stats.cache_hits.values()), sum(third.stats.cache_hits.values())]))
"""


@lean_kernel
def half(x):
    return x / 2


@lean_kernel
def total(values):
    result = 0.0
    for i in range(values.shape[0]):
        result += values[i]
    return result


@kernel
def halves(values):
    made = np.empty_like(values)
    for i in range(values.shape[0]):
        made[i] = half(values[i])
    return made


@kernel
def outer(values):
    return total(halves(values)) + half(1) + half(2.0)


compiled = pytest.mark.skipif(not hasattr(outer, "overloads"), reason="compiling is switched off")


@compiled
def test_a_whole_is_its_python_function():
    values = np.random.default_rng(0).normal(size=50)
    for function, argument in ((outer, values), (halves, values), (total, values), (half, 0.3)):
        assert np.allclose(function(argument), function.py_func(argument), rtol=1e-12, atol=0)


@compiled
def test_what_a_kernel_calls_is_not_compiled_by_itself():
    @lean_kernel
    def inner(x):
        return x + 1

    @lean_kernel
    def caller(x):
        return inner(x) * inner(2)

    assert caller(3.0) == 12
    assert len(caller.overloads) == 1
    assert len(inner.overloads) == 0  # nobody but kernels has called it
    assert inner(1.0) == 2
    assert len(inner.overloads) == 1


@compiled
def test_garbage_is_collected_again_after_compiling():
    @kernel
    def fresh(x):
        return x - 1

    assert gc.isenabled()
    assert fresh(1.0) == 0
    assert gc.isenabled()
    gc.disable()
    try:
        assert fresh(1) == 0
        assert not gc.isenabled()
    finally:
        gc.enable()


def run_kernels(tmp_path, order):
    """What the kernels of a process of their own compute, and what it says on standard error."""
    script = tmp_path / "kernels.py"
    if not script.exists():  # numba forgets what it stored for a file that was written again
        tmp_path.mkdir(exist_ok=True)
        script.write_text(KERNELS)
    environment = {
        **os.environ,
        "KABO_CACHE": str(tmp_path / "cache"),
        "PYTHONPATH": str(Path(__file__).parents[2]),
    }
    done = subprocess.run(
        [sys.executable, str(script), order], env=environment, capture_output=True, text=True, check=True
    )
    return json.loads(done.stdout), done.stderr


@compiled
def test_wholes_are_stored_and_found_in_any_order(tmp_path):
    answers = [run_kernels(tmp_path, order)[0] for order in ("outer first", "inner first", "inner first")]
    for whole, third, sum_of_all, scaled, *_ in answers:
        assert whole == pytest.approx(10 + 1 / 3)
        assert third == 1
        assert sum_of_all == 10
        assert scaled == [0, 2, 4, 6, 8]
    assert [answer[4] for answer in answers] == [0, 1, 1]
    assert [answer[5] for answer in answers] == [0, 1, 1]


@compiled
def test_of_the_bitcode_of_a_whole_only_the_names_are_stored():
    outer(np.arange(3.0))
    (made,) = outer.overloads.values()
    _, _, (_, bitcode) = made.library.serialize_using_object_code()
    functions = [each for each in parse_bitcode(bitcode).functions if not each.is_declaration]
    assert made.fndesc.llvm_cpython_wrapper_name in {each.name for each in functions}
    assert {sum(1 for block in each.blocks for _ in block.instructions) for each in functions} == {1}


@compiled
def test_a_numba_whose_stored_kernels_lack_their_entries_does_not_link(monkeypatch):
    from kabo.compilation import linking  # after numba, whose settings kernels make

    monkeypatch.setattr(linking, "Linkage", SimpleNamespace(external=None))
    linking.whole_compiler.cache_clear()
    try:
        with pytest.warns(RuntimeWarning, match="a stored kernel lacks its entries"):
            assert not linking.linking_works({"nogil": True})
    finally:
        linking.whole_compiler.cache_clear()


@compiled
def test_a_numba_that_does_not_link_computes_the_same_after_one_warning(tmp_path):
    linked, silence = run_kernels(tmp_path / "linked", "outer first")
    plain, warning = run_kernels(tmp_path / "plain", "without linking")
    assert plain == linked
    assert silence == ""
    assert warning.count("does not link kernels") == 1
    assert "'JITCodeLibrary' object has no attribute '_renamed'" in warning
