"""CoACD in a process of its own: it is C++, and on meshes that it does not expect it crashes or never ends.

This file is run as a script by `hulls_of`; it imports nothing of kabo. A process that dies, or takes more than its
share of processor time, has proposed nothing; that costs parts, never a proof.
"""

import io
import os
import subprocess
import sys
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
SECONDS = 120  # of processor time; the shipped meshes take 30 at most
PATIENCE_S = 900.0  # on a machine that does other things


def hulls_of(vertices: Array, faces: NDArray[np.int64], **parameters: Any) -> list[Array]:
    """The corners (V, 3) of the hulls into which CoACD cuts a mesh; none if it does not come to an end."""
    given = io.BytesIO()
    np.savez(given, vertices=vertices, faces=faces, **parameters)
    try:
        run = subprocess.run(  # noqa: S603  this file, by this Python
            [sys.executable, __file__],
            input=given.getvalue(),
            capture_output=True,
            timeout=PATIENCE_S,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired):
        return []
    if run.returncode != 0:
        return []
    with np.load(io.BytesIO(run.stdout)) as found:
        return [found[name] for name in found.files]


def _main() -> None:
    answer = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what the library says does not belong to the answer
    try:
        import resource

        resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    except ImportError:  # a system without such limits
        pass
    import coacd

    with np.load(io.BytesIO(sys.stdin.buffer.read())) as given:
        parameters = {name: given[name].item() for name in given.files if name not in {"vertices", "faces"}}
        mesh = coacd.Mesh(given["vertices"], given["faces"])
    coacd.set_log_level("off")
    hulls = coacd.run_coacd(mesh, **parameters)
    corners: dict[str, Any] = {f"hull_{i:06}": np.asarray(hull[0], np.float64) for i, hull in enumerate(hulls)}
    np.savez(answer, **corners)
    answer.flush()


if __name__ == "__main__":
    _main()
