"""What is lost is asked for again, with the same id, and worked on once: frozen servers, ends, strangers."""

import os
import signal
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import pytest
import zenoh

from kabo.errors import ServiceError
from kabo.service import Client, client_config, keys, server_config
from kabo.service.session import open_session
from tests.service.conftest import free_endpoint
from tests.service.test_server import ask


@pytest.mark.parametrize("job_s", [1.0, 9.0])  # over before the server goes on, or not
def test_a_request_over_a_frozen_server_is_worked_on_once(serve, tmp_path, job_s):
    """7 s are longer than the lease of 4 s: the client has lost the server, and finds it again."""
    server, log = serve(workers=1), tmp_path / "log"
    with server.client() as client, ThreadPoolExecutor(1) as threads:
        ask(client)
        job = threads.submit(ask, client, deadline_s=60.0, x=6, for_s=job_s, log=str(log))
        until = time.monotonic() + 20
        while not log.exists() and time.monotonic() < until:
            time.sleep(0.01)
        os.kill(server.process.pid, signal.SIGSTOP)
        try:
            time.sleep(7)
        finally:
            os.kill(server.process.pid, signal.SIGCONT)
        assert job.result()["square"] == 36
    assert len(log.read_text().split()) == 2, "one attempt"


def test_a_job_that_has_its_answer_cannot_be_cancelled(serve):
    with serve(workers=1).client() as client:
        ask(client, identifier="done")
        assert not client.cancel("done")


def test_a_server_that_is_not_one_of_kabos_is_no_answer():
    endpoint, seen = free_endpoint(), threading.Event()

    def nonsense(query: zenoh.Query) -> None:
        seen.set()
        with query:
            query.reply(query.key_expr, b"\xff hello", encoding="application/json")

    session = open_session(server_config([endpoint]))
    try:
        queryable = session.declare_queryable(keys.verb("other", "*"), nonsense)
        token = session.liveliness().declare_token(keys.verb("other", "alive"))
        with Client(client_config([endpoint]), patience_s=1.0) as client:
            with pytest.raises(ServiceError) as refused:
                ask(client, deadline_s=2.0)
            assert client.status("other") is None and not client.cancel("id")
        assert seen.is_set() and refused.value.code == "unavailable"
        token.undeclare()
        queryable.undeclare()
    finally:
        session.close()
