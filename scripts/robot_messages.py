"""Writes the JSON schema of the messages between an executor and a robot server, from the classes that read them.

python -m scripts.robot_messages
"""

import json
from inspect import cleandoc
from pathlib import Path
from typing import Any

import msgspec

from kabo.remote import messages
from kabo.service import ErrorReply

FILE = Path(__file__).resolve().parents[1] / "kabo" / "remote" / "schemas" / "kabo-robot-1.schema.json"
KINDS = (
    messages.TakeMessage,
    messages.TakenMessage,
    messages.DriverMessage,
    messages.MotionMessage,
    messages.HandMessage,
    messages.PaceMessage,
    messages.PacedMessage,
    messages.LookMessage,
    messages.LookedMessage,
    messages.StateMessage,
    ErrorReply,
)


def schema() -> dict[str, Any]:
    """The schema: any message is one of its definitions."""
    found, definitions = msgspec.json.schema_components(KINDS, ref_template="#/$defs/{name}")
    head = {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": messages.PROTOCOL}
    # Before 0.23 msgspec kept the indentation of docstrings.
    defined = {
        name: {**each, "description": cleandoc(each["description"])} if "description" in each else each
        for name, each in definitions.items()
    }
    return {**head, "anyOf": list(found), "$defs": defined}


def main() -> None:
    """Writes the file."""
    FILE.parent.mkdir(exist_ok=True)
    FILE.write_text(json.dumps(schema(), indent=2, ensure_ascii=False) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
