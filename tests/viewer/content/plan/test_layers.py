"""Layouts of random graphs: no two boxes overlap, no edge passes through a box, every edge goes down."""

from collections import Counter

import pytest
from hypothesis import event, given
from hypothesis import strategies as st

from kabo.viewer.content.plan.layers import BETWEEN, Box, Layout, layered

SIZES = st.tuples(st.integers(20, 160), st.integers(16, 60))


@st.composite
def graphs(draw) -> tuple[dict[str, Box], dict[str, list[str]]]:
    """Random acyclic graphs with many merges and long edges; every node but the first is reached."""
    count = draw(st.integers(1, 30))
    names = [f"n{i}" for i in range(count)]
    successors: dict[str, list[str]] = {name: [] for name in names}
    for i in range(1, count):
        for k in draw(st.lists(st.integers(0, i - 1), min_size=1, max_size=4)):
            successors[names[k]].append(names[i])
    boxes = {}
    for name in names:
        width, height = draw(SIZES)
        ends = len(successors[name])
        ports = tuple(width * ((k + 0.5) / ends - 0.5) for k in range(ends))
        boxes[name] = Box(float(width), float(height), ports)
    return boxes, successors


def meets(layout: Layout, first, second) -> list[str]:
    """The boxes whose inside a straight line meets, by clipping it."""
    (x, y), (u, v) = first, second
    found = []
    for name, box in layout.places.items():
        low, high = 0.0, 1.0
        for at, way, start, end in (
            (x, u - x, box.x, box.x + box.width),
            (y, v - y, box.y, box.y + box.height),
        ):
            if way == 0.0:
                if not start + 1e-6 < at < end - 1e-6:
                    high = -1.0
            else:
                near, far = sorted(((start - at) / way, (end - at) / way))
                low, high = max(low, near), min(high, far)
        if high - low > 1e-6:
            found.append(name)
    return found


@given(graph=graphs())
def test_boxes_do_not_overlap_and_edges_go_down_around_them(graph):
    boxes, successors = graph
    layout = layered(boxes, successors)
    entering = Counter(target for targets in successors.values() for target in targets)
    event(f"merges: {min(9, sum(count > 1 for count in entering.values()))}")
    placed = list(layout.places.values())
    for i, a in enumerate(placed):
        assert a.x >= 0.0 and a.x + a.width <= layout.width + 1e-6 and a.y + a.height <= layout.height + 1e-6
        for b in placed[i + 1 :]:
            apart = max(b.x - a.x - a.width, a.x - b.x - b.width, b.y - a.y - a.height, a.y - b.y - b.height)
            assert apart >= 9.9, "two boxes overlap or nearly touch"
    assert len(layout.routes) == sum(map(len, successors.values()))
    for route in layout.routes:
        source, target = layout.places[route.source], layout.places[route.target]
        assert route.points[0][1] == pytest.approx(source.y + source.height)
        assert route.points[-1] == pytest.approx((target.x + target.width / 2, target.y), abs=0.02)
        assert source.x <= route.points[0][0] <= source.x + source.width
        for first, second in zip(route.points, route.points[1:], strict=False):
            assert second[1] > first[1], "an edge goes up or level"
            assert meets(layout, first, second) == [], "an edge passes through a box"


@given(graph=graphs())
def test_equal_graphs_have_equal_layouts(graph):
    boxes, successors = graph
    again = layered(dict(boxes), {name: tuple(after) for name, after in successors.items()})
    assert layered(boxes, successors) == again


def test_a_chain_is_straight_and_a_tree_has_no_crossings():
    box = Box(80.0, 30.0, (0.0,))
    chain = layered({f"n{i}": box for i in range(5)}, {f"n{i}": [f"n{i + 1}"] for i in range(4)})
    assert chain.width == 80.0
    assert {place.x for place in chain.places.values()} == {0.0}
    assert chain.height == 5 * 30.0 + 4 * BETWEEN
    fork = Box(80.0, 30.0, (-20.0, 20.0))
    tree = layered(
        {f"n{i}": fork if i < 7 else Box(80.0, 30.0) for i in range(15)},
        {f"n{i}": [f"n{2 * i + 1}", f"n{2 * i + 2}"] for i in range(7)},
    )
    leaves = [tree.places[f"n{i}"].x for i in range(7, 15)]
    assert leaves == sorted(leaves)
    assert tree.places["n0"].x + 40.0 == pytest.approx(tree.width / 2, abs=1.0)


@pytest.mark.parametrize(
    ("successors", "message"),
    [({"a": ["b"], "b": ["a"]}, "cycle"), ({"a": ["c"], "b": []}, "no node")],
)
def test_what_is_no_acyclic_graph_is_refused(successors, message):
    box = Box(10.0, 10.0, (0.0,))
    with pytest.raises(ValueError, match=message):
        layered({"a": box, "b": box}, successors)
