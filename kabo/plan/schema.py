"""The JSON Schemas of the formats, shipped with the package: `kabo-plan-2`, `kabo-result-1` and others."""

import json
from importlib import resources
from typing import Any


def schema(name: str) -> dict[str, Any]:
    """The JSON Schema of a format, such as `kabo-plan-2`.

    Raises:
        FileNotFoundError: kabo has no format of this name.
    """
    text = (
        resources.files("kabo.plan")
        .joinpath("schemas")
        .joinpath(f"{name}.schema.json")
        .read_text(encoding="utf-8")
    )
    content: dict[str, Any] = json.loads(text)
    return content
