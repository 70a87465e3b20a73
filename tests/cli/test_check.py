"""`kabo check`: all findings of all files at once."""

import trimesh

from kabo.exploration import Exploration, Space


def test_correct_files_are_exit_0(kabo, parcels):
    said = kabo("check", *sorted(parcels.glob("*.yaml")))
    assert said.code == 0 and "3 files: 0 errors" in said.err
    assert kabo("check", "one.yaml", "--json").json == {"valid": True, "diagnostics": []}


def test_findings_of_several_files_are_told_at_once_with_places(kabo, parcels):
    domain = parcels / "domain.yaml"
    domain.write_text(domain.read_text().replace("K(held(p))", "K(hold(p))", 1))
    problem = parcels / "one.yaml"
    problem.write_text(problem.read_text().replace("goal:", "gaol:"))
    said = kabo("check", "one.yaml", "hopeless.yaml", "--json")
    assert said.code == 2 and not said.json["valid"]
    places = {(found["file"], found["line"]) for found in said.json["diagnostics"]}
    assert ("domain.yaml", 20) in places and {file for file, _ in places} == {"domain.yaml", "one.yaml"}
    assert kabo("check", "one.yaml").err.count("^") >= 2


def test_a_mesh_that_does_not_load_is_found_where_it_is_named(kabo, parcels):
    (parcels / "broken.stl").write_bytes(b"no triangles")
    (parcels / "scene.yaml").write_text(
        "scene: s\nepsilon: 0.01\nrobots: {}\nobjects:\n  thing: {mesh: broken.stl}\n"
    )
    problem = parcels / "one.yaml"
    problem.write_text(problem.read_text().replace("objects:", "scene: scene.yaml\nobjects:", 1))
    said = kabo("check", "one.yaml", "--json")
    assert said.code == 2
    assert [(found["file"], found["line"]) for found in said.json["diagnostics"]] == [("scene.yaml", 5)]


def test_a_missing_file_is_a_finding(kabo, parcels):
    assert kabo("check", "absent.yaml").code == 2


def test_the_model_of_an_exploration_is_read(kabo, parcels):
    Exploration(Space({"force": (0.0, 1.0)}), ["torque"]).save(parcels / "held.jsonl")
    assert kabo("check", "held.jsonl", "one.yaml").code == 0
    with (parcels / "held.jsonl").open("a") as file:
        file.write('{"case": {}, "parameters": {"force": 2.0}, "valid": false, "reason": "crushed"}\n')
    said = kabo("check", "held.jsonl", "--json")
    assert said.code == 2
    (found,) = said.json["diagnostics"]
    assert (found["file"], found["line"]) == ("held.jsonl", 2) and "outside its bounds" in found["message"]


def test_a_mesh_in_millimetres_is_a_warning_with_the_fix(kabo, parcels):
    trimesh.creation.box(extents=(100.0, 80.0, 60.0)).export(parcels / "part.stl")
    (parcels / "scene.yaml").write_text(
        "scene: s\nepsilon: 0.01\nrobots: {}\nobjects:\n"
        "  thing: {mesh: part.stl}\n  other: {mesh: part.stl, scale: 0.001}\n"
    )
    problem = parcels / "one.yaml"
    problem.write_text(problem.read_text().replace("objects:", "scene: scene.yaml\nobjects:", 1))
    said = kabo("check", "one.yaml", "--json")
    (found,) = said.json["diagnostics"]
    assert (said.code, found["severity"], found["file"], found["line"]) == (0, "warning", "scene.yaml", 5)
    assert "millimetres" in found["message"] and "scale: 0.001" in found["hint"]


TASK = "name: bring\nproperties: {p: name}\nstages:\n  - {name: start, stage: CurrentState}\n"


def test_task_files_beside_a_domain_are_checked_with_their_stages(kabo, parcels):
    (parcels / "tasks").mkdir()
    (parcels / "tasks" / "bring.yaml").write_text(TASK.replace("CurrentState", "CurrentStat"))
    domain = parcels / "domain.yaml"
    text = domain.read_text()
    start = text.index("    preconditions:")
    domain.write_text(text[:start] + "    geometry: bring(p)\n" + text[start:])
    for file in ("one.yaml", "domain.yaml", "tasks/bring.yaml"):
        said = kabo("check", file, "--json")
        (found,) = said.json["diagnostics"]
        assert (said.code, found["file"], found["line"]) == (2, "tasks/bring.yaml", 4)
        assert found["hint"] == 'did you mean "CurrentState"?'
    (parcels / "tasks" / "bring.yaml").write_text(TASK)
    assert kabo("check", "one.yaml", "domain.yaml", "tasks/bring.yaml").code == 0
