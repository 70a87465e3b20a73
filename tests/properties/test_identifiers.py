"""The law of the symbolic-geometric map [K Def. 5]: equal states have one identifier, states apart have two."""

from hypothesis import event, given
from hypothesis import strategies as st

from kabo.geometry_server import IdentifierMap
from kabo.scene import Attachment, GeometricState

TOLERANCE = 1e-6
JOINTS = st.tuples(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))
PLACES = st.tuples(st.sampled_from(["world", "r.hand"]), st.floats(-1.0, 1.0))


def state(joints: tuple[float, float], place: tuple[str, float]) -> GeometricState:
    parent, x = place
    return GeometricState({"r": joints}, {"o": Attachment(parent, (x, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))})


@given(values=st.lists(st.tuples(JOINTS, PLACES), min_size=1, max_size=12))
def test_a_state_keeps_its_identifier_and_is_found_by_it(values: list[tuple]) -> None:  # type: ignore[type-arg]
    known = IdentifierMap(TOLERANCE)
    states = [state(*value) for value in values]
    first = [known.identify(s) for s in states]
    assert [known.identify(s) for s in states] == first
    assert all(known.identify(known.state(i)) == i for i in first)
    assert len(known) == len(set(first))


@given(joints=JOINTS, place=PLACES, noise=st.floats(-0.999e-6, 0.999e-6))
def test_states_nearer_than_the_tolerance_are_one(joints: tuple, place: tuple, noise: float) -> None:  # type: ignore[type-arg]
    known = IdentifierMap(TOLERANCE)
    identifier = known.identify(state(joints, place))
    parent, x = place
    assert known.identify(state((joints[0] + noise, joints[1]), (parent, x + noise))) == identifier


@given(
    joints=JOINTS, place=PLACES, away=st.floats(2.1e-6, 1.0), which=st.sampled_from(["joint", "place", "parent"])
)
def test_states_farther_apart_are_two(joints: tuple, place: tuple, away: float, which: str) -> None:  # type: ignore[type-arg]
    event(which)
    known = IdentifierMap(TOLERANCE)
    identifier = known.identify(state(joints, place))
    parent, x = place
    other = {
        "joint": state((joints[0], joints[1] + away), place),
        "place": state(joints, (parent, x - away)),
        "parent": state(joints, ("table", x)),
    }[which]
    assert known.identify(other) != identifier


@given(joints=JOINTS, places=st.lists(PLACES, min_size=2, max_size=5))
def test_a_component_has_its_own_identifier_whatever_else_moved(joints: tuple, places: list[tuple]) -> None:  # type: ignore[type-arg]
    known = IdentifierMap(TOLERANCE)
    robots = {known.component("r", state(joints, place).robots["r"]) for place in places}
    assert len(robots) == 1
