"""The certificate in the plan's file: each body's name once, vertices and axes as base64 of little-endian numbers."""

import base64
import binascii
import re
from dataclasses import replace
from typing import Any

from kabo.plan.certificate import BodyParts, Certificate, Clearance, PairProof, StretchProof
from kabo.plan.checked_json import JsonValue

WALK = re.compile(r"[baetfs]+")
_ID = re.compile(r"n(0|[1-9][0-9]*)")
_HASH = re.compile(r"sha256:[0-9a-f]{64}")


def certificate_to_json(certificate: Certificate) -> dict[str, Any]:
    """The certificate as JSON values."""
    result: dict[str, Any] = {
        "epsilon": certificate.epsilon + 0.0,
        "segments": [_clearance_json(entry) for entry in certificate.segments],
    }
    if certificate.near is None:
        return result
    names = {name for proof in certificate.proofs for pair in proof.pairs for name in (pair.first, pair.second)}
    things = sorted(names)
    index = {name: i for i, name in enumerate(things)}
    bodies = {
        digest: {"sizes": list(parts.sizes), "vertices": _text(parts.vertices)}
        | ({"rounds": _text(parts.rounds)} if parts.rounds else {})
        for digest, parts in certificate.bodies.items()
    }
    proofs = [
        {
            "node": proof.node,
            "segments": list(proof.segments),
            "pairs": [[index[p.first], index[p.second], p.place, p.walk, _text(p.axes)] for p in proof.pairs],
        }
        | ({"before": list(proof.before), "cut": proof.cut} if proof.before else {})
        for proof in certificate.proofs
    ]
    return {**result, "near": certificate.near + 0.0, "bodies": bodies, "things": things, "proofs": proofs}


def certificate_from_json(place: JsonValue) -> Certificate:
    """The certificate of a JSON value; faults of its form are added to the findings."""
    proof_keys = ("near", "bodies", "things", "proofs")
    fields = place.fields(("epsilon", "segments"), proof_keys)
    epsilon, segments = fields["epsilon"].number(), tuple(map(_clearance, fields["segments"].items()))
    given = [key for key in proof_keys if key in fields]
    if not given:
        return Certificate(epsilon, segments)
    if len(given) < len(proof_keys):
        place.add_finding(
            f'"{given[0]}" needs {", ".join(key for key in proof_keys if key not in given)} beside it'
        )
        return Certificate(epsilon, segments)
    near = fields["near"].number()
    if near <= 0.0:
        fields["near"].expected("a distance above 0")
    bodies = {name: _body(name, value) for name, value in fields["bodies"].mapping().items()}
    things = [entry.text() for entry in fields["things"].items()]
    proofs = tuple(_stretch(entry, things) for entry in fields["proofs"].items())
    return Certificate(epsilon, segments, near, bodies, proofs)


def _clearance_json(entry: Clearance) -> dict[str, Any]:
    return {
        "node": entry.node,
        "segment": entry.segment,
        "clearance": None if entry.clearance is None else float(entry.clearance) + 0.0,
        "between": None if entry.between is None else list(entry.between),
        "permitted": [list(pair) for pair in entry.permitted],
    }


def _text(content: bytes) -> str:
    return base64.b64encode(content).decode("ascii")


def _node(place: JsonValue) -> str:
    name = place.text()
    if isinstance(place.value, str) and not _ID.fullmatch(name):
        place.add_finding(f'"{name}" is no node id', "ids are n0, n1, …")
    return name


def _clearance(place: JsonValue) -> Clearance:
    fields = place.fields(("node", "segment", "clearance", "between", "permitted"))
    clearance, between = fields["clearance"], fields["between"]
    return Clearance(
        node=_node(fields["node"]),
        segment=fields["segment"].index(),
        clearance=None if clearance.value is None else clearance.number(),
        between=None if between.value is None else _names(between),
        permitted=tuple(_names(entry) for entry in fields["permitted"].items()),
    )


def _names(place: JsonValue) -> tuple[str, str]:
    names = [entry.text() for entry in place.items(exactly=2)]
    return (names[0], names[1]) if len(names) == 2 else ("", "")


def _bytes(place: JsonValue, multiple: int) -> bytes:
    text = place.text()
    try:
        content = base64.b64decode(text, validate=True)
    except (binascii.Error, ValueError):
        place.add_finding("this is not base64")
        return b""
    if len(content) % multiple:
        place.add_finding(f"{len(content)} bytes are no whole number of entries of {multiple} bytes")
        return b""
    return content


def _body(name: str, place: JsonValue) -> BodyParts:
    if not _HASH.fullmatch(name):
        place.add_finding(f'"{name}" is no hash', "sha256: and 64 hexadecimal digits")
    fields = place.fields(("sizes", "vertices"), ("rounds",))
    sizes = tuple(entry.index() for entry in fields["sizes"].items(1))
    vertices = _bytes(fields["vertices"], 24)
    if 24 * sum(sizes) != len(vertices):
        place.add_finding(f"{len(vertices) // 24} vertices, but {sum(sizes)} by their sizes")
    rounds = _bytes(fields["rounds"], 40) if "rounds" in fields else b""
    if "rounds" in fields and len(rounds) != 40 * len(sizes):
        place.add_finding(f"{len(rounds) // 40} roundings, but {len(sizes)} parts")
    return BodyParts(sizes, vertices, rounds)


def _stretch(place: JsonValue, things: list[str]) -> StretchProof:
    fields = place.fields(("node", "segments", "pairs"), ("before", "cut"))
    segments = tuple(entry.index() for entry in fields["segments"].items(1))
    pairs = tuple(_pair(entry, things) for entry in fields["pairs"].items())
    proof = StretchProof(_node(fields["node"]), segments, pairs)
    if "before" not in fields and "cut" not in fields:
        return proof
    if "before" not in fields or "cut" not in fields:
        place.add_finding('"before" and "cut" stand together, or neither does')
        return proof
    before, cut = tuple(entry.index() for entry in fields["before"].items(1)), fields["cut"].index()
    if cut < 1:
        fields["cut"].expected("a number of parts above 0")
    return replace(proof, before=before, cut=cut)


def _pair(place: JsonValue, things: list[str]) -> PairProof:
    entries = place.items(exactly=5)
    if len(entries) != 5:
        return PairProof("", "", 0, "b", b"")
    first, second, which, walk, axes = entries
    for entry in (first, second):
        if entry.index() >= len(things):
            entry.add_finding(f"there are {len(things)} things")
            return PairProof("", "", 0, "b", b"")
    letters = walk.text()
    if not WALK.fullmatch(letters):
        walk.expected("letters of a walk: b, a, e, t, f, s")
    content, least = _bytes(axes, 2), 6 * letters.count("a") + 24 * letters.count("e")
    if len(content) != least:
        axes.add_finding(f"{len(content)} bytes for axes that need {least}")
    return PairProof(things[first.index()], things[second.index()], which.index(), letters, content)
