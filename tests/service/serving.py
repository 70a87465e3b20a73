"""A real server process for tests: `python serving.py ENDPOINT WORKERS WORK [STORE_BYTES]`; ends on SIGTERM."""

import signal
import sys
import threading
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))

from kabo.service import Server, ServerSettings, server_config

if __name__ == "__main__":
    endpoint, workers, bound, work = sys.argv[1:5]
    settings = ServerSettings(workers=int(workers), bound=int(bound), work=work, store_bytes=100_000)
    server = Server(server_config([endpoint]), settings)
    told = threading.Event()
    signal.signal(signal.SIGTERM, lambda *_: told.set())
    print(server.name, flush=True)
    told.wait()
    server.close(5.0)
