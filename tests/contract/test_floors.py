"""Arrows point down: who may import what, read from the sources."""

import ast
import sys
from pathlib import Path

import pytest

import nlds_vines

PACKAGE = Path(nlds_vines.__path__[0])
SOURCES = sorted(path for path in PACKAGE.rglob("*.py"))
KERNELS = [path for path in SOURCES if path.parent.name == "kernels"]
FIGURES = [path for path in SOURCES if path.parent.name == "figures"]

FLOORS = (
    {"kernels", "_jit"},  # numbers in, numbers out
    {
        "errors",
        "parameters",
        "scenes",
        "system",
        "catalogue",
        "_resources",
        "_toml",
        "arc",
        "linear",
    },
    {
        "axes",
        "starts",
        "wants",
        "record",
        "scan",
        "regimes",
        "shows",
        "provenance",
        "durable",
        "pages",
    },
    {"signals", "spectra", "recipe", "recipe_file", "view", "coexistence", "survival", "ensemble"},
    {"cut", "manifest", "interrupts", "room", "progress"},
    {
        "block",
        "batch",
        "evidence",
        "refinement",
        "simulation",
        "classification",
        "viewing",
        "archive",
        "partfile",
        "folder",
        "parts",
        "peers",
    },
    {
        "engine",
        "cluster",
        "search",
        "figures",
        "claims",
        "retention",
        "report",
        "precision",
        "extremes",
    },
    {
        "bifurcation",
        "accuracy",
        "costs",
        "portrait",
        "reproduce",
        "transients",
        "tuning",
        "status",
        "consolidation",
        "verification",
        "rerun",
        "comparison",
        "_command",
        "_scan_options",
        "_run_options",
        "_tuning_options",
        "_accuracy_modes",
        "__main__",
    },
)
"""From the bottom up; a module of one floor imports from its own and from those below."""

SOLVERS = {
    "peers.numbalsoda_solvers": {"numbalsoda"},
    "peers.heyoka_taylor": {"heyoka"},
    "peers.sundials": {"sksundae"},
    "peers.diffrax_solvers": {"diffrax", "jax", "optimistix"},
}
"""Other people's solvers, what the extra `peers` brings: each is known to one module."""

INPUT_OUTPUT = {"open", "print", "input", "exec", "eval"}


def name_of(path):
    """Return the module's name inside the package, dotted."""
    parts = path.relative_to(PACKAGE).with_suffix("").parts
    return ".".join(part for part in parts if part != "__init__")


def imports(path):
    """Return the full names of all that a source imports, but for what only type checkers see."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    package = ["nlds_vines", *path.relative_to(PACKAGE).parts[:-1]]
    unseen = {
        node
        for branch in ast.walk(tree)
        if isinstance(branch, ast.If) and ast.unparse(branch.test) == "TYPE_CHECKING"
        for node in ast.walk(branch)
    }
    found = set()
    for node in set(ast.walk(tree)) - unseen:
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else []
            home = ".".join([*base, *filter(None, [node.module])])
            found |= {f"{home}.{alias.name}" for alias in node.names}
    return found


def who_imports(library, sources=SOURCES):
    """Return the names of the modules that import a library, anywhere in them."""
    return {
        name_of(path)
        for path in sources
        if any(name == library or name.startswith(f"{library}.") for name in imports(path))
    }


def inside(path):
    """Return the top-level names of the package's own modules that a source imports."""
    own = {name.split(".")[1] for name in imports(path) if name.startswith("nlds_vines.")}
    return own & {name_of(source).split(".")[0] for source in SOURCES}


def functions(path):
    """Return the public functions and classes of a source with their dotted names."""

    def walk(node, prefix):
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.FunctionDef | ast.ClassDef) and child.name[0] != "_":
                yield f"{prefix}.{child.name}", child
                if isinstance(child, ast.ClassDef):
                    yield from walk(child, f"{prefix}.{child.name}")

    return list(walk(ast.parse(path.read_text(encoding="utf-8")), name_of(path)))


def test_there_is_something_to_look_at():
    assert len(KERNELS) > 10
    assert len(FIGURES) > 3
    assert name_of(PACKAGE / "kernels" / "orbit.py") == "kernels.orbit"
    assert "nlds_vines.kernels.contact.contact" in imports(PACKAGE / "kernels" / "orbit.py")
    assert "nlds_vines._jit.jit" in imports(PACKAGE / "kernels" / "orbit.py")


def test_every_module_stands_on_one_floor():
    placed = [name for floor in FLOORS for name in floor]
    assert len(placed) == len(set(placed))
    assert set(placed) == {name_of(path).split(".")[0] for path in SOURCES} - {""}


@pytest.mark.parametrize("path", [p for p in SOURCES if name_of(p)], ids=name_of)
def test_arrows_point_down(path):
    own = name_of(path).split(".")[0]
    height = next(i for i, floor in enumerate(FLOORS) if own in floor)
    allowed = set().union(*FLOORS[: height + 1])
    assert inside(path) <= allowed


@pytest.mark.parametrize("path", KERNELS, ids=name_of)
def test_kernels_know_numbers_only(path):
    foreign = {name.split(".")[0] for name in imports(path)} - {"nlds_vines", "__future__"}
    assert foreign <= {"numba", "numpy", "math", "typing"}
    assert inside(path) <= {"_jit", "kernels"}


@pytest.mark.parametrize("path", KERNELS, ids=name_of)
def test_kernels_read_and_write_nothing(path):
    tree = ast.parse(path.read_text(encoding="utf-8"))
    names = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
    assert not names & INPUT_OUTPUT


def test_only_the_archive_imports_h5py():
    assert who_imports("h5py") == {"archive"}


def test_only_the_figures_import_matplotlib():
    found = who_imports("matplotlib")
    assert found
    assert found <= {name_of(path) for path in FIGURES}


def test_only_the_cluster_imports_dask():
    assert who_imports("distributed") == {"cluster"}


def test_figures_call_no_kernel():
    for path in FIGURES:
        assert not inside(path) & {"kernels", "_jit", "block", "engine", "simulation"}


def test_claims_and_report_know_archives_only():
    judges = [path for path in SOURCES if name_of(path).split(".")[0] in ("claims", "report")]
    assert len(judges) > 5
    for path in (*judges, PACKAGE / "retention.py"):
        assert not inside(path) & {"kernels", "_jit", "block", "engine", "simulation", "figures"}


def test_one_module_decides_how_kernels_are_compiled():
    assert who_imports("numba.core") | who_imports("numba.extending") == {"_jit"}
    ours = {"_jit", "engine", "kernels.lanes"}  # threads, prange
    # a right-hand side for another library's solver must be a C callback, which only `cfunc` makes
    assert who_imports("numba") == ours | {"peers.numbalsoda_solvers"}
    for path in SOURCES:
        for decorator in decorators(path):
            assert not decorator.startswith(("numba.", "njit", "overload"))


def decorators(path):
    tree = ast.parse(path.read_text(encoding="utf-8"))
    kinds = ast.FunctionDef | ast.ClassDef
    return [
        ast.unparse(decorator)
        for node in ast.walk(tree)
        if isinstance(node, kinds)
        for decorator in node.decorator_list
    ]


def test_parallel_loops_stand_in_one_module():
    parallel = {name_of(p) for p in SOURCES if any("parallel" in d for d in decorators(p))}
    assert parallel == {"kernels.lanes"}
    ranges = {name_of(p) for p in SOURCES if "prange(" in p.read_text(encoding="utf-8")}
    assert ranges == {"kernels.lanes"}


def test_no_fast_mathematics():
    for path in SOURCES:
        tree = ast.parse(path.read_text(encoding="utf-8"))
        words = {node.arg for node in ast.walk(tree) if isinstance(node, ast.keyword)}
        keys = {node.value for node in ast.walk(tree) if isinstance(node, ast.Constant)}
        assert "fastmath" not in words | {key for key in keys if isinstance(key, str)}


@pytest.mark.parametrize("path", KERNELS, ids=name_of)
def test_every_kernel_is_compiled(path):
    for name, node in functions(path):
        if isinstance(node, ast.FunctionDef):
            used = {ast.unparse(decorator).split("(")[0] for decorator in node.decorator_list}
            assert used & {"jit", "chosen"}, name


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: name_of(path) or "nlds_vines")
def test_everything_public_says_what_it_is(path):
    tree = ast.parse(path.read_text(encoding="utf-8"))
    assert path.name == "__init__.py" or ast.get_docstring(tree)
    for name, node in functions(path):
        assert ast.get_docstring(node), name


def test_only_the_standard_library_and_what_is_declared_is_imported():
    declared = {"numba", "numpy", "scipy", "h5py", "matplotlib", "mpl_toolkits", "tqdm"}
    declared |= {"distributed", "cma"}  # of the extras `cluster` and `cma`, of one module each
    for path in SOURCES:
        outside = {name.split(".")[0] for name in imports(path)} - {"nlds_vines"}
        found = outside - set(sys.stdlib_module_names)
        assert found <= declared | SOLVERS.get(name_of(path), set()), path
