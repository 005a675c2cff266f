"""What a reader has before them: sizes of the sources, folded code, double names and the trunk.

    python -m benchmarks.house [CHECKOUT]
    python -m benchmarks.house --beside FOLDER      ... beside the sources of another library
    python -m benchmarks.house --names              ... and the names that several modules define
    python -m benchmarks.house --files              ... and the files of the trunk

These numbers are reported; none is a target, and no test checks one. A token is one of Python's
without comments, docstrings, line ends and indentation; an f-string is one. Folded code is counted
per 1,000 statements: assignments such as `a, b = x, y`, conditional expressions, comprehensions.
The share of docstrings is that of lines, and includes the strings below constants.

The trunk is what one bifurcation diagram with its picture executes: functions that are called at
least once, and their tokens. Kernels run as plain Python, so that the parts of them that are pruned
for this system do not count. It takes a minute.
"""

from __future__ import annotations

import argparse
import ast
import contextlib
import inspect
import io
import json
import os
import subprocess
import sys
import tempfile
import textwrap
import threading
import tokenize
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from pathlib import Path
from types import CodeType

HERE = Path(__file__).resolve().parents[1]
SPLIT = {"kernels", "tasks"}
"""Folders of the package whose folders and modules have rows of their own."""

ASKING = ("is_host", "has_hosts", "HOST", "General", "HostScene")
"""Names by which code asks what kind of system it has."""
MAY_ASK = ("engine", "model.presets", "model.system")
"""Where it may: modules whose dotted names begin so."""

TRUNK = [
    "bifurcation", "--vary", "omega=6:6.4:5", "--transient", "50", "--periods", "20",
    "-o", "trunk.h5", "--plot", "trunk.png", "--quiet",
]  # fmt: skip
"""The default diagram, with five frequencies and short orbits."""

Place = tuple[str, int]
"""The name of a function, and the line of its first decorator or of `def`."""


# ---- modules -------------------------------------------------------------------------------------


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


# ---- tokens and folded code ----------------------------------------------------------------------


NOT_CODE = {
    tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT,
    tokenize.ENCODING, tokenize.ENDMARKER,
}  # fmt: skip
# Python 3.12 and later split an f-string, earlier ones do not.
F_STRING_BEGINS = getattr(tokenize, "FSTRING_START", None)
F_STRING_ENDS = getattr(tokenize, "FSTRING_END", None)


@cache
def docstring_lines(path: Path) -> frozenset[int]:
    """Return the lines of a source that docstrings fill, those below constants among them."""
    lines: set[int] = set()
    for node in ast.walk(parsed(path)):
        if not isinstance(node, ast.Expr) or not isinstance(node.value, ast.Constant):
            continue
        if isinstance(node.value.value, str):
            lines |= set(range(node.lineno, (node.end_lineno or node.lineno) + 1))
    return frozenset(lines)


@cache
def token_lines(path: Path) -> tuple[int, ...]:
    """Return the line of each code token of a source."""
    docstrings = docstring_lines(path)
    lines = []
    depth = 0  # of f-strings
    with path.open(encoding="utf-8") as source:
        for token in tokenize.generate_tokens(source.readline):
            if token.type == F_STRING_ENDS:
                depth -= 1
            is_code = token.type not in NOT_CODE and token.type != F_STRING_ENDS
            if is_code and depth == 0 and token.start[0] not in docstrings:
                lines.append(token.start[0])
            if token.type == F_STRING_BEGINS:
                depth += 1
    return tuple(lines)


def is_folded_assignment(node: ast.AST) -> bool:
    if not isinstance(node, ast.Assign):
        return False
    return isinstance(node.targets[0], ast.Tuple) and isinstance(node.value, ast.Tuple)


COMPREHENSIONS = (ast.ListComp, ast.SetComp, ast.DictComp, ast.GeneratorExp)


def counts_of(paths: Iterable[Path]) -> Counter[str]:
    """Count tokens, statements, folded code and lines of docstrings of sources."""
    counts: Counter[str] = Counter()
    for path in paths:
        counts["files"] += 1
        counts["lines"] += len(path.read_text(encoding="utf-8").splitlines())
        counts["tokens"] += len(token_lines(path))
        counts["lines of docstrings"] += len(docstring_lines(path))
        for node in ast.walk(parsed(path)):
            counts["statements"] += isinstance(node, ast.stmt)
            counts["functions"] += isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
            counts["a, b = x, y"] += is_folded_assignment(node)
            counts["x if c else y"] += isinstance(node, ast.IfExp)
            counts["comprehensions"] += isinstance(node, COMPREHENSIONS)
    return counts


def sources_of(folder: Path) -> list[Path]:
    """Return the sources of a library without its tests."""
    paths = sorted(folder.rglob("*.py"))
    return [path for path in paths if not {"test", "tests"} & {*path.relative_to(folder).parts}]


def areas(root: Path) -> dict[str, list[Path]]:
    """Return the sources of the package without kernels, of kernels, tests and benchmarks."""
    kernels = sorted((root / "nlds_vines" / "kernels").rglob("*.py"))
    package = sorted((root / "nlds_vines").rglob("*.py"))
    return {
        "package without kernels": [path for path in package if path not in kernels],
        "kernels": kernels,
        "tests": sorted((root / "tests").rglob("*.py")),
        "benchmarks": sorted((root / "benchmarks").rglob("*.py")),
    }


def parts(package: Path) -> dict[str, list[Path]]:
    """Return the sources of each folder and module of a package, and of those in `SPLIT`."""
    paths: dict[str, list[Path]] = defaultdict(list)
    for path in sorted(package.rglob("*.py")):
        names = path.relative_to(package).parts
        depth = 2 if names[0] in SPLIT else 1
        paths["/".join(names[:depth])].append(path)
    return dict(paths)


COLUMNS = ("files", "lines", "tokens", "functions")
FOLDED = ("a, b = x, y", "x if c else y", "comprehensions")


def size_table(rows: dict[str, list[Path]]) -> Iterator[str]:
    """Yield the lines of a table of sizes and folded code, one row for each group of sources."""
    yield f"{'':26}" + "".join(f"{name:>16}" for name in (*COLUMNS, *FOLDED, "docstrings [%]"))
    for name, paths in rows.items():
        counts = counts_of(paths)
        cells = [f"{counts[column]:16,}" for column in COLUMNS]
        for column in FOLDED:
            cells.append(f"{1000 * counts[column] / max(counts['statements'], 1):16.1f}")
        cells.append(f"{100 * counts['lines of docstrings'] / max(counts['lines'], 1):16.0f}")
        yield f"{name:26}" + "".join(cells)


# ---- words that ask, and double names ------------------------------------------------------------


def identifiers(path: Path) -> Iterator[str]:
    """Yield the names that a source uses or defines, but not those in imports and annotations."""
    open_nodes: list[ast.AST] = [parsed(path)]
    while open_nodes:
        node = open_nodes.pop()
        if isinstance(node, ast.Name):
            yield node.id
        elif isinstance(node, ast.Attribute):
            yield node.attr
        elif isinstance(node, ast.arg | ast.keyword):
            yield node.arg or ""
        elif isinstance(node, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            yield node.name
        for field, value in ast.iter_fields(node):
            if field in ("annotation", "returns"):
                continue
            children = value if isinstance(value, list) else [value]
            open_nodes += [child for child in children if isinstance(child, ast.AST)]


def asking_words(package: Path) -> dict[str, Counter[str]]:
    """Return how often each module uses the words of `ASKING`, by dotted name."""
    places = {}
    for name, path in modules(package).items():
        if name.startswith(MAY_ASK):
            continue
        words = Counter(word for word in identifiers(path) if word in ASKING)
        if words:
            places[name] = words
    return places


def names_defined_twice(
    package: Path, kind: type[ast.ClassDef] | type[ast.FunctionDef]
) -> dict[str, list[str]]:
    """Return the names that several modules give to classes, or to functions, with the modules."""
    homes: dict[str, list[str]] = defaultdict(list)
    for module, path in modules(package).items():
        for name in {node.name for node in parsed(path).body if isinstance(node, kind)}:
            homes[name].append(module)
    return {name: where for name, where in sorted(homes.items()) if len(where) > 1}


# ---- the trunk -----------------------------------------------------------------------------------


def executed(package: Path, call: Callable[[], object]) -> dict[Path, set[Place]]:
    """Return the functions of a package that a call executes, in this and in new threads.

    Lambdas, comprehensions, class bodies and modules do not count.
    """
    codes: set[CodeType] = set()
    folder = f"{package}{os.sep}"

    def note(frame: object, event: str, argument: object) -> None:
        if event == "call":
            codes.add(frame.f_code)  # type: ignore[attr-defined]

    threading.setprofile(note)
    sys.setprofile(note)
    try:
        call()
    finally:
        sys.setprofile(None)
        threading.setprofile(None)
    places: dict[Path, set[Place]] = defaultdict(set)
    for code in codes:
        is_function = bool(code.co_flags & inspect.CO_OPTIMIZED) and code.co_name[0] != "<"
        if is_function and code.co_filename.startswith(folder):
            places[Path(code.co_filename)].add((code.co_name, code.co_firstlineno))
    return places


def function_counts(path: Path, places: set[Place]) -> tuple[int, int]:
    """Return how many functions of a source are at these places, and their code tokens."""
    count = 0
    lines: set[int] = set()
    for node in ast.walk(parsed(path)):
        if not isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            continue
        first = min([node.lineno, *(decorator.lineno for decorator in node.decorator_list)])
        if (node.name, first) in places:
            count += 1
            lines |= set(range(first, (node.end_lineno or first) + 1))
    return count, sum(line in lines for line in token_lines(path))


def run_trunk(root: Path) -> dict[Path, set[Place]]:
    """Return the functions that the trunk executes, by source; it runs in another process."""
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(
            [sys.executable, "-P", str(Path(__file__).resolve()), "--execute"],
            cwd=folder,
            env={**os.environ, "PYTHONPATH": str(root), "NUMBA_DISABLE_JIT": "1"},
            stdout=subprocess.PIPE,
            check=True,
        )
    places = json.loads(done.stdout)
    return {Path(path): {(name, line) for name, line in of} for path, of in places.items()}


def execute() -> None:
    """Run the command of the trunk in this process, and print the functions that it executes."""
    from nlds_vines import __file__ as source
    from nlds_vines.__main__ import main as command

    with contextlib.redirect_stdout(io.StringIO()):
        places = executed(Path(source).parent, lambda: command(TRUNK))
    print(json.dumps({str(path): sorted(functions) for path, functions in places.items()}))


def trunk_table(root: Path, with_files: bool) -> Iterator[str]:
    """Yield the lines of a table of the trunk: package, kernels and both."""
    kernels = root / "nlds_vines" / "kernels"
    totals: dict[str, Counter[str]] = defaultdict(Counter)
    by_file: list[tuple[int, int, Path]] = []
    for path, places in run_trunk(root).items():
        functions, tokens = function_counts(path, places)
        by_file.append((tokens, functions, path))
        area = "kernels" if kernels in path.parents else "package without kernels"
        for name in (area, "all"):
            totals[name].update(files=1, functions=functions, tokens=tokens)
    yield f"{'the trunk':26}" + "".join(f"{name:>16}" for name in ("files", "functions", "tokens"))
    for name in ("package without kernels", "kernels", "all"):
        of = totals[name]
        yield f"{name:26}{of['files']:16,}{of['functions']:16,}{of['tokens']:16,}"
    if with_files:
        for tokens, functions, path in sorted(by_file, reverse=True):
            yield f"    {path.relative_to(root)!s:54}{functions:4}{tokens:16,}"


# ---- the report ----------------------------------------------------------------------------------


def report(root: Path, beside: list[Path], with_names: bool, with_files: bool) -> Iterator[str]:
    package = root / "nlds_vines"
    others = {folder.name: sources_of(folder) for folder in beside}
    yield from size_table({**areas(root), **others})
    yield ""
    yield from size_table(parts(package))
    yield ""
    places = asking_words(package)
    words = sum(places.values(), Counter[str]())
    yield f"words that ask what a system is: {words.total()} places in {len(places)} files"
    yield "    " + ", ".join(f"{word} {words[word]}" for word in ASKING)
    classes = names_defined_twice(package, ast.ClassDef)
    functions = names_defined_twice(package, ast.FunctionDef)
    yield f"names in several modules: {len(classes)} of classes, {len(functions)} of functions"
    if with_names:
        yield from textwrap.wrap(", ".join(classes), 96, initial_indent="    ")
        yield from textwrap.wrap(", ".join(functions), 96, initial_indent="    ")
    yield ""
    yield from trunk_table(root, with_files)


def main() -> None:
    parser = argparse.ArgumentParser(description="Sizes, folded code, double names, the trunk.")
    parser.add_argument("checkout", nargs="?", type=Path, default=HERE)
    parser.add_argument(
        "--beside", action="append", type=Path, default=[], metavar="FOLDER", help="a library"
    )
    parser.add_argument("--names", action="store_true", help="the names in several modules")
    parser.add_argument("--files", action="store_true", help="the files of the trunk")
    parser.add_argument("--execute", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.execute:
        return execute()
    root = options.checkout.resolve()
    for line in report(root, options.beside, options.names, options.files):
        print(line, flush=True)
    return None


if __name__ == "__main__":
    main()
