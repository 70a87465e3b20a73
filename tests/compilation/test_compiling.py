"""What kernels have beside numba: windows into flat arrays, and one way to round."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np

import kabo
from kabo.compilation import kernel, lean_kernel, settled, window


@lean_kernel
def written(flat, start, rows, columns):
    """Reads, writes and shapes as a kernel does."""
    matrix, cube = window(flat, start, (rows, columns)), window(flat, start + 1, (rows, 2, columns))
    line = window(flat.view(np.int64), 0, (1,))
    matrix[rows - 1, 1] = -7.0
    cube[1, 1, 2] = 99.0
    line[0] = 5
    return matrix.shape[0] * matrix.shape[1] + cube.size, matrix[1, 2], cube[1, 0, 1], line[0]


def test_a_window_is_the_flat_arrays_own_memory_in_kernels_and_in_python():
    outcomes = []
    for function in (written, written.py_func):
        flat = np.arange(40.0)
        outcomes.append((function(flat, 8, 2, 3), flat.tolist()))
    assert outcomes[0] == outcomes[1]
    assert outcomes[0][0] == (18, 13.0, 16.0, 5)
    assert outcomes[0][1][12] == -7.0


class Bundle(NamedTuple):
    """Arrays that a kernel takes together."""

    rows: np.ndarray
    sums: np.ndarray


@kernel
def summed(bundle, factor):
    """Writes the sum of each row, times a factor."""
    for k in range(bundle.rows.shape[0]):
        bundle.sums[k] = factor * bundle.rows[k].sum()


def test_a_settled_kernel_gives_the_same_answers_each_time():
    rows = np.arange(24.0).reshape(8, 3)
    quick = settled(summed)
    for given in (rows[::2], rows[1::2], rows[:1:2]):  # not contiguous, which fits a single row, too
        wanted, found = (Bundle(given, np.zeros(len(given))) for _ in range(2))
        summed(wanted, 0.5)
        quick(found, 0.5)
        assert found.sums.tolist() == wanted.sums.tolist() == (0.5 * given.sum(axis=1)).tolist()
    python = settled(summed.py_func)  # where compiling is switched off
    python(found, 2.0)
    assert found.sums.tolist() == [6.0]


def test_a_settled_kernel_looks_at_its_arguments_at_the_first_call_alone():
    looked = []

    class Kernel:
        def typeof_pyval(self, argument):
            looked.append(argument)
            return type(argument)

        def compile(self, types):
            return lambda *arguments: (types, arguments)

    quick = settled(Kernel())
    assert [quick(1, 2.0), quick(3, 4.0)] == [((int, float), (1, 2.0)), ((int, float), (3, 4.0))]
    assert looked == [1, 2.0]


def test_no_kernel_lets_the_compiler_choose_how_to_round():
    """The plans of two caches differed: what LLVM makes of `fastmath` depends on what it has compiled before."""
    sources = {path: path.read_text() for path in Path(kabo.__file__).parent.rglob("*.py")}
    assert sum("njit(" in text for text in sources.values())  # they are looked at
    assert [path for path, text in sources.items() if re.search(r"fastmath\s*=", text)] == []


def test_another_installation_of_the_same_kabo_has_its_own_kernels_to_compile(tmp_path: Path) -> None:
    """As numba keeps what it compiles by the place of the sources: a mark for both would hide minutes of work."""
    sources = Path(kabo.__file__).parent
    other = tmp_path / "other"
    shutil.copytree(sources, other / "kabo", ignore=shutil.ignore_patterns("__pycache__", "data", "static"))
    look = "from kabo.compilation.compiling import _folder, note_compiled, usual_kernels_compiled as made; "
    said = []
    for place, program in (
        (sources.parent, "_folder().mkdir(parents=True); note_compiled(); print(made())"),
        (other, "print(made())"),
    ):
        environment = {**os.environ, "PYTHONPATH": str(place), "KABO_CACHE": str(tmp_path / "cache")}
        command = [sys.executable, "-c", look + program]
        done = subprocess.run(command, capture_output=True, text=True, check=True, env=environment, cwd=tmp_path)
        said.append(done.stdout)
    assert said == ["True\n", "False\n"]
    assert len(list((tmp_path / "cache" / "compiled").iterdir())) == 1, "the sources are the same"
