"""Counts of the package: entries, floors, circles, long functions, comments, lines by folder.

    python -m benchmarks.house [CHECKOUT]

The sources are parsed, not run. All imports count, those inside functions and under TYPE_CHECKING
too. Floors: modules in the longest chain of imports, a circle being one. Wings: the top-level
folders and files, without the package's `__init__`.
"""

from __future__ import annotations

import ast
import sys
import tokenize
from collections import Counter
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path

MOST_PARAMETERS = 8  # of a function, self and cls among them
LONG = 50  # lines of a function from `def` to its end
ARC_TABLES = ("hertz_arc", "impact_series", "quadrature")  # kernels' constants, wherever they stand

Graph = Mapping[str, set[str]]
"""What each module imports; both by their dotted names within the package."""


def modules(package: Path) -> dict[str, Path]:
    """Return the sources of a package by dotted name; the package's own `__init__` is ''."""
    paths = sorted(package.rglob("*.py"))
    dotted = (".".join(path.relative_to(package).with_suffix("").parts) for path in paths)
    return {n.removesuffix("__init__").rstrip("."): p for n, p in zip(dotted, paths, strict=True)}


@cache
def parsed(path: Path) -> ast.Module:
    """Return the syntax tree of a source."""
    return ast.parse(path.read_text(encoding="utf-8"))


def imports(path: Path, package: Path) -> set[str]:
    """Return the full dotted names of all that a source of a package imports, wherever in it."""
    home = (package.name, *path.relative_to(package).parts[:-1])
    found = set()
    for node in ast.walk(parsed(path)):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            base = home[: len(home) - node.level + 1] if node.level else ()
            source = ".".join([*base, *filter(None, [node.module])])
            found |= {f"{source}.{alias.name}" for alias in node.names}
    return found


def graph(package: Path) -> dict[str, set[str]]:
    """Return which modules of a package each of them imports."""
    known, found = modules(package), {}
    for name, path in known.items():
        own = [n.split(".")[1:] for n in imports(path, package) if n.split(".")[0] == package.name]
        starts = ([".".join(parts[:n]) for n in range(len(parts), -1, -1)] for parts in own)
        found[name] = {next(start for start in tried if start in known) for tried in starts}
        found[name] -= {name}
    return found


def wings(files: Graph) -> dict[str, set[str]]:
    """Return which top-level folders and files import which."""
    found: dict[str, set[str]] = {}
    for name, targets in files.items():
        own = name.split(".")[0]
        found.setdefault(own, set()).update({t.split(".")[0] for t in targets} - {own, ""})
    del found[""]
    return found


def circles(arrows: Graph) -> list[list[str]]:
    """Return the circles of a graph, each as the sorted names that reach one another."""
    reach = {name: set(targets) for name, targets in arrows.items()}
    for between in arrows:  # Warshall's closure
        for name in arrows:
            if between in reach[name]:
                reach[name] |= reach[between]
    mutual = {tuple(sorted(n for n in reach[name] if name in reach[n])) for name in arrows}
    return sorted(list(names) for names in mutual if names)


def depth(arrows: Graph) -> int:
    """Return the number of floors of a graph."""
    circle_of = {name: circle[0] for circle in circles(arrows) for name in circle}
    below: dict[str, set[str]] = {}
    for name, targets in arrows.items():
        own = circle_of.get(name, name)
        below.setdefault(own, set()).update({circle_of.get(t, t) for t in targets} - {own})

    @cache
    def height(name: str) -> int:
        return 1 + max(map(height, below[name]), default=0)

    return max(map(height, below))


def functions(package: Path) -> Iterator[tuple[str, ast.FunctionDef]]:
    """Yield every function and method of a package, nested ones too, with its module's name."""
    for name, path in modules(package).items():
        for node in ast.walk(parsed(path)):
            if isinstance(node, ast.FunctionDef):
                yield f"{name}.{node.name}", node


def parameters(function: ast.FunctionDef) -> int:
    """Return how many parameters a function takes, self and cls among them."""
    return sum(isinstance(node, ast.arg) for node in ast.walk(function.args))


def comments(path: Path) -> int:
    """Return how many comments of a source stand on a line of their own."""
    with path.open("rb") as file:
        found = [t.line for t in tokenize.tokenize(file.readline) if t.type == tokenize.COMMENT]
    return sum(line.lstrip().startswith("#") for line in found)


def assigned(path: Path) -> Iterator[tuple[str, str]]:
    """Yield the constants of a source, and the text of what each of them is."""
    for node in parsed(path).body:
        if isinstance(node, ast.Assign):
            for target in node.targets:
                named = [n.id for n in ast.walk(target) if isinstance(n, ast.Name)]
                yield from ((name, ast.unparse(node)) for name in named if name.isupper())


def _word(decorator: ast.expr) -> str:
    """Return a decorator without its arguments."""
    return ast.unparse(decorator).split("(")[0]


def named_twice(found: Counter[str]) -> str:
    """Return how many names count more than once, and which."""
    twice = sorted(name for name, count in found.items() if count > 1)
    return f"{len(twice)}: {', '.join(twice)}"


def kernel_counts(package: Path) -> Iterator[tuple[str, object]]:
    """Yield what is counted of the kernels alone, with the arc tables that they are given.

    Names that several modules give to functions or constants are alike by design where they are
    what a law says of its walls, and elsewhere something to look at.
    """
    known = modules(package)
    own = {name for name in known if name.split(".")[0] == "kernels"}
    tables = {name for name in known if name.split(".")[-1] in ARC_TABLES}
    laws = {name for name in own if ".laws." in f"{name}."}
    yield "own-line comments, kernels", sum(comments(known[name]) for name in own)
    length = {name: len(known[name].read_text("utf-8").splitlines()) for name in own | tables}
    yield "lines, kernels and arc tables", sum(length.values())
    yield "folders of kernels", len({known[name].parent for name in own})
    plain = [name for name in own | tables if known[name].stem != "__init__"]
    yield "files of kernels", len(plain)
    yield "files of kernels below 80 lines", sum(length[name] < 80 for name in plain)
    yield "files of kernels over 400 lines", sum(length[name] > 400 for name in plain)
    defined = [
        (name, node)
        for name in own | tables
        for node in parsed(known[name]).body
        if isinstance(node, ast.FunctionDef)
    ]
    by_law = [node for _, node in defined if "by_wall" in map(_word, node.decorator_list)]
    shared = Counter(node.name for name, node in defined if name not in laws)
    yield "functions of kernels", len(defined)
    yield "functions of kernels, by law", len(by_law)
    yield "functions of kernels, one name", named_twice(shared)
    values: dict[str, set[str]] = {}
    for name in own:
        for constant, text in assigned(known[name]):
            values.setdefault(constant, set()).add(f"{name}: {text}")
    shared = Counter({name: len(found) for name, found in values.items()})
    yield "constants of kernels, one name", named_twice(shared)
    yield "constants of one letter", ", ".join(sorted(n for n in values if len(n) == 1)) or 0


def counts(package: Path) -> Iterator[tuple[str, object]]:
    """Yield what is counted of a package, and the count."""
    known, files, every = modules(package), graph(package), list(functions(package))
    yield "entries", len([path for path in package.iterdir() if path.name != "__pycache__"])
    for what, arrows in (("wings", wings(files)), ("files", files)):
        yield f"floors of {what}", depth(arrows)
        yield f"circles of {what}", "; ".join(map(", ".join, circles(arrows))) or 0
    lengths = {name: (node.end_lineno or 0) - node.lineno + 1 for name, node in every}
    longest = max(lengths, key=lambda name: lengths[name])
    yield "longest function", f"{lengths[longest]} lines, {longest}"
    yield f"functions over {LONG} lines", sum(length > LONG for length in lengths.values())
    crowded = [name for name, node in every if parameters(node) > MOST_PARAMETERS]
    outside = [name for name in crowded if not name.startswith("kernels.")]
    yield f"over {MOST_PARAMETERS} parameters, kernels", len(crowded) - len(outside)
    yield f"over {MOST_PARAMETERS} parameters, elsewhere", ", ".join(outside) or 0
    yield "own-line comments, all", sum(map(comments, known.values()))
    yield from kernel_counts(package)
    lines: Counter[str] = Counter()
    for name, path in known.items():
        lines[name.split(".")[0] or "__init__"] += len(path.read_text("utf-8").splitlines())
    yield "lines", lines.total()
    yield from ((f"lines, {wing}", count) for wing, count in lines.items())


if __name__ == "__main__":
    checkout = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parents[1]
    for what, count in counts((checkout / "nlds_vines").resolve()):
        print(f"{what:28} {count}")
