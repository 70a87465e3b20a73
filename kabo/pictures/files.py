"""The picture of a file of any kind: what is drawn follows from the file, the ending of the picture, and the wishes."""

from collections.abc import Callable
from dataclasses import dataclass, field
from importlib.util import find_spec
from pathlib import Path

from kabo.errors import Diagnostic, InputError
from kabo.language import is_imported, load_problem, load_scene_description
from kabo.meshes import Mesh, load_mesh, require_solid
from kabo.meshes.reading import FORMATS
from kabo.pictures.drawing import Drawing
from kabo.pictures.film import described
from kabo.pictures.graphs import plan_svg
from kabo.pictures.meshes import bound_picture, mesh_drawing
from kabo.pictures.panels import png, titled
from kabo.pictures.plans import animation, at_node, film_strip
from kabo.pictures.runs import run_animation, run_strip
from kabo.pictures.samples import samples_drawing
from kabo.pictures.scenes import scene_drawing
from kabo.pictures.sweeps import sweep_drawing
from kabo.pictures.views import ViewWishes, picture_of
from kabo.plan import Plan, load_plan
from kabo.scene import Scene, load_scene
from kabo.task_plans import plan_of_report
from kabo.viewer.content.files import given_file, problem_of_plan
from kabo.viewer.content.plan.boxes import in_order_of_parameters
from kabo.viewer.content.plan.faults import require_drawable
from kabo.viewer.content.run_view import is_log, read_log

ENDINGS = (".png", ".svg", ".gif")


@dataclass(frozen=True)
class PictureWishes:
    """What is drawn of a file; None where the file says enough.

    Args:
        problem: of a plan that lies elsewhere, or of a run. domain: of a problem in PDDL or PKS. scene: of a task.
        branch: outcomes of a plan, separated by commas, or a node. at: a node of a plan, after which the scene is
            drawn. sweep: a node, or `node:segment`. samples: `ROBOT:OBJECT.GRASP`. solution: of a report; None: the
        cheapest.
        epsilon: of a mesh, from its size [m]; of a sweep [m]. scale: metres per unit of a mesh file. view: the camera.
    """

    problem: Path | None = None
    domain: Path | None = None
    scene: Path | None = None
    branch: str | None = None
    at: str | None = None
    sweep: str | None = None
    samples: str | None = None
    solution: int | None = None
    epsilon: Callable[[Mesh | None], float] | None = None
    scale: float = 1.0
    view: ViewWishes = field(default_factory=ViewWishes)


def require_pictures(name: str) -> None:
    """Raises an error unless the libraries that draw pictures are installed.

    Args:
        name: the option or file that needs them, for the message.

    Raises:
        InputError: the extra is not installed.
    """
    if find_spec("pyvista") is None:
        hint = 'install it with the extra: pip install "kabo[pictures]"'
        raise InputError([Diagnostic(name, 1, 1, "drawing pictures needs the library pyvista", hint)])


def picture_of_file(path: Path, ending: str, wishes: PictureWishes) -> bytes:
    """The bytes of a picture of a scene, a problem, a task's scene, a plan, a run, a solution of a report, or a mesh.

    Args:
        path: the file. ending: of the picture: .png; for plans .svg (the graph) and .gif (a branch), for runs .gif, too.
        wishes: what is drawn of it.

    Raises:
        InputError: the file, a wish or the ending does not fit; says what would.
        OSError: the file cannot be opened.
    """
    if ending not in ENDINGS:
        raise _refusal("-o", f'pictures do not end with "{ending}"', f"end it with {', '.join(ENDINGS)}")
    if path.suffix.lower().removeprefix(".") in FORMATS:
        _only(wishes, "a mesh", ())
        _require_ending(ending, "a mesh", (".png",))
        return _of_mesh(path, wishes)
    if path.suffix.lower() in (".urdf", ".xacro"):
        hint = f"make a scene of it: kabo robot {path} -o scene.yaml --picture FILE.png"
        raise _refusal(str(path), "a robot's file is no scene", hint)
    if is_log(path):
        _only(wishes, "a log of a run", ())
        _require_ending(ending, "a log of a run", (".png", ".gif"))
        return _of_run(path, ending, wishes)
    given = given_file(path)
    if given.kind == "plan":
        _only(wishes, "a plan", ("branch", "at", "sweep"))
        return _of_plan(path, ending, wishes)
    if given.kind == "report":
        _only(wishes, "a report", ("sweep", "solution"))
        return _of_report(path, ending, wishes)
    if given.kind == "explanation":
        raise _refusal(str(path), f"there is no picture of {given.kind}s", f"show it as a page: kabo view {path}")
    _only(wishes, f"a {given.kind}", ("samples",))
    _require_ending(ending, f"a {given.kind}", (".png",))
    return _of_scene(_scene_of(path, given.kind, wishes), wishes)


def _of_mesh(path: Path, wishes: PictureWishes) -> bytes:
    require_pictures(str(path))
    mesh = load_mesh(path, wishes.scale)
    surface = mesh.vertices, mesh.faces
    if wishes.epsilon is None:
        pixels = picture_of(mesh_drawing(path.stem, surface), wishes.view)
        return png(titled(pixels, f"{path.name}: {len(mesh.vertices)} vertices, {len(mesh.faces)} triangles"))
    from kabo.geometry import bounding_mesh  # compiles kernels: only this picture needs them

    require_solid(mesh)
    epsilon = wishes.epsilon(mesh)
    made = bounding_mesh(mesh, epsilon)
    said = (
        f"{len(mesh.vertices)} to {len(made.vertices)} vertices, within {1e3 * made.hausdorff_upper_bound:.3g} mm"
    )
    title = f"{path.name}: {said} (epsilon {1e3 * epsilon:.3g} mm)"
    return bound_picture(surface, (made.vertices, made.faces), epsilon=epsilon, title=title, wishes=wishes.view)


def _of_scene(scene: Scene, wishes: PictureWishes) -> bytes:
    if wishes.samples is not None:
        drawing, figures = samples_drawing(scene, wishes.samples)
        return png(titled(picture_of(drawing, wishes.view), figures))
    return png(picture_of(scene_drawing(scene), wishes.view))


def _scene_of(path: Path, kind: str, wishes: PictureWishes) -> Scene:
    """The scene of a scene, problem or task file."""
    require_pictures(str(path))
    if kind == "task":
        if wishes.scene is None:
            raise _refusal(str(path), "a task has no scene of its own", "name one: --scene FILE")
        return load_scene(load_scene_description(wishes.scene, whole=False))
    if kind == "scene":
        return load_scene(load_scene_description(path, whole=False))
    description = load_problem(path, wishes.domain).scene
    if description is None:
        hint = "solve it, and draw the plan: kabo picture plan.json -o FILE.svg"
        raise _refusal(str(path), "this problem has no scene to draw", hint)
    return load_scene(description)


def _of_report(path: Path, ending: str, wishes: PictureWishes) -> bytes:
    """The picture of one solution of a task's report, which is drawn as a plan of one node."""
    _require_ending(ending, "a report", (".png", ".gif"))
    require_pictures(str(path))
    _, plan, scene, _ = plan_of_report(path, wishes.scene, wishes.solution, certificate=False)
    return _of_motion(plan, scene, ending, wishes, str(path))


def _of_run(path: Path, ending: str, wishes: PictureWishes) -> bytes:
    """The film strip or the animation of a run, from its log."""
    if wishes.problem is None:
        raise _refusal(str(path), "a log does not say of which scene it is", "name its problem: --problem FILE")
    kind = "problem" if is_imported(wishes.problem) else given_file(wishes.problem).kind
    scene, records = _scene_of(wishes.problem, kind, wishes), read_log(path)
    draw = run_animation if ending == ".gif" else run_strip
    return draw(records, scene, path.name, wishes.view)


def _of_plan(path: Path, ending: str, wishes: PictureWishes) -> bytes:
    plan, file = load_plan(path), str(path)
    require_drawable(plan, None, file)
    if ending == ".svg":
        for option in ("branch", "at", "sweep"):
            if getattr(wishes, option) is not None:
                raise _refusal(f"--{option}", "the graph of a plan shows all of it", "end the picture with .png")
        return plan_svg(_ordered(plan, path, wishes), f"{plan.problem}: {described(plan)}")
    return _of_motion(plan, _scene_of_plan(plan, path, wishes), ending, wishes, file)


def _of_motion(plan: Plan, scene: Scene, ending: str, wishes: PictureWishes, file: str) -> bytes:
    """The film strip of a branch, its animation, what a node sweeps, or the scene after a node."""
    require_drawable(plan, scene, file)
    if ending == ".gif":
        if wishes.at is not None or wishes.sweep is not None:
            raise _refusal("--at" if wishes.sweep is None else "--sweep", "a .gif moves", "end it with .png")
        return animation(plan, scene, wishes.branch, wishes.view, file)
    if wishes.sweep is not None:
        epsilon = scene.epsilon if wishes.epsilon is None else wishes.epsilon(None)
        drawing, figures = sweep_drawing(plan, scene, wishes.sweep, epsilon, file)
        return _titled(drawing, f"{_node_text(plan, wishes.sweep)}: {figures}", wishes.view)
    if wishes.at is not None:
        return _titled(at_node(plan, scene, wishes.at, file), f"after {_node_text(plan, wishes.at)}", wishes.view)
    return film_strip(plan, scene, wishes.branch, wishes.view, file)


def _ordered(plan: Plan, path: Path, wishes: PictureWishes) -> Plan:
    """The plan with arguments in the order of their actions' parameters; as it is if its problem is not at hand."""
    try:
        return in_order_of_parameters(plan, problem_of_plan(plan, path, wishes.problem, wishes.domain))
    except InputError:
        if wishes.problem is not None:
            raise
        return plan


def _titled(drawing: Drawing, title: str, view: ViewWishes) -> bytes:
    return png(titled(picture_of(drawing, view), title))


def _node_text(plan: Plan, wanted: str) -> str:
    from kabo.plan.description import call

    name, _, _ = wanted.partition(":")
    return f"{wanted} {call(plan.nodes[name])}"


def _scene_of_plan(plan: Plan, path: Path, wishes: PictureWishes) -> Scene:
    require_pictures(str(path))
    problem = problem_of_plan(plan, path, wishes.problem, wishes.domain)
    if problem.scene is None:
        raise _refusal(
            str(path), "its problem has no scene: nothing moves", "draw its graph: end the picture with .svg"
        )
    return load_scene(problem.scene)


def _only(wishes: PictureWishes, what: str, fitting: tuple[str, ...]) -> None:
    """Checks that no wish is about another kind of file.

    Raises:
        InputError: names the first that is.
    """
    kinds = {"branch": "a plan", "at": "a plan", "sweep": "a plan", "samples": "a scene or a problem"}
    kinds |= {"solution": "a report"}
    for option, kind in kinds.items():
        if getattr(wishes, option) is not None and option not in fitting:
            raise _refusal(f"--{option}", f"this is for {kind}, and {what} was given", f"leave out --{option}")


def _require_ending(ending: str, what: str, endings: tuple[str, ...]) -> None:
    if ending not in endings:
        hint = "end it with .png; plans are also drawn as .svg (the graph) and .gif (a branch), runs as .gif"
        raise _refusal("-o", f"{what} is not drawn as {ending}", hint)


def _refusal(name: str, message: str, hint: str) -> InputError:
    return InputError([Diagnostic(name, 1, 1, message, hint)])
