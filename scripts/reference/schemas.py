"""The keys of what kabo writes, from the JSON schemas of kabo/plan/schemas."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from scripts.reference.markdown import code, plain, table

FOLDER = Path(__file__).resolve().parent.parent.parent / "kabo" / "plan" / "schemas"
Schema = dict[str, Any]


def sections() -> str:
    """A section for the newest schema of each name: its keys, and those of each definition."""
    newest = {path.name.split(".")[0].rsplit("-", 1)[0]: path for path in sorted(FOLDER.glob("*.schema.json"))}
    return "\n\n" + "\n\n".join(map(section, newest.values())) + "\n\n"


def section(path: Path) -> str:
    """The section of one format."""
    schema = json.loads(path.read_text())
    name = path.name.removesuffix(".schema.json")
    parts = [f"## {name}", f"The schema is `{path.relative_to(FOLDER.parent.parent.parent)}`."]
    if rows := list(keys(schema, "")):
        parts.append(table(("key", "needed", "type", "meaning"), rows))
    for definition, inner in schema.get("$defs", {}).items():
        if rows := list(keys(inner, "")):
            parts += [
                f"### {name}: {definition.replace('_', ' ')}",
                table(("key", "needed", "type", "meaning"), rows),
            ]
    return "\n\n".join(parts)


def keys(schema: Schema, prefix: str) -> Iterator[tuple[str, str, str, str]]:
    """The keys of an object and of the objects in it: path, whether it must be there, type, meaning."""
    for kind in ("oneOf", "anyOf"):
        for variant in schema.get(kind, ()):
            fixed = [code(each["const"]) for each in variant.get("properties", {}).values() if "const" in each]
            if fixed and variant.get("properties"):
                yield f"*{', '.join(fixed)}*", "", "", ""
            yield from keys(variant, prefix)
    needed = set(schema.get("required", ()))
    for name, value in schema.get("properties", {}).items():
        path = f"{prefix}{name}"
        yield code(path), "required" if name in needed else "", kind_of(value), plain(value.get("description", ""))
        yield from inner_keys(value, path)
    if isinstance(values := schema.get("additionalProperties"), dict) and not prefix:
        yield from keys(values, "NAME.")


def inner_keys(value: Schema, path: str) -> Iterator[tuple[str, str, str, str]]:
    """The keys below a key: of an object, of the values of a mapping, of the items of a list."""
    if "properties" in value or "oneOf" in value or "anyOf" in value:
        yield from keys(value, f"{path}.")
    if isinstance(values := value.get("additionalProperties"), dict):
        yield from inner_keys(values, f"{path}.NAME")
    if isinstance(items := value.get("items"), dict):
        yield from inner_keys(items, f"{path}[]")


def kind_of(value: Schema) -> str:
    """The type of a value in words."""
    if "const" in value:
        return code(json.dumps(value["const"]))
    if "enum" in value:
        return ", ".join(code(json.dumps(each)) for each in value["enum"])
    if "$ref" in value:
        return value["$ref"].rpartition("/")[2].replace("_", " ")
    if variants := value.get("oneOf") or value.get("anyOf"):
        return " or ".join(dict.fromkeys(kind_of(each) for each in variants))
    named = value.get("type", "any value")
    if isinstance(named, list):
        return " or ".join(named)
    return (
        f"list of {kind_of(value['items'])}"
        if named == "array" and isinstance(value.get("items"), dict)
        else named
    )
