"""Size of the repository: lines, statements, functions, names and pages, beside the targets.

    python -m benchmarks.house [CHECKOUT]

The sources are parsed, not run. Statements are the `ast.stmt` nodes; the lines of a body are those
of a function without its signature and its docstring. A page is a file of `docs`; its words include
tables and programs. Pages that a command writes (commands, keys, datasets) are not counted.
"""

from __future__ import annotations

import ast
import sys
from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path

MOST_PARAMETERS = 8  # of a function, self and cls among them
FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)
DOCUMENTED = (ast.Module, ast.ClassDef, *FUNCTIONS)
GENERATED = {"commands.md", "keys.md", "datasets.md"}
FORBIDDEN = {"found", "told", "kept", "held", "own", "known", "said", "given", "taken"}
FORBIDDEN |= {"more", "way", "once"}
"""Names that say nothing about the value they stand for."""

TARGETS = {
    "package, lines": (42_085, 29_000, 31_000, 34_000),
    "kernels, lines": (14_785, 12_800, 12_800, 15_000),
    "tests, lines": (38_796, 30_000, 31_000, 33_000),
    "benchmarks, lines": (10_417, 3_500, 3_700, 4_000),
    "pages": (34, 20, None, None),
    "words of pages": (43_300, 26_000, 27_000, 29_000),
    "CHANGELOG [kB]": (48, 6, None, None),
    "CONTRIBUTING [kB]": (41, 14, None, None),
}
"""Where each count began, and where it should be after each step of `STEPS`."""
STEPS = ("at b6c556c", "cut, text", "records", "structures")

OTHERS = {
    "scipy.optimize": (22, 21, 554),
    "diffrax": (32, 16, 261),
    "NumbaCS": (20, 27, 847),
    "xarray": (37, 11, 871),
}
"""Functions per 1,000 lines, lines per function body and lines per file of other libraries."""


def modules(package: Path) -> dict[str, Path]:
    """Return the sources of a package by dotted name; the package's own `__init__` is ''."""
    paths = sorted(package.rglob("*.py"))
    dotted = (".".join(path.relative_to(package).with_suffix("").parts) for path in paths)
    return {n.removesuffix("__init__").rstrip("."): p for n, p in zip(dotted, paths, strict=True)}


@cache
def parsed(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


def imports(path: Path, package: Path) -> set[str]:
    """Return the full dotted names that a source of a package imports, at any depth."""
    home = (package.name, *path.relative_to(package).parts[:-1])
    names = set()
    for node in ast.walk(parsed(path)):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            base = home[: len(home) - node.level + 1] if node.level else ()
            source = ".".join([*base, *filter(None, [node.module])])
            names |= {f"{source}.{alias.name}" for alias in node.names}
    return names


def graph(package: Path) -> dict[str, set[str]]:
    """Return the modules of the package that each of its modules imports."""
    sources, arrows = modules(package), {}
    for name, path in sources.items():
        inside = [
            n.split(".")[1:] for n in imports(path, package) if n.split(".")[0] == package.name
        ]
        starts = ([".".join(parts[:n]) for n in range(len(parts), -1, -1)] for parts in inside)
        arrows[name] = {next(s for s in candidates if s in sources) for candidates in starts}
        arrows[name] -= {name}
    return arrows


def functions(package: Path) -> Iterator[tuple[str, ast.FunctionDef]]:
    """Yield every function and method of a package, nested ones too, with its module's name."""
    for name, path in modules(package).items():
        for node in ast.walk(parsed(path)):
            if isinstance(node, ast.FunctionDef):
                yield f"{name}.{node.name}", node


def parameters(function: ast.FunctionDef) -> int:
    """Return how many parameters a function takes, self and cls among them."""
    return sum(isinstance(node, ast.arg) for node in ast.walk(function.args))


def repeated_constants(package: Path) -> set[str]:
    """Return the constants of the kernels that several modules assign, or that are one letter."""
    homes: dict[str, set[str]] = {}
    for module, path in modules(package).items():
        if module.split(".")[0] == "kernels":
            assignments = (node for node in parsed(path).body if isinstance(node, ast.Assign))
            for node in (n for a in assignments for t in a.targets for n in ast.walk(t)):
                if isinstance(node, ast.Name) and node.id.isupper():
                    homes.setdefault(node.id, set()).add(module)
    return {name for name, where in homes.items() if len(where) > 1 or len(name) == 1}


def source_counts(paths: list[Path]) -> Counter[str]:
    counts = Counter(files=len(paths))
    for path in paths:
        counts["lines"] += len(path.read_text(encoding="utf-8").splitlines())
        for node in ast.walk(parsed(path)):
            counts["statements"] += isinstance(node, ast.stmt)
            counts["names to avoid"] += bound_name(node) in FORBIDDEN
            if isinstance(node, DOCUMENTED) and (text := ast.get_docstring(node)) is not None:
                counts["docstrings"] += 1
                counts["lines of docstrings"] += len(text.splitlines())
                counts["'Return what'"] += text.startswith("Return what")
                counts["'Tell'"] += text.startswith("Tell ")
            if isinstance(node, FUNCTIONS):
                counts["functions"] += 1
                body = node.body[ast.get_docstring(node) is not None :]
                if body:
                    counts["lines of bodies"] += (node.end_lineno or 0) - body[0].lineno + 1
    return counts


def bound_name(node: ast.AST) -> str | None:
    """Return the name that a node gives to a value: a variable, a parameter or an attribute."""
    if isinstance(node, ast.arg):
        return node.arg
    if isinstance(node, ast.Name | ast.Attribute) and isinstance(node.ctx, ast.Store):
        return node.id if isinstance(node, ast.Name) else node.attr
    return None


def areas(root: Path) -> dict[str, Counter[str]]:
    package = sorted((root / "nlds_vines").rglob("*.py"))
    kernels = [path for path in package if root / "nlds_vines" / "kernels" in path.parents]
    return {
        "package": source_counts([path for path in package if path not in kernels]),
        "kernels": source_counts(kernels),
        "tests": source_counts(sorted((root / "tests").rglob("*.py"))),
        "benchmarks": source_counts(sorted((root / "benchmarks").rglob("*.py"))),
    }


def shape(counts: Counter[str]) -> tuple[float, float, float]:
    """Return functions per 1,000 lines, lines per function body and lines per file."""
    return (
        1000 * counts["functions"] / max(counts["lines"], 1),
        counts["lines of bodies"] / max(counts["functions"], 1),
        counts["lines"] / max(counts["files"], 1),
    )


def progress(root: Path, sources: dict[str, Counter[str]]) -> dict[str, float]:
    """Return today's value of each count in `TARGETS`."""
    pages = [path for path in (root / "docs").glob("*.md") if path.name not in GENERATED]
    texts = (path.read_text(encoding="utf-8") for path in [*pages, root / "README.md"])
    return {
        **{f"{area}, lines": counts["lines"] for area, counts in sources.items()},
        "pages": len(pages),
        "words of pages": sum(len(text.split()) for text in texts),
        "CHANGELOG [kB]": round((root / "CHANGELOG.md").stat().st_size / 1000),
        "CONTRIBUTING [kB]": round((root / "CONTRIBUTING.md").stat().st_size / 1000),
    }


def report(root: Path) -> Iterator[str]:
    """Yield the lines of both tables: sources, and all counts beside their targets."""
    sources = areas(root)
    yield " " * 28 + "".join(f"{area:>15}" for area in (*sources, *OTHERS))
    for what in (
        "files",
        "lines",
        "statements",
        "functions",
        "docstrings",
        "lines of docstrings",
        "'Return what'",
        "'Tell'",
        "names to avoid",
    ):
        yield f"{what:28}" + "".join(f"{counts[what]:15,}" for counts in sources.values())
    shapes = [*map(shape, sources.values()), *OTHERS.values()]
    for row, what in enumerate(("functions per 1,000 lines", "lines per body", "lines per file")):
        yield f"{what:28}" + "".join(f"{numbers[row]:15.3g}" for numbers in shapes)
    yield ""
    yield f"{'':28}{'today':>12}" + "".join(f"{step:>12}" for step in STEPS)
    for what, value in progress(root, sources).items():
        cells = ("" if target is None else f"{target:,}" for target in TARGETS[what])
        yield f"{what:28}{value:12,}" + "".join(f"{cell:>12}" for cell in cells)


if __name__ == "__main__":
    checkout = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parents[1]
    print("\n".join(report(checkout.resolve())))
