"""Errors as they travel: between processes nothing of them may be lost."""

import pickle

from kabo.errors import Diagnostic, InputError, MeshError, ServiceError, did_you_mean


def test_input_errors_keep_their_findings_on_the_way_to_another_process() -> None:
    findings = [Diagnostic("b.yaml", 2, 1, "second"), Diagnostic("a.yaml", 9, 4, "first", "a remedy")]
    for kind in (InputError, MeshError):
        error = kind(findings)
        arrived = pickle.loads(pickle.dumps(error))
        assert type(arrived) is kind
        assert arrived.diagnostics == error.diagnostics == (findings[1], findings[0])
        assert str(arrived) == str(error)


def test_service_errors_keep_code_request_and_when_to_ask_again() -> None:
    error = ServiceError("busy", "all workers are busy", request="r1", retry_after_s=2.0)
    arrived = pickle.loads(pickle.dumps(error))
    assert (arrived.code, str(arrived), arrived.request, arrived.retry_after_s) == (
        "busy",
        "all workers are busy",
        "r1",
        2.0,
    )


def test_a_word_that_differs_in_case_alone_is_the_one_that_was_meant() -> None:
    assert did_you_mean("moveto", ["move", "MoveTo"]) == 'did you mean "MoveTo"?'
