"""The service with work of its own: every request gets exactly one answer, whatever dies, hangs or stops."""

import json
import os
import signal
import time
import uuid
from concurrent.futures import ThreadPoolExecutor

import msgspec
import pytest

from kabo.errors import ServiceError
from kabo.service import Client, client_config
from tests.service.conftest import Running, free_endpoint

LONG = 30.0  # [s] of work that nobody waits for


def ask(client: Client, *, deadline_s: float = 20.0, identifier: str | None = None, **options: object) -> dict:
    """The body of a reply to a request with these options for the stub."""
    reply = client.solve(
        lambda _: {"files": {}}, options, deadline_s=deadline_s, identifier=identifier or uuid.uuid4().hex
    )
    assert reply.plan == b"plan of " + reply.body["id"].encode()
    return reply.body


def raw(client: Client, server: str, verb: str, payload: bytes) -> tuple[str, dict]:
    """What a server answers to any bytes: ("ok" or "error", the object)."""
    answer = client._ask(server, verb, payload, 25.0)  # beyond every deadline here: a busy machine is no silence
    assert answer is not None, "silence"
    return ("ok" if hasattr(answer, "attachment") else "error"), json.loads(answer.payload.to_bytes())


def test_a_reply_carries_the_id_and_the_plan(serve):
    with serve().client() as client:
        assert ask(client, identifier="my-id.1", x=7) == {"id": "my-id.1", "square": 49}


def test_the_status_says_what_a_client_must_know(serve):
    server = serve(workers=1)
    with server.client() as client:
        ask(client)
        status = client.status(server.name)
    assert status is not None
    assert (status.server, status.workers, status.queued, status.running) == (server.name, 1, 0, 0)
    assert (status.protocol, status.root) == (1, None)
    assert 1 << 20 < status.max_request_bytes < 64 << 20


@pytest.mark.parametrize(
    "payload",
    [
        b"",
        b"{",
        b"\xff\xfe",
        b"[" * 100_000,
        b"null",
        b'{"id": "a"}',
        b'{"id": "a/b", "problem": {}}',
        b'{"id": "", "problem": {}}',
        b'{"id": 7, "problem": {}}',
        b'{"id": "a", "problem": {}, "deadline_s": -1}',
        b'{"id": "a", "problem": {}, "deadline_s": 1e999}',
        b'{"id": "a", "problem": {}, "surprise": 1}',
    ],
)
def test_garbage_is_answered_with_bad_request_and_never_with_silence(serve, payload):
    server = serve(workers=1)
    with server.client() as client:
        client._pick(set(), time.monotonic() + 5)
        kind, error = raw(client, server.name, "solve", payload)
        assert (kind, error["code"]) == ("error", "bad_request")
        assert ask(client, x=3)["square"] == 9


def test_a_request_that_is_too_large_is_refused_before_it_is_sent(serve):
    with serve(workers=1).client() as client, pytest.raises(ServiceError, match="bytes") as refused:
        client.solve(lambda _: {"files": {"a": "x" * (33 << 20)}}, {}, deadline_s=10)
    assert refused.value.code == "too_large"


def test_equal_requests_run_once_and_get_equal_answers(serve, tmp_path):
    log = tmp_path / "log"
    server = serve()
    payload = msgspec.json.encode(
        {"id": "same", "problem": {}, "deadline_s": 20, "options": {"for_s": 0.3, "x": 5, "log": str(log)}}
    )
    with server.client() as client, ThreadPoolExecutor(5) as threads:
        client._pick(set(), time.monotonic() + 5)
        answers = list(threads.map(lambda _: raw(client, server.name, "solve", payload), range(5)))
        answers.append(raw(client, server.name, "solve", payload))  # after it ended: from the store
        later = raw(client, server.name, "solve", payload.replace(b'"deadline_s":20', b'"deadline_s":21'))
        other = raw(client, server.name, "solve", payload.replace(b'"x":5', b'"x":6'))
    assert later == answers[0], "the deadline is not part of what is asked"
    assert answers == [("ok", {"id": "same", "square": 25})] * 6
    assert log.read_text().split()[::2] == ["same"]
    assert other[0] == "error" and other[1]["code"] == "id_reused"


def test_a_deadline_is_answered_in_time_even_by_deaf_work_and_in_the_queue(serve):
    with serve(workers=1).client() as client, ThreadPoolExecutor(2) as threads:
        ask(client)  # the worker is up
        began = time.monotonic()
        deaf = threads.submit(ask, client, deadline_s=0.5, for_s=LONG, deaf=True)
        time.sleep(0.1)
        queued = threads.submit(ask, client, deadline_s=0.2, for_s=0.0)
        for job in (queued, deaf):
            with pytest.raises(ServiceError) as refused:
                job.result()
            assert refused.value.code == "deadline"
        assert time.monotonic() - began < LONG  # nobody waited for the work
        assert ask(client, x=2)["square"] == 4


def test_a_cancelled_job_ends_at_once_whether_it_runs_or_waits(serve):
    with serve(workers=1).client() as client, ThreadPoolExecutor(2) as threads:
        ask(client)
        jobs = [threads.submit(ask, client, identifier=name, for_s=LONG) for name in ("one", "two")]
        time.sleep(0.3)
        began = time.monotonic()
        assert client.cancel("two") and client.cancel("one") and not client.cancel("three")
        for job in jobs:
            with pytest.raises(ServiceError) as refused:
                job.result()
            assert refused.value.code == "cancelled"
        assert time.monotonic() - began < LONG


def test_a_job_is_tried_again_once_when_its_worker_dies(serve, tmp_path):
    log, poison = tmp_path / "log", tmp_path / "poison"
    poison.touch()
    with serve(workers=1).client() as client:
        answer = ask(client, x=4, die_if=str(poison), die_once=True, log=str(log))
        assert answer["square"] == 16
        assert len(log.read_text().split()) == 4, "two attempts"
        poison.touch()
        with pytest.raises(ServiceError) as refused:
            ask(client, die_if=str(poison))
        assert refused.value.code == "worker_died"
        assert ask(client, x=3)["square"] == 9


def test_jobs_survive_that_all_workers_are_killed(serve):
    server = serve(workers=2)
    with server.client() as client, ThreadPoolExecutor(4) as threads:
        ask(client)
        jobs = [threads.submit(ask, client, x=x, for_s=0.5) for x in range(4)]
        time.sleep(0.25)
        for worker in server.workers():
            os.kill(worker, signal.SIGKILL)
        assert [job.result()["square"] for job in jobs] == [0, 1, 4, 9]


def test_an_exception_in_the_work_is_told_and_the_worker_goes_on(serve):
    with serve(workers=1).client() as client:
        for options, code in (({"raise": True}, "failed"), ({"refuse": True}, "forbidden")):
            with pytest.raises(ServiceError, match="on purpose") as refused:
                ask(client, **options)
            assert refused.value.code == code
        assert ask(client, x=3)["square"] == 9


def test_a_full_queue_says_busy_and_when_to_ask_again(serve):
    server = serve(workers=1, bound=1)
    with server.client(patience_s=0.5) as client, ThreadPoolExecutor(3) as threads:
        ask(client)
        jobs = []
        for name in ("one", "two"):
            jobs.append(threads.submit(ask, client, identifier=name, for_s=2.0))
            time.sleep(0.2)
        with pytest.raises(ServiceError) as refused:
            ask(client)
        assert refused.value.code == "busy" and refused.value.retry_after_s
        assert [job.result()["square"] for job in jobs] == [0, 0]


def test_progress_arrives(serve):
    seen = []
    with serve(workers=1).client() as client:
        client.solve(lambda _: {}, {"for_s": 0.3}, deadline_s=10, on_progress=seen.append)
    assert len(seen) >= 3 and seen[0]["doing"] == "waiting"


def test_two_clients_get_their_own_answers(serve):
    server = serve(workers=2)
    with server.client() as one, server.client() as other, ThreadPoolExecutor(16) as threads:
        jobs = [threads.submit(ask, client, x=x, for_s=0.01) for x in range(30) for client in (one, other)]
        assert [job.result()["square"] for job in jobs] == [x * x for x in range(30) for _ in range(2)]


def works(client: Client, server: Running) -> bool:
    """Whether a server says that a job is under way."""
    status = client.status(server.name)
    return status is not None and status.running > 0


def test_sigterm_finishes_what_runs_and_turns_new_requests_away(serve):
    server = serve(workers=1)
    with server.client(patience_s=0.5) as client, ThreadPoolExecutor(1) as threads:
        ask(client)
        job = threads.submit(ask, client, x=6, for_s=1.0)
        until = time.monotonic() + 10
        while time.monotonic() < until and not works(client, server):
            time.sleep(0.02)
        server.process.terminate()
        assert job.result()["square"] == 36
        assert server.process.wait(10) == 0
        with pytest.raises(ServiceError) as refused:
            ask(client)
        assert refused.value.code == "unavailable"


def test_workers_do_not_outlive_a_killed_server(serve):
    server = serve(workers=2)
    with server.client() as client:
        ask(client)
        workers = server.workers()
        assert len(workers) == 2
        server.process.kill()
        server.process.wait()
        until = time.monotonic() + 5
        while time.monotonic() < until and any(map(alive, workers)):
            time.sleep(0.05)
        assert not any(map(alive, workers))


def alive(process: int) -> bool:
    """Whether a process exists (and is no zombie)."""
    try:
        with open(f"/proc/{process}/stat") as stat:
            return stat.read().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False


def test_a_request_is_answered_by_the_other_server_when_its_own_is_killed(serve):
    first = serve(workers=1)
    second = serve(workers=1)
    client = Client(client_config([first.endpoint, second.endpoint]))
    with client, ThreadPoolExecutor(1) as threads:
        until = time.monotonic() + 5
        while len(client.servers()) < 2 and time.monotonic() < until:
            time.sleep(0.02)
        job = threads.submit(ask, client, x=8, for_s=1.5)
        time.sleep(0.5)
        busy = next(s for s in (first, second) if running(client, s))
        busy.process.kill()
        assert job.result()["square"] == 64


def running(client: Client, server: Running) -> bool:
    """Whether a server has a job."""
    status = client.status(server.name)
    return status is not None and status.running > 0


def test_without_a_server_the_client_gives_up_when_its_patience_ends():
    began = time.monotonic()
    client = Client(client_config([free_endpoint()]), patience_s=1.0)
    with client, pytest.raises(ServiceError) as refused:
        ask(client)
    assert refused.value.code == "unavailable"
    assert 1.0 <= time.monotonic() - began < LONG


def test_stored_outcomes_are_bounded_by_bytes(serve, tmp_path):
    """The store of the test server holds 100,000 bytes; 300 answers are more, and the oldest are run again."""
    server, log = serve(workers=1), tmp_path / "log"
    with server.client() as client:
        for k in range(300):
            ask(client, identifier=f"job{k}", log=str(log))
        ask(client, identifier="job299", log=str(log))
        ask(client, identifier="job0", log=str(log))
    assert log.read_text().split()[::2].count("job299") == 1
    assert log.read_text().split()[::2].count("job0") == 2
