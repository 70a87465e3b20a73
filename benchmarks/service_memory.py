"""What stays in memory: mixed requests to one worker of a real server, and how large both processes are as they go.

Most requests are small symbolic problems; the others are geometric. Each that stacks blocks is another one: the position
of a block and the size of its mesh are drawn, so that what is remembered of one does not serve the next.

    python benchmarks/service_memory.py --requests 2000 --output memory.json
"""

import argparse
import os
import random
import re
import socket
import time
from base64 import b64encode
from pathlib import Path
from typing import Any

import numpy as np
from table import Table, finish

from kabo.service import Client, Server, ServerSettings, client_config, pack_problem, server_config

DOMAINS = Path(__file__).parents[1] / "domains"
SYMBOLIC = ("doors/n3", "wumpus/n4", "unix/n1", "medicate/n5", "safes/n3", "rovers/n4", "logistics/n3", "grid/n3")
GEOMETRIC = ("stacked/n2", "stacked/n2", "stacked/n3", "force_sensing/n1")
SHARE = 0.4  # of geometric requests
WARM = 100  # requests after which the memory is what others are compared with
TRIANGLE = np.dtype([("corners", "<f4", (4, 3)), ("attributes", "<u2")])


def resident(process: int) -> float:
    """The resident memory of a process [MB]."""
    pages = int(Path(f"/proc/{process}/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def processor_time(process: int) -> float:
    """The processor time of a process [s]."""
    fields = Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def cube(size: float) -> dict[str, str]:
    """A cube as an inline file of binary STL."""
    corners = size * (np.array([[i >> 2 & 1, i >> 1 & 1, i & 1] for i in range(8)]) - 0.5)
    sides = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    triangles = np.zeros(12, TRIANGLE)
    faces = [[a, *pair] for a, b, c, d in sides for pair in ((b, c), (c, d))]
    triangles["corners"][:, 1:] = corners[np.array(faces)]
    return {"base64": b64encode(bytes(80) + (12).to_bytes(4, "little") + triangles.tobytes()).decode()}


def varied(packed: dict[str, Any], draw: random.Random) -> dict[str, Any]:
    """A geometric problem of its own: another size of the block, and another place."""
    files = dict(packed["files"])
    for name, text in packed["files"].items():
        if name.endswith("block.stl"):
            files[name] = cube(0.04 - draw.uniform(0.0, 2e-4))
        elif name == packed["path"]:
            files[name] = re.sub(r"\[0, 0, 0\.025\]", f"[0, {draw.uniform(-1e-3, 1e-3):.6f}, 0.025]", text)
    return {**packed, "files": files}


def main() -> None:
    """Sends the requests one by one, and prints the memory after every hundred."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--requests", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--output", type=Path)
    options = parser.parse_args()
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        endpoint = f"tcp/127.0.0.1:{probe.getsockname()[1]}"
    draw = random.Random(options.seed)  # noqa: S311
    packed = {name: pack_problem(DOMAINS / f"{name}.yaml") for name in {*SYMBOLIC, *GEOMETRIC}}
    server, statuses = Server(server_config([endpoint]), ServerSettings(workers=1)), dict[str, int]()
    table, held = Table("Memory of a worker, and of its server"), dict[int, float]()
    (worker,) = server.worker_processes()
    with Client(client_config([endpoint])) as client:
        for number in range(1, options.requests + 1):
            geometric = draw.random() < SHARE
            name = draw.choice(GEOMETRIC if geometric else SYMBOLIC)
            problem = varied(packed[name], draw) if geometric else packed[name]
            limits = {"max_samples": 4000, "max_expansions": 5000}
            body = client.solve(lambda _, it=problem: it, limits, deadline_s=300).body
            statuses[body["status"]] = statuses.get(body["status"], 0) + 1
            if number % WARM == 0 or number in (1, 10, 50):
                time.sleep(0.1)  # the worker collects after it answered
                held[number] = resident(worker)
                figures = {"worker MB": held[number], "server MB": resident(os.getpid())}
                table.add(f"after {number} requests", **figures, **{"processor s": processor_time(worker)})
    server.close()
    numbers = list(held)
    first = WARM if WARM in held else numbers[0]
    table.add(f"the last / after {first}", ratio=held[numbers[-1]] / held[first])
    finish([table], options.output, seed=options.seed, requests=options.requests, statuses=statuses)


if __name__ == "__main__":
    main()
