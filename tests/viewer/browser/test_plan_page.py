"""Pages of plans in a real browser: every branch ends where the plan says, links open moments, nothing overlaps."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import kabo
from kabo.plan import Plan, Segment, unfold
from kabo.scene import Scene, link_poses
from kabo.scene.transforms import transform
from kabo.viewer import ViewDocument, page_of, scene_view
from kabo.viewer.content.arrays import Arrays
from kabo.viewer.content.plan.plan_view import plan_view

REPOSITORY = Path(__file__).parents[3]
CUPS = REPOSITORY / "domains" / "force_sensing" / "n2.yaml"
BOTTLES = REPOSITORY / "domains" / "bartender" / "four_bottles.yaml"
DOORS = REPOSITORY / "domains" / "doors" / "n3.yaml"
TOLERANCE = 1e-6  # metres, and of rotations

OVERLAPS = """() => {
  const boxes = [...kabo.plan.dag.boxes.values()];
  return boxes.flatMap((a, i) => boxes.slice(i + 1).filter((b) => a.x < b.x + b.width && b.x < a.x + a.width
    && a.y < b.y + b.height && b.y < a.y + a.height).map((b) => [a.node.id, b.node.id]));
}"""


class Case:
    """A problem with a plan, its scene, and the page of the plan."""

    def __init__(self, file: Path, folder: Path) -> None:
        self.problem = kabo.load_problem(file)
        self.scene = None if self.problem.scene is None else kabo.load_scene(self.problem.scene)
        plan = kabo.solve(self.problem, seed=0).plan
        assert plan is not None
        self.plan = plan
        self.page = self.write(plan, folder / f"{self.problem.name}.html")

    def write(self, plan: Plan, page: Path) -> Path:
        arrays = Arrays()
        shown = None if self.scene is None else scene_view(self.scene, arrays)
        view = plan_view(plan, self.problem, self.scene, arrays, sweeps=True)
        page.write_bytes(page_of(ViewDocument(self.problem.name, "plan", shown, plan=view, arrays=arrays)))
        return page


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    return tmp_path_factory.mktemp("plans")


@pytest.fixture(scope="module")
def cups(folder) -> Case:
    return Case(CUPS, folder)


@pytest.fixture(scope="module")
def doors(folder) -> Case:
    return Case(DOORS, folder)


def branches(plan: Plan) -> Iterator[tuple[tuple[int, ...], list[str]]]:
    """Every branch: the numbers of its outcomes, and its nodes."""
    ahead: list[tuple[str, tuple[int, ...], list[str]]] = [(plan.root, (), [])]
    while ahead:
        name, outcomes, way = ahead.pop()
        node = plan.nodes[name]
        if not node.successors:
            yield outcomes, [*way, name]
        for number, target in enumerate(node.successors):
            ahead.append((target, (*outcomes, number) if node.branches else outcomes, [*way, name]))


def final_poses(plan: Plan, scene: Scene, way: list[str]) -> dict[str, np.ndarray]:
    """Where links and objects are after a branch, by the plan's `start` and `after` alone."""
    changes = [plan.start, *(plan.nodes[name].after for name in way)]
    values: dict[str, dict[str, float]] = {}
    objects = {}
    for change in changes:
        if change is not None:
            objects.update(change.objects)
            for robot, joints in change.robots.items():
                values.setdefault(robot, {}).update(joints)
    poses: dict[str, np.ndarray] = dict(scene.fixed_poses)
    for robot, joints in values.items():
        model = scene.robots[robot]
        links = link_poses(model, tuple(joints[name] for name in model.joint_names))
        poses.update({f"{robot}.{link}": pose for link, pose in links.items()})

    def pose(name: str) -> np.ndarray:
        if name in objects and name not in poses:
            at = objects[name]
            below = np.eye(4) if at.parent == "world" else pose(at.parent)
            poses[name] = below @ transform(at.position, at.quaternion)
        return poses[name]

    return {name: pose(name) for name in [*objects, *poses]}


def follow_and_compare(case: Case, shown) -> int:
    """Takes every branch by clicks on its outcomes, plays to its end, and compares all poses; the number of branches."""
    assert case.scene is not None
    shown.run("kabo.plan.dag.fit(); kabo.plan.dag.drawNow()")
    count = 0
    for outcomes, way in branches(case.plan):
        left = list(outcomes)
        for name in way:
            chosen = case.plan.nodes[name].branches
            if chosen:
                outcome = list(chosen)[left.pop(0)]
                chip = f'[data-node="{name}"] [data-outcome="{outcome}"]'
                shown.page.locator(chip).dispatch_event("click")
        assert shown.run("kabo.plan.branch.map(({node}) => node.id)") == way
        shown.run("kabo.player.scrub(kabo.player.film.duration)")
        expected = final_poses(case.plan, case.scene, way)
        found = shown.run("(names) => names.map((name) => [...kabo.stage.poseOf(name)])", list(expected))
        for name, pose in zip(expected, found, strict=True):
            assert np.abs(np.array(pose).reshape(4, 4) - expected[name]).max() <= TOLERANCE, (name, outcomes)
        count += 1
    return count


def test_every_branch_ends_where_the_plan_says(cups, open_page):
    shown = open_page(cups.page)
    assert follow_and_compare(cups, shown) == 4
    shown.require_clean()


@pytest.mark.slow
def test_all_sixteen_outcomes_of_bartender_end_where_the_plan_says(folder, open_page):
    case = Case(BOTTLES, folder)
    assert case.page.stat().st_size <= 2_000_000
    shown = open_page(case.page)
    assert follow_and_compare(case, shown) == 16
    shown.require_clean()


def test_an_object_that_is_held_moves_with_the_hand(cups, open_page):
    """Between being taken and being let go, its pose in the hand does not change, while the hand moves."""
    shown = open_page(cups.page)
    found = shown.run("""() => {
      const { player, stage } = kabo;
      const places = [];
      for (let time = 0; time <= player.film.duration; time += 0.05) {
        player.scrub(time);
        for (const [name, { parent }] of Object.entries(player.state.objects)) {
          if (parent.includes(".")) {
            places.push([name, parent, [...stage.poseOf(parent)], [...stage.poseOf(name)]]);
          }
        }
      }
      return places;
    }""")
    held: dict[tuple[str, str], list[tuple[np.ndarray, np.ndarray]]] = {}
    for name, parent, hand, body in found:
        held.setdefault((name, parent), []).append((np.reshape(hand, (4, 4)), np.reshape(body, (4, 4))))
    assert {name for name, _ in held} == {"cup_1", "cup_2"}
    for pairs in held.values():
        relative = [np.linalg.inv(hand) @ body for hand, body in pairs]
        assert max(np.abs(each - relative[0]).max() for each in relative) < TOLERANCE
        assert max(np.linalg.norm(hand[:3, 3] - pairs[0][0][:3, 3]) for hand, _ in pairs) > 0.05


def test_nothing_jumps_where_an_object_is_taken_or_let_go(cups, open_page):
    shown = open_page(cups.page)
    jumps = shown.run("""() => {
      const { player, stage } = kabo;
      const events = player.film.steps.flatMap((step) => [
        ...(step.handovers ?? []).map(({ time, object }) => [step.begin + time, object]),
        ...Object.keys(step.after?.objects ?? {}).map((object) => [step.end, object])]);
      return events.map(([time, object]) => {
        const at = [time - 1e-6, time + 1e-6].map((moment) => {
          player.scrub(moment);
          return [...stage.poseOf(object)];
        });
        return Math.max(...at[0].map((value, k) => Math.abs(value - at[1][k])));
      });
    }""")
    assert len(jumps) >= 8
    assert max(jumps) < 1e-4


JOINTS_AT = """([node, moments]) => {
  const { player } = kabo;
  const { begin, segments } = player.film.steps.find((step) => step.id === node);
  const robots = [...new Set(segments.map((segment) => segment.robot))];
  return moments.map((time) => robots.map((robot) => player.stateAt(begin + time).robots[robot]));
}"""


def moments_of(segment: Segment) -> list[float]:
    """Times in a segment: all borders of its polynomials, and others between them."""
    own = segment.times if segment.trajectory is None else segment.trajectory.times
    return sorted({*own, *np.linspace(own[0], own[-1], 41)})


def test_joints_move_along_the_polynomials_of_the_plan(cups, open_page):
    """At borders of pieces and between them, against the trajectories as Python evaluates them."""
    shown = open_page(cups.page)
    way = next(
        way for _, way in branches(cups.plan) if shown.run("kabo.plan.branch.map(({node}) => node.id)") == way
    )
    compared = 0
    for name in way:
        for segment in cups.plan.nodes[name].motion:
            assert segment.trajectory is not None
            moments = moments_of(segment)[:-1]  # at its end the next one begins, of other joints perhaps
            expected = segment.trajectory.at(moments)
            for (found,), values in zip(shown.run(JOINTS_AT, [name, moments]), expected, strict=True):
                assert [found[joint] for joint in segment.joints] == pytest.approx(values, abs=TOLERANCE)
                compared += 1
    assert compared > 200


def test_a_plan_without_trajectories_moves_straight_between_its_way_points(cups, folder, open_page):
    plain = {
        name: replace(node, motion=tuple(replace(each, trajectory=None) for each in node.motion))
        for name, node in cups.plan.nodes.items()
    }
    shown = open_page(cups.write(replace(cups.plan, nodes=plain), folder / "plain.html"))
    name, segment = next((name, node.motion[0]) for name, node in plain.items() if node.motion)
    moments = moments_of(segment)[:-1]
    columns = list(zip(*segment.waypoints, strict=True))
    for (found,), time in zip(shown.run(JOINTS_AT, [name, moments]), moments, strict=True):
        expected = [np.interp(time, segment.times, column) for column in columns]
        assert [found[joint] for joint in segment.joints] == pytest.approx(expected, abs=TOLERANCE)
    shown.require_clean()


def test_a_link_opens_a_moment_and_follows_the_time(cups, open_page):
    name = next(name for name, node in cups.plan.nodes.items() if node.motion and node.action == "ungrasp")
    shown = open_page(cups.page, fragment=f"#{name}@0.2s")
    assert shown.run("kabo.player.step.id") == name
    assert shown.run("kabo.player.local") == pytest.approx(0.2, abs=1e-9)
    shown.page.keyboard.press("ArrowRight")
    after = shown.run("kabo.player.step.id")
    assert after != name
    shown.page.wait_for_function("(id) => location.hash.startsWith(`#${id}@`)", arg=after)


def test_keys_play_pause_and_step(cups, open_page):
    shown = open_page(cups.page)
    shown.page.keyboard.press(" ")
    shown.page.wait_for_function("() => kabo.player.time > 0.2")
    shown.page.keyboard.press(" ")
    assert shown.run("kabo.player.playing") is False
    shown.page.keyboard.press("End")
    assert shown.run("kabo.player.time === kabo.player.film.duration") is True
    shown.page.keyboard.press("o")
    assert shown.run("kabo.plan.branches.outcomes") in ([0, 1], [1, 0], [0, 0], [1, 1])
    shown.page.keyboard.press("?")
    assert shown.page.locator("dialog").is_visible()
    shown.require_clean()


def test_whatever_is_folded_boxes_do_not_overlap(doors, open_page):
    shown = open_page(doors.page)
    assert shown.run(OVERLAPS) == []
    for name in doors.plan.nodes:
        shown.run("(id) => kabo.plan.dag.toggleFold(id)", name)
        assert shown.run(OVERLAPS) == []
    shown.run("kabo.plan.dag.folded.clear(); kabo.plan.dag.toggleOnly()")
    assert shown.run(OVERLAPS) == []
    assert shown.run("kabo.plan.dag.boxes.size === kabo.plan.branch.length") is True


def test_a_plan_without_a_scene_shows_graph_and_knowledge(doors, open_page):
    shown = open_page(doors.page)
    assert shown.run("kabo.stage") is None
    assert shown.page.locator(".facts").first.is_visible()
    shown.page.keyboard.press("ArrowRight")
    assert shown.run("kabo.player.number") == 1
    shown.require_clean()


def test_a_tree_of_many_nodes_keeps_few_elements(doors, folder, open_page):
    """Unfolded, with every leaf of its own: only what is in sight is in the document."""
    page = doors.write(unfold(doors.plan), folder / "tree.html")
    shown = open_page(page)
    shown.run("kabo.plan.dag.zoom(2.5); kabo.plan.dag.drawNow()")
    total, drawn = shown.run("[kabo.plan.dag.boxes.size, document.querySelectorAll('.dag .node').length]")
    assert 0 < drawn < total
    shown.require_clean()


def test_paper_has_the_graph_and_a_picture_of_each_motion(cups, open_page):
    shown = open_page(cups.page)
    shown.run("dispatchEvent(new Event('beforeprint'))")
    moving = shown.run("kabo.player.film.steps.filter((step) => step.length > 0).length")
    assert shown.page.locator(".film canvas").count() == moving > 0
    assert shown.page.locator(".film .graph .node").count() == len(cups.plan.nodes)
    shown.run("dispatchEvent(new Event('afterprint'))")
    assert shown.page.locator(".film").count() == 0
    shown.require_clean()


def test_the_swept_volume_of_the_present_segment_can_be_seen(cups, open_page):
    shown = open_page(cups.page)
    assert shown.run("kabo.stage.overlays.has('sweep')") is False
    shown.page.keyboard.press("w")
    assert shown.run("kabo.stage.overlays.get('sweep').children.length") > 3
    shown.page.keyboard.press("w")
    assert shown.run("kabo.stage.overlays.has('sweep')") is False
    shown.require_clean()


@pytest.mark.parametrize("moment", ["", "#n1@0.2s"])
def test_nothing_serious_is_wrong_for_those_who_do_not_see_well(cups, open_page, moment):
    shown = open_page(cups.page, fragment=moment)
    shown.page.locator("summary").evaluate_all("all => all.forEach(each => { each.parentElement.open = true; })")
    shown.require_accessible()


@pytest.mark.parametrize("height", [600, 720, 1080])
def test_the_details_of_a_node_fill_the_panel_and_end_within_it(cups, open_page, height):
    shown = open_page(cups.page)
    shown.page.set_viewport_size({"width": 1280, "height": height})
    ends = "['.node-details', '.plan'].map(name => document.querySelector(name).getBoundingClientRect().bottom)"
    details, panel = shown.run(ends)
    assert details == pytest.approx(panel, abs=1.0)


def test_a_key_shows_the_whole_plan_beside_a_scene(cups, open_page):
    shown = open_page(cups.page)
    shown.page.keyboard.press("+")
    nearer = shown.run("kabo.plan.dag.view.scale")
    shown.page.keyboard.press("0")
    assert shown.run("kabo.plan.dag.view.scale") < nearer


def test_the_help_begins_with_its_first_line_and_escape_closes_it(cups, open_page):
    shown = open_page(cups.page)
    shown.page.keyboard.press("?")
    assert shown.run("document.querySelector('dialog.help').scrollTop") == 0
    shown.page.keyboard.press("Escape")
    assert not shown.run("document.querySelector('dialog.help').open")
