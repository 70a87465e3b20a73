"""Checks of mesh files before they are parsed: announced sizes that the file cannot hold, shapes that would be lost.

A header of a few bytes can announce 10^9 triangles. Each rule of size is a lower bound of the bytes that the
announced numbers need; a file that is shorter is cut off or wrong, whatever its reader would make of it. Readers
also skip shapes that they do not know, such as strips of triangles, without an error; an incomplete mesh is worse
than none.
"""

import json
import re
import struct
from collections.abc import Callable
from dataclasses import dataclass
from xml.etree import ElementTree  # noqa: S405  only files without entities are read

from kabo.meshes.mesh import Faces, Vertices
from kabo.meshes.plain_off import plain_triangles
from kabo.meshes.plain_stl import HEADER, TRIANGLE, announced, binary_triangles, is_text

_PLY_BYTES = {
    **dict.fromkeys(("char", "uchar", "int8", "uint8"), 1),
    **dict.fromkeys(("short", "ushort", "int16", "uint16"), 2),
    **dict.fromkeys(("int", "uint", "int32", "uint32", "float", "float32"), 4),
    **dict.fromkeys(("double", "float64", "int64", "uint64"), 8),
}
_GLB_ITEMS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
_GLB_BYTES = {5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4}
_MAX_INSTANCES = 100_000
_DAE_UNREAD = ("trifans", "tristrips", "ph", "instance_controller")
_GLB_UNREAD = ("KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_mesh_quantization")


def misleading(kind: str, data: bytes) -> str | None:
    """The reason why a file must not be read, as the end of a sentence that begins with the file's name; else None."""
    if not data.strip(b"\x00 \t\r\n"):
        return "is empty"
    return MESH_FORMATS[kind].check(data)


def _more(announced: str, data: bytes) -> str:
    return f"announces {announced}, more than its {_spaced(len(data))} bytes can hold"


def _spaced(number: int) -> str:
    return f"{number:,}".replace(",", " ")


def _stl(data: bytes) -> str | None:
    if is_text(data):
        lowered = data.lower()
        loops, ended = lowered.count(b"facet normal"), lowered.count(b"endfacet")
        corners = len(re.findall(rb"vertex\s+\S+\s+\S+\s+\S+", lowered))
        whole = loops == ended and corners == 3 * loops and b"endsolid" in lowered
        return None if whole else f"is cut off or damaged: {loops} facets begin, {ended} end, {corners} vertices"
    if len(data) < HEADER:
        return f"is cut off: its {len(data)} bytes are fewer than the header of a binary STL, and it is no text"
    count = announced(data)
    needed = HEADER + TRIANGLE * count
    if needed > len(data):
        return _more(f"{_spaced(count)} triangles", data)
    return (
        None if needed == len(data) else f"holds {len(data) - needed} bytes more than its {count} triangles need"
    )


def _ply(data: bytes) -> str | None:
    head, found, body = data.partition(b"end_header")
    if not found or not head.lstrip().startswith(b"ply"):
        return "has no whole PLY header"
    text = b"format ascii" in head
    count, needed, row = 0, 0, 0
    for line in [*head.decode("latin-1").splitlines(), "element none 0"]:
        words = line.split()
        if words[:1] == ["element"]:
            needed += count * row
            row = 0
            if len(words) != 3 or not re.fullmatch(r"\d{1,15}", words[2]):
                return f'has a PLY header with the line "{line[:60]}"'
            count = int(words[2])
            if count > len(data):
                return _more(f"{_spaced(count)} times {words[1][:20]}", data)
        elif words[:1] == ["property"]:
            listed = words[1:2] == ["list"]
            row += 2 if text else _PLY_BYTES.get(words[2 if listed else 1] if len(words) > 2 else "", 1)
    return (
        f"needs {needed} bytes for what it announces, but is cut off after {len(body)}"
        if needed > len(body) + 2
        else None
    )


def _off(data: bytes) -> str | None:
    lines = [line for row in data.splitlines() if (line := row.split(b"#", 1)[0].strip())]
    if lines[:1] and re.fullmatch(rb"[A-Za-z0-9]*OFF", lines[0], re.IGNORECASE):
        lines = lines[1:]
    found = re.match(rb"(?:C?OFF\s+)?(\d{1,15})\s+(\d{1,15})\b", lines[0]) if lines else None
    if found is None:
        return "has no counts of vertices and triangles in its first lines"
    vertices, faces = map(int, found.groups())
    if 6 * vertices + 8 * faces > len(data):
        return _more(f"{_spaced(vertices)} vertices and {_spaced(faces)} triangles", data)
    rows = len(lines) - 1
    return (
        f"is cut off: {vertices + faces} lines are announced, {rows} are there"
        if rows < vertices + faces
        else None
    )


def _obj(data: bytes) -> str | None:
    """Whether a face names vertex 0: vertices count from 1 (or from -1 backwards), and a reader takes 0 for the last."""
    wrong = re.search(rb"^[ \t]*f[ \t](?:[^\n#]*[ \t])?0+(?:[/\s]|$)", data, re.MULTILINE)
    return "has a face with the vertex 0; they count from 1" if wrong else None


def _glb(data: bytes) -> str | None:
    if len(data) < 20 or data[:4] != b"glTF":
        return "has no GLB header"
    length, first = struct.unpack_from("<I", data, 8)[0], struct.unpack_from("<I", data, 12)[0]
    if length > len(data) or 20 + first > len(data):
        return f"announces {max(length, 20 + first)} bytes, but is cut off after {len(data)}"
    try:
        tree = json.loads(data[20 : 20 + first])
        accessors, nodes = tree.get("accessors", []), tree.get("nodes", [])
        for accessor in accessors:
            size = _GLB_ITEMS.get(accessor.get("type"), 1) * _GLB_BYTES.get(accessor.get("componentType"), 1)
            if "sparse" in accessor:
                return "holds sparse numbers, which kabo does not read"
            if int(accessor["count"]) * size > len(data):
                return _more(f"{_spaced(int(accessor['count']))} numbers", data)
        used = [name for name in _GLB_UNREAD if name in tree.get("extensionsUsed", [])]
        modes = {part.get("mode", 4) for mesh in tree.get("meshes", []) for part in mesh.get("primitives", [])}
        named = [child for node in nodes for child in node.get("children", [])]
    except (ValueError, TypeError, AttributeError, KeyError, RecursionError):
        return "has a GLB header that cannot be understood"
    if used:
        return f"is compressed with {used[0]}, which kabo does not read"
    if 6 in modes:
        return "holds fans of triangles, which kabo does not read"
    return "names a node twice in its tree" if len(named) != len(set(map(str, named))) else None


def _dae(data: bytes) -> str | None:
    """Why a COLLADA file must not be read; nodes may refer to nodes, so a few lines can place any number of meshes."""
    lowered = data.lower()
    if b"<!entity" in lowered:
        return "defines XML entities, which kabo does not read"
    for name in _DAE_UNREAD:
        if re.search(rf"<(?:\w+:)?{name}[\s/>]".encode(), lowered):
            return f"holds <{name}>, which kabo does not read"
    if b"instance_node" not in lowered:
        return None
    try:
        root = ElementTree.fromstring(data)  # noqa: S314  no entities, see above
        placed = _placed(root)
    except (ElementTree.ParseError, ValueError, RecursionError):
        return "is no XML whose nodes can be followed"
    return f"places {placed} meshes by nodes inside nodes" if placed > _MAX_INSTANCES else None


def _placed(root: ElementTree.Element) -> int:
    """How many meshes a COLLADA file places, directly or through nodes that refer to other nodes."""
    nodes = {f"#{node.get('id')}": node for node in root.iter() if node.tag.endswith("}node")}
    known: dict[str, int] = {}

    def below(element: ElementTree.Element, path: tuple[str, ...]) -> int:
        total = 0
        for child in element:
            if child.tag.endswith("}instance_geometry"):
                total += 1
            elif child.tag.endswith("}instance_node"):
                url = child.get("url", "")
                if url in path:
                    raise ValueError("a node stands for itself")
                if url not in known and url in nodes:
                    known[url] = below(nodes[url], (*path, url))
                total += known.get(url, 0)
            elif child.tag.endswith(("}node", "}visual_scene")):
                total += below(child, path)
        return total

    return sum(below(scenes, ()) for scenes in root if scenes.tag.endswith("}library_visual_scenes"))


@dataclass(frozen=True)
class MeshFormat:
    """A file format of meshes: the check of its header and, if trimesh is not to read it, a reader.

    The reader returns vertices and faces, or None for content that trimesh is to read.
    """

    check: Callable[[bytes], str | None]
    read: Callable[[bytes], tuple[Vertices, Faces] | None] | None = None


# The formats that kabo reads, by the ending of their files: a new one needs a line here.
MESH_FORMATS = {
    "dae": MeshFormat(_dae),
    "glb": MeshFormat(_glb),
    "obj": MeshFormat(_obj),
    "off": MeshFormat(_off, plain_triangles),
    "ply": MeshFormat(_ply),
    "stl": MeshFormat(_stl, binary_triangles),
}
