"""The process that expands a xacro file: `python -m kabo.scene.urdf_files.xacro_process`, asked on standard input.

Xacro keeps its state in its module, prints to standard error, and evaluates expressions of the file: hence a process of
its own. It prints one JSON object: `{"xml": …, "files": […]}`, or `{"error": …}`.
"""

import json
import sys
from pathlib import Path
from types import ModuleType
from typing import Any
from xml.parsers import expat

from kabo.language.robot_files.packages import package_folder


def _package_index(packages: dict[str, Path], beside: Path) -> ModuleType:
    """The module by which xacro asks where a package is: `$(find NAME)`."""
    index: Any = ModuleType("ament_index_python.packages")

    def folder(name: str) -> str:
        found = package_folder(name, packages, beside)
        if found is None:
            raise LookupError(f'unknown package "{name}"')
        return str(found)

    index.get_package_share_directory = folder
    return index  # type: ignore[no-any-return]


# What the expressions and arguments of a file may raise; all else ends the process, whose last line is told.
_OF_EXPRESSIONS = (
    *(ArithmeticError, AttributeError, LookupError, NameError, OSError, RuntimeError, SyntaxError, TypeError),
    ValueError,
)


def expanded(path: Path, packages: dict[str, Path]) -> dict[str, Any]:
    """The text that xacro makes of a file, and the files that it includes; or the error."""
    sys.modules["ament_index_python"] = ModuleType("ament_index_python")
    sys.modules["ament_index_python.packages"] = _package_index(packages, path)
    import xacro
    from xacro.substitution_args import SubstitutionException

    try:
        document = xacro.process_file(str(path), mappings={})
    except (xacro.XacroException, SubstitutionException, expat.ExpatError, *_OF_EXPRESSIONS) as error:
        at = str(xacro.filestack[-1]) if getattr(xacro, "filestack", None) else str(path)
        return {"error": f"{type(error).__name__}: {error}", "file": at}
    return {"xml": document.toprettyxml(indent="  "), "files": [str(each) for each in xacro.all_includes]}


def main() -> None:
    """Answers the request on standard input."""
    request = json.load(sys.stdin)
    packages = {name: Path(folder) for name, folder in request["packages"].items()}
    answer = json.dumps(expanded(Path(request["path"]), packages))
    sys.stdout.write(answer)


if __name__ == "__main__":
    main()
