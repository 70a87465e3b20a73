"""The rooms of CONTRIBUTING.md and of the picture in docs/explanation/architecture.md are those of the import contracts."""

from scripts.rooms import PAGE, PICTURE, ROOT, flat, house, picture, renewed


def test_page_and_picture_are_what_the_script_writes():
    text = PAGE.read_text()
    assert renewed(text) == text, f"python -m scripts.rooms writes {PAGE.relative_to(ROOT)}"
    assert picture() == PICTURE.read_text(), f"python -m scripts.rooms writes {PICTURE.relative_to(ROOT)}"


def test_every_package_but_kernels_is_a_room_and_says_what_it_is_for():
    rooms = flat(tuple(each for row in house() for each in row))
    packages = {path.parent for path in (ROOT / "kabo").rglob("*/__init__.py") if path.parent.name != "kernels"}
    assert {ROOT / "kabo" / room.label for room in rooms if not room.is_file} == packages
    assert all(room.purpose.endswith((".", "]")) and len(room.purpose) > 15 for room in rooms)
