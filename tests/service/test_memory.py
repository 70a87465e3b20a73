"""The memory of a worker that answers many requests: what one leaves behind is gone before the next."""

import json
import os
import queue
import time
from pathlib import Path

import pytest

from kabo.service import pack_problem
from kabo.service.jobs import JobStore, Outcome, SolveJob
from kabo.service.workers import Pool
from tests.conftest import PROPERTY_SCALE
from tests.service.conftest import REPOSITORY

PROBLEMS = ("stacked/n2", "doors/n3", "force_sensing/n1", "wumpus/n4")
WARM, REQUESTS = 20, max(80, round(800 * PROPERTY_SCALE))


def resident(process: int) -> int:
    """The resident memory of a process [bytes]."""
    return int(Path(f"/proc/{process}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


@pytest.mark.slow
def test_after_many_requests_a_worker_is_as_large_as_after_a_few():
    """Without a collection after each job 20 requests of stacked/n2 took 280 MB."""
    packed = [pack_problem(REPOSITORY / "domains" / f"{name}.yaml") for name in PROBLEMS]
    store, answers, sizes = JobStore(), queue.Queue[Outcome](), {}
    work = "kabo.service.worker:solve_work"
    pool = Pool(work, store, workers=1, bound=4, root=None, on_progress=lambda *_: None)
    try:
        pool.warm_up()
        (worker,) = pool.processes()
        for k in range(1, REQUESTS + 1):
            request = json.dumps({"id": f"n{k}", "problem": packed[k % len(packed)]}).encode()
            job = SolveJob(f"n{k}", request, time.monotonic() + 300)
            assert store.admit(job, answers.put, pool.enqueue) is None
            assert json.loads(answers.get(timeout=300).body)["status"] == "solved"
            if k in (WARM, REQUESTS):
                time.sleep(0.5)  # it tidies up after it has answered
                sizes[k] = resident(worker)
    finally:
        pool.close()
    assert sizes[REQUESTS] <= 1.15 * sizes[WARM]
