"""Rules of the house that no linter knows: what may be imported where, what may be committed, what must be said."""

import ast
import graphlib
import hashlib
import importlib
import importlib.metadata
import os
import pkgutil
import re
import subprocess
import sys
import zipfile
from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from shutil import which

import jupytext
import pytest

import mmt_drake

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = ("mmt_drake", "hw", "diagrams")
DATA_ENDINGS = {".bag", ".db3", ".mcap", ".npz", ".npy", ".csv", ".parquet", ".pcd", ".ply", ".zip", ".gz"}
MACHINE_PATH = re.compile(r"(?<![\w.$}~*])/(?:home|root|tmp|work|mnt|opt|srv|Users)/")
PLACEHOLDER = re.compile(r"\b[A-Z]+_(?:TABLE|ROWS)\b|\b(?:TODO|TBD|FIXME)\b")
REGISTRY_HOST = re.compile(r"https?://[^\s)>\"']*(?:pypi|pythonhosted|npmjs|deb\.debian|archive\.ubuntu|/simple\b)")


@cache
def project_files() -> tuple[Path, ...]:
    """Every file that is, or would be, committed."""
    command = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    listed = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False) if which("git") else None
    if listed is None or listed.returncode != 0:
        pytest.skip("not a git checkout, so there is no telling what would be committed")
    return tuple(path for name in sorted(listed.stdout.split("\0")) if name and (path := ROOT / name).is_file())


@cache
def modules() -> tuple[tuple[Path, ast.Module], ...]:
    """Every Python file of the packages, parsed."""
    return tuple(
        (path.relative_to(ROOT), ast.parse(path.read_text(), str(path)))
        for package in PACKAGES
        for path in sorted((ROOT / package).rglob("*.py"))
    )


def text_lines(path: Path) -> Iterator[tuple[int, str]]:
    content = path.read_bytes()
    if b"\0" not in content:
        yield from enumerate(content.decode("utf-8").splitlines(), start=1)


def test_no_file_names_a_path_of_one_machine_or_a_registry() -> None:
    own = (str(ROOT), str(Path.home()) + "/")
    found = [
        f"{path.relative_to(ROOT)}:{number}: {line.strip()[:100]}"
        for path in project_files()
        for number, line in text_lines(path)
        if MACHINE_PATH.search(line) or REGISTRY_HOST.search(line) or any(piece in line for piece in own)
    ]
    assert not found, "\n".join(found)


def test_the_only_recordings_committed_are_the_project_s_own_and_small() -> None:
    for path in project_files():
        if path.suffix in DATA_ENDINGS:
            allowed = (ROOT / "mmt_drake" / "data", ROOT / "examples")
            assert path.parent in allowed, f"{path} is data outside mmt_drake/data and examples"
            assert path.stat().st_size < 1_000_000, f"{path} is larger than 1 MB"


def test_no_file_is_a_copy_of_a_public_recording(recordings: Path) -> None:
    foreign = {
        hashlib.sha256(path.read_bytes()).digest(): path
        for path in recordings.rglob("*")
        if path.is_file() and path.stat().st_size
    }
    copies = [path for path in project_files() if hashlib.sha256(path.read_bytes()).digest() in foreign]
    assert not copies


def test_a_class_name_stands_once() -> None:
    places: dict[str, list[Path]] = {}
    for path, module in modules():
        for node in ast.walk(module):
            if isinstance(node, ast.ClassDef):
                places.setdefault(node.name, []).append(path)
    assert {name: found for name, found in places.items() if len(found) > 1} == {}


def test_everything_public_has_a_docstring() -> None:
    missing = []
    for path, module in modules():
        if module.body and ast.get_docstring(module) is None:
            missing.append(f"{path}: the module")
        for node in public(module):
            missing += [f"{path}:{node.lineno}: {node.name}"] if ast.get_docstring(node) is None else []
            if isinstance(node, ast.ClassDef):
                missing += [
                    f"{path}:{method.lineno}: {node.name}.{method.name}"
                    for method in public(node)
                    if ast.get_docstring(method) is None and not speaks_elsewhere(method)
                ]
    assert not missing, "\n".join(missing)


Definition = ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef


def public(parent: ast.Module | ast.ClassDef) -> Iterator[Definition]:
    return (node for node in parent.body if isinstance(node, Definition) and not node.name.startswith("_"))


def speaks_elsewhere(method: Definition) -> bool:
    """An overload, a setter, or an override of a virtual method of Drake's, which Drake documents."""
    decorators = [ast.unparse(decorator) for decorator in method.decorator_list]
    return method.name.startswith("Do") or any(
        d in ("overload", "override") or d.endswith(".setter") for d in decorators
    )


def imports(tree: ast.AST) -> Iterator[tuple[int, str]]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from ((node.lineno, alias.name) for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module and node.level == 0:
            yield node.lineno, node.module


def is_part(node: ast.expr) -> bool:
    """Whether an expression is a part of an array."""
    return isinstance(node, ast.Subscript) and any(isinstance(part, ast.Slice) for part in ast.walk(node.slice))


def slow_to_compile(node: ast.AST) -> bool:
    """Whether a statement assigns an array to a part of another, or changes such a part as a whole."""
    if isinstance(node, ast.AugAssign):
        return is_part(node.target)
    if not isinstance(node, ast.Assign):
        return False
    pairs = [(node.targets[0], node.value)]
    if isinstance(node.targets[0], ast.Tuple) and isinstance(node.value, ast.Tuple):
        pairs = list(zip(node.targets[0].elts, node.value.elts, strict=True))
    named = (ast.Name, ast.Attribute)
    return any(
        (isinstance(target, ast.Subscript) and is_part(value)) or (is_part(target) and isinstance(value, named))
        for target, value in pairs
        if not (isinstance(value, ast.Name) and len(value.id) == 1)  # a number
    )


def test_kernels_assign_arrays_by_a_loop() -> None:
    """numba's own way takes seconds to compile, `mmt_drake.numeric.arrays.assign` takes none."""
    slow = [
        f"{path}:{node.lineno}"
        for path, module in modules()
        for function in ast.walk(module)
        if isinstance(function, ast.FunctionDef) and any("njit" in ast.unparse(d) for d in function.decorator_list)
        for node in ast.walk(function)
        if slow_to_compile(node)
    ]
    assert not slow, ", ".join(slow)


# What a folder may not import: what is above it, and a bare `hw` or `diagrams`, which may be anybody's.
ABOVE = {
    "mmt_drake": ("mmt_drake.hw", "mmt_drake.diagrams", "mmt_drake.cli"),
    "hw": ("mmt_drake.diagrams", "mmt_drake.cli"),
    "diagrams": ("mmt_drake.cli",),
}
BARE = ("hw", "diagrams", "notebooks", "tests", "conftest")


def test_imports_follow_the_arrow_from_library_to_hardware_to_diagrams() -> None:
    against = []
    for path, module in modules():
        glue = path.parts[:2] == ("mmt_drake", "cli") or path.name == "__main__.py"
        forbidden = BARE if glue else (*BARE, *ABOVE[path.parts[0]])
        for line, name in imports(module):
            if any(name == above or name.startswith(f"{above}.") for above in forbidden):
                against.append(f"{path}:{line}: imports {name}")
    assert not against, "\n".join(against)


ROOMS = ("signals", "checks", "fit", "search", "decide", "tell")  # of the diagnosis


def test_a_room_of_the_diagnosis_imports_only_those_before_it() -> None:
    against = [
        f"{path}:{line}: imports {name}"
        for path, module in modules()
        if path.parts[:2] == ("mmt_drake", "diagnosis") and path.parts[2] in ROOMS
        for line, name in imports(module)
        if f"{name}..".split(".")[:2] == ["mmt_drake", "diagnosis"]
        and f"{name}..".split(".")[2] not in ROOMS[: ROOMS.index(path.parts[2]) + 1]
    ]
    assert not against, "\n".join(against)


@pytest.mark.parametrize("above", ["mmt_drake", "mmt_drake.hw", "mmt_drake.diagrams", "mmt_drake.diagrams.proof"])
def test_packages_import_one_another_in_no_circle(above: str) -> None:
    def package(name: str) -> str:
        return ".".join(name.split(".")[: above.count(".") + 2])

    uses: dict[str, set[str]] = {}
    for path, module in modules():
        name = ".".join((path if path.parts[0] == "mmt_drake" else Path("mmt_drake", path)).with_suffix("").parts)
        if name.startswith(f"{above}."):
            used = {package(name) for _, name in imports(module) if name.startswith(f"{above}.")}
            uses.setdefault(package(name), set()).update(used - {package(name)})
    graphlib.TopologicalSorter(uses).prepare()  # raises CycleError, with the circle


def test_the_command_line_imports_a_command_s_code_only_when_it_is_used() -> None:
    program = (
        "import sys, mmt_drake.cli.main as m; m.main(['--help']); m.main(['convert', '--help']); print(*sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    loaded = set(done.stdout.splitlines()[-1].split())
    assert "mmt_drake.cli.main" in loaded
    assert not loaded & {"mmt_drake.diagrams", "mmt_drake.hw", "pydrake", "open3d"}


@pytest.mark.parametrize("scenario", ["setup1", "setup3"])
def test_a_simulation_loads_what_describes_devices_and_no_driver(scenario: str) -> None:
    program = f"import sys, mmt_drake as m; m.build_station(m.load_scenario({scenario!r})); print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    loaded = {name for name in done.stdout.split() if name.startswith("mmt_drake.hw.") and name.count(".") > 2}
    describing = {"settings", "options", "limits", "depth", "extrinsics", "noise", "view"}
    assert {name.rpartition(".")[2] for name in loaded} <= describing, sorted(loaded)


def test_what_is_imported_is_declared_as_a_dependency() -> None:
    declared = {normal(requirement) for requirement in importlib.metadata.requires("mmt_drake") or []}
    brought_by = importlib.metadata.packages_distributions()
    undeclared = {
        f"{path}:{line}: {name}"
        for path, module in modules()
        for line, name in imports(module)
        if (top := name.split(".")[0]) not in sys.stdlib_module_names
        and top not in ("mmt_drake", "yaml")  # Drake's yaml
        and not {normal(distribution) for distribution in brought_by.get(top, [top])} & declared
    }
    assert not undeclared, "\n".join(sorted(undeclared))


def normal(requirement: str) -> str:
    """Name of a requirement, spelled as package indexes compare it."""
    match = re.match(r"[\w.-]+", requirement)
    assert match
    return re.sub(r"[-_.]+", "-", match[0]).lower()


def test_an_installation_brings_hw_and_diagrams_inside_mmt_drake_and_no_bare_name(tmp_path: Path) -> None:
    program = """
import importlib.util, mmt_drake.hw, mmt_drake.diagrams
assert not importlib.util.find_spec("hw") and not importlib.util.find_spec("diagrams")
"""
    subprocess.run([sys.executable, "-c", program], cwd=tmp_path, env=elsewhere(), check=True)


def elsewhere() -> dict[str, str]:
    """The environment of somebody who is not in the checkout."""
    return {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Built from what would be committed, and nothing else."""
    folder = tmp_path_factory.mktemp("wheel")
    source = folder / "source"
    for path in project_files():
        if path.relative_to(ROOT).parts[0] in {*PACKAGES, "pyproject.toml", "README.md", "LICENSE"}:
            copy = source / path.relative_to(ROOT)
            copy.parent.mkdir(parents=True, exist_ok=True)
            copy.write_bytes(path.read_bytes())
    for name in ("hw", "diagrams"):
        (source / "mmt_drake" / name).symlink_to(f"../{name}")
    build = "from setuptools import build_meta; print(build_meta.build_wheel('..'))"
    subprocess.run([sys.executable, "-c", build], cwd=source, check=True, capture_output=True)
    (built,) = folder.glob("*.whl")
    return built


def test_a_wheel_holds_the_three_packages_with_their_data_and_templates_below_mmt_drake(wheel: Path) -> None:
    packed = {name for name in zipfile.ZipFile(wheel).namelist() if ".dist-info/" not in name}
    committed = [path.relative_to(ROOT) for path in project_files() if path.relative_to(ROOT).parts[0] in PACKAGES]
    assert packed == {str(path if path.parts[0] == "mmt_drake" else Path("mmt_drake", path)) for path in committed}


def test_a_wheel_runs_a_scenario_beside_strangers_called_hw_and_diagrams(wheel: Path, tmp_path: Path) -> None:
    zipfile.ZipFile(wheel).extractall(tmp_path)
    for stranger in ("hw", "diagrams"):
        (tmp_path / f"{stranger}.py").write_text("raise RuntimeError('not ours')\n")
    command = [sys.executable, "-m", "mmt_drake", "run", "setup1", "--seconds", "0.1", "--record", "out.csv"]
    not_compiled = elsewhere() | {"NUMBA_DISABLE_JIT": "1"}  # it would take most of a minute
    subprocess.run(command, cwd=tmp_path, env=not_compiled, check=True, capture_output=True)
    assert (tmp_path / "out.csv").stat().st_size


def test_every_dependency_is_pinned_and_pins_are_nothing_but_versions() -> None:
    lines = (ROOT / "constraints.txt").read_text().splitlines()
    pins = [line for line in lines if line and not line.startswith("#")]
    odd = [line for line in pins if not re.fullmatch(r"[a-z0-9-]+==[\w.]+( ; [\w ._'<>=!]+)?", line)]
    assert not odd
    pinned = {line.split("==")[0] for line in pins}
    required = {normal(requirement) for requirement in importlib.metadata.requires("mmt_drake") or []}
    assert required <= pinned, f"not in constraints.txt: {', '.join(sorted(required - pinned))}"


def test_every_notebook_is_paired_with_its_script_and_was_executed() -> None:
    for script in sorted((ROOT / "notebooks").glob("*.py")):
        written, executed = jupytext.read(script), jupytext.read(script.with_suffix(".ipynb"))
        assert [cell.source for cell in written.cells] == [cell.source for cell in executed.cells], "make notebooks"
        code = [cell for cell in executed.cells if cell.cell_type == "code" and cell.source]
        assert [cell.execution_count for cell in code] == list(range(1, len(code) + 1)), "make notebooks"
        outputs = [output for cell in code for output in cell.outputs]
        assert any("image/png" in output.get("data", {}) for output in outputs)
        assert not [output.text for output in outputs if output.get("name") == "stderr"]


def test_a_file_of_tests_has_a_name_of_its_own() -> None:
    names = Counter(path.name for path in (ROOT / "tests").rglob("test_*.py"))
    assert [name for name, count in names.items() if count > 1] == []


def test_a_study_among_short_tests_is_run_with_the_studies() -> None:
    # This file holds the mark's name alone, and no test that has it.
    files = [path for path in (ROOT / "tests").rglob("test_*.py") if "@pytest.mark.study" in path.read_text()]
    of_short = sorted(str(path) for path in files if path != Path(__file__))
    assert of_short
    command = [sys.executable, "-m", "pytest", "-m", "study", "--collect-only", "-q"]
    found = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False).stdout
    assert [name for name in of_short if f"{Path(name).relative_to(ROOT)}::" not in found] == []


def test_no_markdown_holds_a_placeholder() -> None:
    found = [
        f"{path.relative_to(ROOT)}:{number}: {line.strip()[:100]}"
        for path in project_files()
        if path.suffix == ".md"
        for number, line in text_lines(path)
        if PLACEHOLDER.search(line)
    ]
    assert not found, "\n".join(found)


def test_the_changelog_tells_of_this_version() -> None:
    assert f"\n## [{mmt_drake.__version__}]" in (ROOT / "CHANGELOG.md").read_text()


@pytest.mark.parametrize("package", ["mmt_drake", "mmt_drake.hw", "mmt_drake.diagrams"])
def test_what_a_package_promises_is_there(package: str) -> None:
    found = importlib.import_module(package)
    names = [m.name for m in pkgutil.walk_packages(found.__path__, f"{package}.") if m.ispkg]
    modules = [found, *(importlib.import_module(name) for name in names if "emulator" not in name)]
    assert not [f"{m.__name__}.{n}" for m in modules for n in getattr(m, "__all__", ()) if not hasattr(m, n)]
