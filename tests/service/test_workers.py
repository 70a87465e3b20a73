"""The pool of workers: who has the answer to a job no longer finds it running."""

import json
import queue
import time

from kabo.service.jobs import Job, JobStore, Outcome
from kabo.service.workers import Pool
from tests.service.conftest import STUB


def test_a_job_is_no_longer_running_when_its_answer_is_delivered():
    store, answers = JobStore(), queue.Queue[tuple[Outcome, int]]()
    pool = Pool(STUB, store, workers=1, bound=4, root=None, on_progress=lambda *_: None)
    try:
        request = json.dumps({"id": "a", "options": {"x": 3}}).encode()
        job = Job("a", request, time.monotonic() + 60)
        assert store.admit(job, lambda outcome: answers.put((outcome, pool.running)), pool.enqueue) is None
        outcome, running = answers.get(timeout=60)
    finally:
        pool.close()
    assert json.loads(outcome.body) == {"id": "a", "square": 9}
    assert running == 0
