"""The log of a run in the view document: its records as they are, and what is needed to show states on the stage."""

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from kabo.errors import Diagnostic, InputError
from kabo.viewer.content.document import View, ViewDocument
from kabo.viewer.content.given import ViewOptions, document_of_file

LOG_SUFFIX = ".jsonl"
ENDS = ("goal", "stopped")  # the last event of a run
Record = dict[str, Any]


def is_log(path: Path) -> bool:
    """Whether a file is the log of a run, by its name."""
    return path.suffix.lower() == LOG_SUFFIX


def read_log(path: Path) -> list[Record]:
    """The records of a log; the last line of one that is still being written may be incomplete, and is left out.

    Raises:
        InputError: a line is no record.
        OSError: the file cannot be opened.
    """
    return records_of(path.read_bytes(), str(path))[0]


def records_of(content: bytes, file: str, line: int = 1) -> tuple[list[Record], int]:
    """The records of all complete lines of a part of a log, and how many bytes these lines have.

    Args:
        content: the part.
        file: the name of the file, and `line` the number of its first line, for messages.

    Raises:
        InputError: a line is no record.
    """
    whole = content[: content.rfind(b"\n") + 1]
    records = []
    for number, text in enumerate(whole.splitlines(), line):
        try:
            record = json.loads(text, parse_constant=_refuse)
        except (ValueError, RecursionError):
            record = None
        if not _is_record(record):
            hint = "a log is written by kabo execute -o FILE"
            raise InputError([Diagnostic(file, number, 1, "this line is no record of a run", hint)])
        records.append(record)
    return records, len(whole)


def _is_record(record: Any) -> bool:
    return (
        isinstance(record, dict)
        and isinstance(record.get("event"), str)
        and isinstance(record.get("time"), (int, float))
    )


def _refuse(word: str) -> float:
    raise ValueError(word)


def has_ended(records: Sequence[Record]) -> bool:
    """Whether the run of a log has ended."""
    return bool(records) and records[-1]["event"] in ENDS


def document_of_run(
    records: Sequence[Record], title: str, plan: Path | None = None, options: ViewOptions | None = None
) -> ViewDocument:
    """The view document of a run: its log, beside its plan and scene if the plan is given.

    Args:
        records: of the log.
        title: of the page, without a plan.
        plan: the plan file.
        options: of the plan: its problem and domain.

    Raises:
        InputError: the plan or its problem cannot be shown.
        OSError: a file cannot be opened.
    """
    if plan is None:
        return ViewDocument(title, "run", run=run_view(records))
    made = document_of_file(plan, options)
    if made.plan is None:
        raise InputError([Diagnostic(str(plan), 1, 1, "this is no plan: a run is one of a plan", None)])
    return replace(made, given="run", run=run_view(records))


def run_view(records: Sequence[Record], live: str | None = None) -> View:
    """The part `run` of a view document: records, and where a page asks for more of them."""
    return {"records": list(records), "live": live}
