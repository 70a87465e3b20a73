"""How time and memory grow with the mesh, what compiling costs, and what is said of meshes that cannot be used.

Every figure of growth comes from a process of its own, `python geometry_growth.py …`, so that one mesh's peak memory
is not another's.
"""

import json
import os
import subprocess
import sys
import tempfile
from math import log
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

import numpy as np
import trimesh
from geometry_bounding import SHARE, Triangles, warm_up
from geometry_chart import write_chart
from table import Table

HERE = Path(__file__).resolve()
MEMORY_BAR, CONE_BAR, COMPILE_BAR = 25.0, 1.0, 60.0  # MB for 10,000 vertices; seconds; seconds


# Growth -------------------------------------------------------------------------------------------------------------


def sphere(level: int) -> Triangles:
    """An icosphere of 20 · 4^level triangles."""
    made = trimesh.creation.icosphere(subdivisions=level, radius=0.5)
    return Triangles(np.asarray(made.vertices), np.asarray(made.faces))


def ring(triangles: int) -> Triangles:
    """A torus of about so many triangles, twice as many around as across."""
    across = max(3, round((triangles / 4) ** 0.5))
    around = 2 * across
    u, v = np.meshgrid(*(2 * np.pi * np.arange(n) / n for n in (around, across)), indexing="ij")
    radius = 0.3 + 0.1 * np.cos(v)
    corners = np.stack([radius * np.cos(u), radius * np.sin(u), 0.1 * np.sin(v)], axis=-1).reshape(-1, 3)
    i, k = np.divmod(np.arange(around * across), across)
    a, b = i * across + k, (i + 1) % around * across + k
    c, d = (i + 1) % around * across + (k + 1) % across, i * across + (k + 1) % across
    return Triangles(corners, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]))


def cone(degree: int) -> Triangles:
    """A cone whose apex has so many neighbours."""
    angle = 2 * np.pi * np.arange(degree) / degree
    rim = np.stack([0.1 * np.cos(angle), 0.1 * np.sin(angle), 0 * angle], axis=1)
    i = np.arange(degree)
    j, apex, foot = (i + 1) % degree, 0 * i + degree, 0 * i + degree + 1
    faces = np.concatenate([np.stack([i, j, apex], 1), np.stack([j, i, foot], 1)])
    return Triangles(np.concatenate([rim, [[0, 0, 0.2], [0, 0, 0]]]), faces)


def growth_tables(output: Path, largest: float) -> list[Table]:
    """Spheres and tori up to so many triangles, with and without certificate; cones; a chart of the seconds."""
    table = Table(
        "Growth: epsilon = 1 % of the diagonal, outer if not said, a process each; seconds of the processor"
    )
    shapes = [("icosphere", sphere(level)) for level in range(3, 9) if 20 * 4**level <= 1.4 * largest]
    shapes += [("torus", ring(10**power)) for power in range(3, 7) if 10**power <= largest]
    for name, mesh in shapes:
        for certify in (True, False):
            label = f"{name}{'' if certify else ', plain'}"
            table.add(label, triangles=len(mesh.faces), **_alone(mesh, certify))
    fans = [(degree, side) for degree in (400, 800) for side in ("outer", "inner")]
    for degree, side in fans:
        label = f"cone, apex of degree {degree}, {side}"
        table.add(label, triangles=2 * degree, **_alone(cone(degree), True, side))
    lines = {
        label: [(row["triangles"], row["seconds"]) for row in table.rows if row[""] == label]
        for label in dict.fromkeys(row[""] for row in table.rows[: -len(fans)])
    }
    if largest > 1e3:
        write_chart(output / "growth.svg", "Bounding meshes at 1 %", "triangles", "seconds", lines)
    return [table, _growth_bars(table, lines)]


def _growth_bars(table: Table, lines: dict[str, list[tuple[float, float]]]) -> Table:
    bars = Table("Growth: what must be reached")
    for label, points in lines.items():
        exponent = slope([p for p in points if p[0] > 4000])
        if exponent is not None:
            bars.add(f"{label}: seconds grow with triangles to the", bar="about 1", found=exponent)
    large = [row for row in table.rows if row["triangles"] > 1e4]
    if large:
        worst = max(row["MB / 10,000 vertices"] for row in large)
        met = "yes" if worst <= MEMORY_BAR else "NO"
        bars.add("MB for 10,000 vertices, above 10,000 triangles", bar=f"<= {MEMORY_BAR}", found=worst, met=met)
    cones = {row[""].split(maxsplit=4)[-1]: row["seconds"] for row in table.rows if row[""].startswith("cone")}
    for side in ("outer", "inner"):
        seconds, double = cones[f"400, {side}"], cones[f"800, {side}"]
        met = "yes" if seconds < CONE_BAR else "NO"
        bars.add(f"seconds for the cone of degree 400, {side}", bar=f"< {CONE_BAR}", found=seconds, met=met)
        bars.add(f"cone of degree 800 to that of 400, {side}", bar="about 2", found=double / seconds)
    return bars


def slope(points: list[tuple[float, float]]) -> float | None:
    """The exponent of growth: least squares over the logarithms; None for less than two points."""
    if len(points) < 2:
        return None
    x, y = (np.array([log(point[i]) for point in points]) for i in (0, 1))
    return float(np.polyfit(x, y, 1)[0])


def _alone(mesh: Triangles, certify: bool, side: str = "outer") -> dict[str, Any]:
    with tempfile.TemporaryDirectory() as folder:
        for name in ("vertices", "faces"):
            np.save(Path(folder) / f"{name}.npy", getattr(mesh, name))
        return _process("measure", folder, "certified" if certify else "plain", side)


def _process(*arguments: str, **environment: str) -> dict[str, Any]:
    answer = subprocess.run(
        [sys.executable, HERE, *arguments],
        stdout=subprocess.PIPE,
        text=True,
        check=True,
        env={**os.environ, **environment},
    )
    return json.loads(answer.stdout.splitlines()[-1])


def measure(folder: str, how: str, side: str) -> dict[str, Any]:
    """Processor's time and memory of one mesh in this process, which has not seen another, on top of the libraries."""
    from kabo.geometry import bounding_mesh

    warm_up()
    Path("/proc/self/clear_refs").write_text("5")  # the peak starts anew
    before = _memory("VmRSS")
    mesh = Triangles(*(np.load(Path(folder) / f"{name}.npy") for name in ("vertices", "faces")))
    began = process_time()
    result = bounding_mesh(mesh, SHARE * mesh.diagonal, side, certify=how == "certified")
    seconds = process_time() - began
    used = _memory("VmHWM") - before
    return {
        "V": len(result.vertices),
        "H kabo": result.hausdorff_upper_bound / result.epsilon if how == "certified" else None,
        "seconds": seconds,
        "contr./s": result.contractions / seconds,
        "MB": used,
        "MB / 10,000 vertices": used / len(mesh.vertices) * 1e4,
    }


def _memory(name: str) -> float:
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) / 1024 for line in lines if line.startswith(name + ":"))


# Compiling ----------------------------------------------------------------------------------------------------------


def compile_table() -> Table:
    """The same small tasks in a fresh process, with an empty cache and again with what it compiled."""
    table = Table(
        f"Compiling: seconds of a fresh process; the bar is < {COMPILE_BAR:g} s that compiling adds of the processor's time"
    )
    with tempfile.TemporaryDirectory() as folder:
        cold, warm = (_process("stages", f"{folder}/parts {turn}", KABO_CACHE=folder) for turn in (1, 2))
    sums = dict.fromkeys(("cold", "warm", "adds", "cold, processor's", "adds, processor's"), 0.0)
    for stage, (seconds, busy) in cold.items():
        again, busy_again = warm[stage]
        row = {
            "cold": seconds,
            "warm": again,
            "adds": seconds - again,
            "cold, processor's": busy,
            "adds, processor's": busy - busy_again,
        }
        table.add(stage, **row)
        sums = {name: sums[name] + value for name, value in row.items()}
    table.add("in total", **sums, met="yes" if sums["adds, processor's"] < COMPILE_BAR else "NO")
    return table


def stages(folder: str) -> dict[str, tuple[float, float]]:
    """Seconds by the clock and of the processor of each small task, in this order, once."""
    from geometry_predicates import small_predicates

    from kabo import geometry

    mesh, block = sphere(1), trimesh.creation.box([0.1, 0.2, 0.3])
    box = Triangles(np.asarray(block.vertices), np.asarray(block.faces))
    tasks: dict[str, Any] = {
        "bounding mesh": warm_up,
        "bounding mesh, an icosphere": lambda: geometry.bounding_mesh(mesh, 0.05),
        "crossing faces": lambda: geometry.crossing_faces(mesh.vertices, mesh.faces),
        "Hausdorff bound": lambda: geometry.hausdorff_bound(
            mesh.vertices, mesh.faces, mesh.vertices * 1.1, mesh.faces
        ),
        "bounding decomposition": lambda: geometry.bounding_decomposition(box, 0.01, cache=Path(folder)),
        **small_predicates(),
    }
    found = {}
    for name, task in tasks.items():
        began, busy = perf_counter(), process_time()
        task()
        found[name] = (perf_counter() - began, process_time() - busy)
    return found


if __name__ == "__main__":
    task, *rest = sys.argv[1:]
    print(json.dumps(measure(*rest) if task == "measure" else stages(*rest)))
