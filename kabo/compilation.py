"""How and where array kernels are compiled: `kernel`, the only door to numba.

numba notices changes in a kernel's own file only: a caller keeps running its callee's old code. So the compiled
code lies in a folder named after the hash of *all* kernel sources and of how they are compiled. fastmath stays off,
because reordering could undo a proof [docs/decisions/001-kernels.md]; `reassoc` and `contract` alone are allowed where
a kernel asks for them. What a kernel calls is compiled as a part of it [kabo.linking].
"""

import atexit
import hashlib
import math
import os
import shutil
import stat
import tempfile
import warnings
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

_Function = TypeVar("_Function", bound=Callable[..., Any])


def cache_folder() -> Path:
    """The folder for everything that may be computed again: $KABO_CACHE, $XDG_CACHE_HOME/kabo, ~/.cache/kabo.

    What lies there is executed (compiled kernels, and indices that are pickles), so a folder is taken only if it
    belongs to this user and nobody else can write to it. Where there is none, a private folder in the system's
    temporary directory serves this process and those that it starts.
    """
    chosen = os.environ.get("KABO_CACHE")
    home = os.environ.get("XDG_CACHE_HOME")
    candidate = Path(chosen) if chosen else Path(home) / "kabo" if home else _home() / ".cache" / "kabo"
    return candidate if _usable(candidate) else _private_folder()


def _home() -> Path:
    try:
        return Path.home()
    except RuntimeError:  # a user without a name or a home
        return Path("/nonexistent")


def _usable(folder: Path) -> bool:
    """Whether a folder can be written, is there or was made, and is this user's alone to write."""
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        folder.mkdir(mode=0o700, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=folder):
            pass
        status = folder.stat()
    except (OSError, ValueError):  # ValueError: a null byte in the name
        return False
    if not hasattr(os, "getuid"):
        return True
    if status.st_uid == os.getuid() and not status.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
        return True
    _warn_of(folder, status.st_uid == os.getuid())
    return False


@cache
def _warn_of(folder: Path, own: bool) -> None:
    remedy = (
        "empty it, then chmod go-w" if own else "it belongs to another user: set KABO_CACHE to a folder of yours"
    )
    said = f"kabo does not use the cache folder {folder}, to which others can write; {remedy}"
    warnings.warn(said, stacklevel=3)


@cache
def _private_folder() -> Path:
    """A new folder that only this user can read or write; gone when the process ends."""
    folder, owner = Path(tempfile.mkdtemp(prefix="kabo-cache-")), os.getpid()

    def remove() -> None:
        if os.getpid() == owner:  # forks leave it to the process that made it
            shutil.rmtree(folder, ignore_errors=True)

    atexit.register(remove)
    os.environ["KABO_CACHE"] = str(folder)  # processes that this one starts share it
    return folder


@cache
def _sources_digest() -> str:
    digest, here = hashlib.sha256(), Path(__file__).parent
    for source in (here / "compilation.py", here / "linking.py", *sorted(here.glob("*/kernels/*.py"))):
        digest.update(source.name.encode() + b"\0" + source.read_bytes())
    return digest.hexdigest()[:16]


@cache
def _numba() -> Any:
    folder = cache_folder() / "compiled" / _sources_digest()
    os.environ.setdefault("NUMBA_CACHE_DIR", str(folder))  # read once, when numba is imported
    os.environ.setdefault("NUMBA_CPU_NAME", os.environ.get("KABO_CPU", "host"))
    if os.environ["NUMBA_CPU_NAME"] == "host":
        del os.environ["NUMBA_CPU_NAME"]
    import numba

    setattr(numba.config, "CACHE_DIR", str(folder))  # noqa: B010  the module makes its names at run time
    _teach_window()
    return numba


def window(flat: Any, start: int, shape: tuple[int, ...]) -> Any:
    """The numbers of a flat array from `start` on, as a contiguous array of a shape; kernels have it for nothing.

    Nothing is copied, and a kernel does not see to it that the flat array is long enough.
    """
    return flat[start : start + math.prod(shape)].reshape(shape)


def _teach_window() -> None:
    """Tells numba how kernels take a `window`; slices and shapes of its own are calls, and count references."""
    from numba.core import cgutils, types
    from numba.extending import lower_builtin, type_callable
    from numba.np.arrayobj import make_array, populate_array

    @type_callable(window)
    def _(_: Any) -> Any:
        return lambda flat, start, shape: types.Array(flat.dtype, len(shape), "C")

    @lower_builtin(window, types.Array, types.Integer, types.BaseTuple)  # type: ignore[untyped-decorator]
    def _(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        source = make_array(signature.args[0])(context, builder, arguments[0])
        made = make_array(signature.return_type)(context, builder)
        lengths = cgutils.unpack_tuple(builder, arguments[2])
        step = context.get_constant(
            types.intp, context.get_abi_sizeof(context.get_data_type(signature.return_type.dtype))
        )
        strides = [step]
        for length in reversed(lengths[1:]):
            strides.insert(0, builder.mul(strides[0], length))
        data = builder.gep(source.data, [arguments[1]])
        populate_array(made, data, lengths, strides, step, None)
        return made._getvalue()


def _compiled(function: _Function, **options: Any) -> _Function:
    numba = _numba()
    if numba.config.DISABLE_JIT:
        return function
    options = {**_OPTIONS, **options}
    if not _links():
        compiled: _Function = numba.njit(cache=True, **options)(function)
        return compiled
    from kabo.linking import linked

    whole: _Function = linked(function, options, stored=True)
    return whole


_OPTIONS = {"nogil": True, "error_model": "numpy", "no_cfunc_wrapper": True}


@cache
def _links() -> bool:
    """Whether kernels are linked from parts; a file in the cache remembers that this numba could do it."""
    numba = _numba()
    tried = Path(numba.config.CACHE_DIR) / f"numba-{numba.__version__}-links"
    if tried.exists():
        return True
    from kabo.linking import linking_works

    works = linking_works(_OPTIONS)
    if works:
        tried.parent.mkdir(parents=True, exist_ok=True)
        tried.touch()
    return works


def kernel(function: _Function) -> _Function:
    """Compiles `function` for plain arrays and numbers; `.py_func` is the Python original."""
    return _compiled(function)


def lean_kernel(function: _Function) -> _Function:
    """As `kernel`, for functions that make no array, nor call one that does: references are not counted.

    Counting costs some nanoseconds for each array at each call, which nested kernels of many arrays feel.
    """
    return _compiled(function, _nrt=False)


def leaf_kernel(function: _Function) -> _Function:
    """As `kernel`, for small functions that every caller inlines."""
    inlined: _Function = _numba().njit(cache=True, nogil=True, error_model="numpy", inline="always")(function)
    return inlined


def reduction_kernel(function: _Function) -> _Function:
    """As `lean_kernel`, but sums may be reordered and contracted; only where the rounding bound allows any order.

    Not inlined by numba, because an inlined body takes its caller's rules; LLVM inlines it with its own.
    """
    return _compiled(function, fastmath={"contract", "reassoc", "nsz"}, _nrt=False)
