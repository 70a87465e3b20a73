"""The page of a scene in a real browser."""

from pathlib import Path

import numpy as np
import pytest

from kabo.cli.main import main
from kabo.language import load_scene_description
from kabo.language.recorded_paths import installed_folder
from kabo.scene import Attachment, GeometricState, load_scene, world_T

BARTENDER = "domains/bartender/four_bottles.yaml"
POSES = "names => Object.fromEntries(names.map(name => [name, Array.from(kabo.stage.poseOf(name))]))"
STATES = 4
BROKEN = """scene: broken
epsilon: 0.01
objects:
  table: {box: [1.0, 1.0, 0.04], pose: {position: [0, 0, -0.02]}}
  cup: {model: thing, pose: {position: [0.2, 0.0, 0.05]}}
  can: {model: thing, pose: {position: [0.26, 0.0, 0.05]}}
models:
  thing:
    cylinder: {radius: 0.04, height: 0.1}
    mass: 0.1
    movable: true
    grasps: {top: {constraints: ["coincident(tool.tcp, this.center)"]}}
    placements: {standing: {constraints: ["coincident(this.bottom, support.top)", "inside(this, region)"]}}
regions:
  slot: {box: [0.05, 0.05, 0.3], pose: {position: [-0.3, 0, 0.15]}, support: table}
"""
TALOS = """scene: talos
epsilon: 0.01
packages: {example-robot-data: installed}
robots:
  talos: {urdf: "package://example-robot-data/robots/talos_data/robots/talos_reduced.urdf"}
"""


def page_of(folder: Path, *arguments: object) -> Path:
    path = folder / "page.html"
    assert main(["view", *map(str, arguments), "-o", str(path), "--no-open"]) == 0
    return path


@pytest.fixture(scope="module")
def bartender(tmp_path_factory) -> Path:
    return page_of(tmp_path_factory.mktemp("bartender"), BARTENDER)


def test_a_scene_opens_from_disk_with_a_clean_console_and_without_a_request(bartender, open_page):
    shown = open_page(bartender)
    assert shown.run("document.documentElement.dataset.ready") == "yes"
    assert shown.page.title() == "bartender_four_bottles – kabo"
    shown.require_clean()


def random_state(scene, random) -> GeometricState:
    """Joints anywhere within their limits, the first object in the first robot's hand, the second on top of the first."""
    robots = {name: tuple(random.uniform(r.tree.lower, r.tree.upper)) for name, r in scene.robots.items()}
    objects = dict(scene.start.objects)
    held, hand = list(objects)[:2], next(iter(scene.robots.values()))
    for name, parent in zip(held, [f"{hand.name}.{list(hand.links)[-1]}", *held], strict=False):
        x, y, z, w = (float(each) for each in random.normal(size=4) / 2.0)
        objects[name] = Attachment(parent, (0.01, 0.02, -0.1), (x, y, z, w))
    return GeometricState(robots, objects)


def state_json(scene, state: GeometricState) -> dict:
    joints = {name: dict(zip(scene.robots[name].joint_names, q, strict=True)) for name, q in state.robots.items()}
    objects = {
        name: {"parent": a.parent, "position": a.position, "quaternion": a.quaternion}
        for name, a in state.objects.items()
    }
    return {"robots": joints, "objects": objects}


@pytest.mark.parametrize(
    "scene_file",
    [
        BARTENDER,  # fingers that mimic each other
        "domains/waiter/four_cups.yaml",  # a base that drives
        "examples/tiago_inspection/scene.yaml",  # a torso that slides, a hand of many joints
        "examples/pick_and_place/panda.yaml",  # fingers that slide
        "talos",  # grippers of many mimic joints
    ],
)
def test_everything_stands_where_kabo_says_in_any_state(scene_file, tmp_path, open_page):
    if installed_folder("example-robot-data") is None:
        pytest.skip("robots of others come with the extra `robots`")
    if scene_file == "talos":
        scene_file = tmp_path / "talos.yaml"
        scene_file.write_text(TALOS)
    scene = load_scene(load_scene_description(scene_file))
    shown = open_page(page_of(tmp_path, scene_file))
    names = [f"{r.name}.{link}" for r in scene.robots.values() for link in r.links]
    names += [*scene.bodies, *scene.regions, "world"]
    random = np.random.default_rng(1)
    for _ in range(STATES):
        state = random_state(scene, random)
        shown.run("state => kabo.stage.setState(state)", state_json(scene, state))
        for name, pose in shown.run(POSES, names).items():
            assert np.abs(np.reshape(pose, (4, 4)) - world_T(scene, state, name)).max() < 1e-6, name
    shown.require_clean()


def test_two_arms_are_small_with_few_triangles_and_with_all(bartender, tmp_path):
    assert bartender.stat().st_size <= 2e6
    assert page_of(tmp_path, BARTENDER, "--detail", "original").stat().st_size <= 8e6


def test_a_slider_moves_its_joint_and_a_named_configuration_brings_it_back(bartender, open_page):
    shown = open_page(bartender)
    before = shown.run("Array.from(kabo.stage.poseOf('left.tool0'))")
    slider = shown.page.get_by_label("joint_1").first
    slider.focus()
    shown.page.keyboard.press("ArrowRight")
    assert shown.run("kabo.stage.stateNow().robots.left.joint_1") > 0.0
    assert shown.run("Array.from(kabo.stage.poseOf('left.tool0'))") != before
    shown.page.get_by_role("button", name="home").first.click()
    assert shown.run("Array.from(kabo.stage.poseOf('left.tool0'))") == pytest.approx(before, abs=1e-8)


def place_of(shown, name: str) -> tuple[float, float]:
    """Where a thing is on the screen: a pixel at which it is the nearest one."""
    x, y = shown.run(
        """name => {
          const { left, top, width, height } = kabo.stage.canvas.getBoundingClientRect();
          for (let y = top + 2; y < top + height; y += 4) {
            for (let x = left + 2; x < left + width; x += 4) {
              if (kabo.stage.at({ clientX: x, clientY: y })?.name === name) return [x + 1, y + 1];
            }
          }
        }""",
        name,
    )
    return x, y


def test_a_link_is_dragged_with_shift_and_its_joint_stays_within_its_limits(bartender, open_page):
    shown = open_page(bartender)
    x, y = place_of(shown, "left.link_3")
    camera = shown.run("kabo.stage.camera.position.toArray()")
    shown.page.keyboard.down("Shift")
    shown.page.mouse.move(x, y)
    shown.page.mouse.down()
    shown.page.mouse.move(x + 15, y + 25, steps=5)
    moved = shown.run("kabo.stage.stateNow().robots.left")
    shown.page.mouse.move(x + 900, y + 5000, steps=5)
    shown.page.mouse.up()
    shown.page.keyboard.up("Shift")
    start = shown.run("kabo.document.scene.start.robots.left")
    assert {name for name in start if start[name] != moved[name]} == {"joint_3"}
    limits = {v["name"]: v for v in shown.run("kabo.document.scene.robots[0].values")}["joint_3"]
    assert limits["lower"] <= shown.run("kabo.stage.stateNow().robots.left.joint_3") <= limits["upper"]
    assert shown.run("kabo.stage.camera.position.toArray()") == camera


def test_a_click_tells_what_a_body_is(bartender, open_page):
    shown = open_page(bartender)
    shown.page.mouse.click(*place_of(shown, "bottle_4"))
    card = shown.page.locator(".card").inner_text()
    assert "bottle_4" in card
    assert "0.3 kg" in card
    assert "enclosing parts, by at most 3 mm" in card


def test_layers_are_shown_by_their_keys(bartender, open_page):
    shown = open_page(bartender)
    assert not shown.run("kabo.stage.things.get('left.link_2').layers.get('enclosing')?.visible ?? false")
    shown.page.keyboard.press("e")
    assert shown.run("kabo.stage.things.get('left.link_2').layers.get('enclosing').visible")
    shown.page.keyboard.press("?")
    assert "enclosing parts" in shown.page.locator("dialog").inner_text()
    shown.require_clean()


def test_a_finding_is_a_button_that_shows_its_pair_with_its_depth(tmp_path, open_page):
    scene = tmp_path / "broken.yaml"
    scene.write_text(BROKEN)
    shown = open_page(page_of(tmp_path, scene))
    shown.page.get_by_role("tab", name="Findings").click()
    before = shown.run("kabo.stage.camera.position.toArray()")
    row = shown.page.locator(".findings li").filter(has_text="overlap at the start")
    assert "deep" in row.locator(".depth").inner_text()
    row.get_by_role("button").click()
    marked = "kabo.stage.things.values().filter(each => each.marked !== null).map(each => each.name).toArray()"
    assert set(shown.run(marked)) == {"cup", "can"}
    assert shown.run("kabo.stage.things.get('table').isFaded")
    assert shown.run("kabo.stage.camera.position.toArray()") != before
    shown.page.locator(".findings li").filter(has_text='region "slot"').get_by_role("button").click()
    assert set(shown.run(marked)) == {"slot"}
    shown.page.keyboard.press("Escape")
    assert shown.run(marked) == []
    shown.require_clean()


def test_an_allowed_contact_shows_both_its_sides(bartender, open_page):
    shown = open_page(bartender)
    shown.page.locator(".contacts summary").click()
    shown.page.get_by_role("button", name="left.base_link – table").click()
    assert shown.run("['left.base_link', 'table'].every(name => kabo.stage.things.get(name).marked !== null)")


def test_nothing_serious_is_wrong_for_those_who_do_not_see_well(bartender, open_page):
    shown = open_page(bartender)
    shown.page.keyboard.press("e")
    shown.require_accessible()


def test_to_mark_nothing_marks_nothing(bartender, open_page):
    shown = open_page(bartender)
    marked = "[...kabo.stage.things.values()].filter(each => each.marked !== null).map(each => each.name)"
    shown.run("kabo.stage.highlight([], 'good')")
    assert shown.run(marked) == []
    shown.run("kabo.stage.highlight(['bottle_1'], 'good')")
    shown.run("kabo.stage.highlight([], 'good')")
    assert shown.run(marked) == ["bottle_1"]


def test_the_page_can_be_embedded_in_another_one(bartender, tmp_path, open_page):
    outer = tmp_path / "outer.html"
    quoted = bartender.read_text().replace("&", "&amp;").replace('"', "&quot;")
    outer.write_text(f'<html data-ready="yes"><iframe srcdoc="{quoted}" width="900" height="600"></iframe></html>')
    shown = open_page(outer)
    frame = shown.page.frame_locator("iframe")
    frame.locator("html[data-ready=yes]").wait_for(state="attached", timeout=60_000)
    shown.require_clean()


def test_a_browser_without_3d_still_shows_what_was_found(tmp_path, open_page):
    scene = tmp_path / "broken.yaml"
    scene.write_text(BROKEN)
    lacking = "HTMLCanvasElement.prototype.getContext = () => null"
    shown = open_page(page_of(tmp_path, scene), before=lacking)
    assert "draws no 3D" in shown.page.locator(".told").inner_text()
    assert "overlap at the start" in shown.page.locator(".findings").inner_text()
    shown.require_clean()


def test_on_paper_the_scene_is_a_picture(bartender, open_page):
    shown = open_page(bartender)
    shown.run("dispatchEvent(new Event('beforeprint'))")
    colours = shown.run(
        """() => {
          const canvas = document.querySelector(".printed");
          const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
          return new Set(new Uint32Array(data.buffer)).size;
        }"""
    )
    assert colours > 100
    shown.run("dispatchEvent(new Event('afterprint'))")
    assert shown.page.locator(".printed").count() == 0


COLLIDING = """scene: colliding
epsilon: 0.01
robots:
  arm:
    urdf: {meshes}/arm6/arm6.urdf
    base: {{position: [0, 0, 0]}}
    configurations: {{home: [0, -20 deg, 110 deg, 0, 90 deg, 0], low: [0, 120 deg, 40 deg, 0, 0, 0]}}
objects:
  table: {{box: [2.0, 2.0, 0.04], pose: {{position: [0, 0, -0.02]}}}}
allowed_contacts:
  - [arm.base_link, table]
"""


def test_a_configuration_in_collision_is_shown_with_the_pair_that_collides(tmp_path, open_page):
    scene = tmp_path / "colliding.yaml"
    scene.write_text(COLLIDING.format(meshes=(Path("meshes").resolve())))
    shown = open_page(page_of(tmp_path, scene))
    shown.page.get_by_role("tab", name="Findings").click()
    shown.page.get_by_role("button", name='configuration "low"').first.click()
    values = shown.run("kabo.stage.stateNow().robots.arm")
    assert values["joint_2"] == pytest.approx(np.radians(120.0))
    assert shown.run("kabo.stage.things.get('table').marked !== null")
    shown.require_clean()
