"""Sizes of the repository: the counts of a source whose counts are plain to see."""

from benchmarks.house import STEPS, TARGETS, areas, progress, shape, source_counts

SOURCE = '''"""Return what nobody asks for."""

LIMIT = 1


def double(given):
    """Tell how much.

    Twice as much.
    """
    found = 2 * given
    return (
        found
    )


def undocumented(x):
    return x
'''


def test_the_counts_of_a_source(tmp_path):
    path = tmp_path / "source.py"
    path.write_text(SOURCE)
    counts = source_counts([path])
    assert counts == {
        "files": 1,
        "lines": 18,
        "statements": 8,  # two docstrings, one constant, two functions, three statements in them
        "functions": 2,
        "lines of bodies": 5,
        "docstrings": 2,
        "lines of docstrings": 4,
        "'Return what'": 1,
        "'Tell'": 1,
        "names to avoid": 2,  # a parameter and a variable
    }
    assert shape(counts) == (1000 * 2 / 18, 2.5, 18)


def test_what_is_counted_where(tmp_path):
    for name in ("nlds_vines/kernels/a", "nlds_vines/kernels_too", "tests/b", "benchmarks/c"):
        path = tmp_path / f"{name}.py"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("x = 1\n")
    for name in ("docs/page.md", "docs/keys.md", "README.md", "CHANGELOG.md", "CONTRIBUTING.md"):
        path = tmp_path / name
        path.parent.mkdir(exist_ok=True)
        path.write_text("two words\n" * 100)
    measured = progress(tmp_path, areas(tmp_path))
    assert measured == {
        "package, lines": 1,
        "kernels, lines": 1,
        "tests, lines": 1,
        "benchmarks, lines": 1,
        "pages": 1,  # what a command writes is no page of ours
        "words of pages": 400,
        "CHANGELOG [kB]": 1,
        "CONTRIBUTING [kB]": 1,
    }
    assert measured.keys() == TARGETS.keys()
    assert {len(steps) for steps in TARGETS.values()} == {len(STEPS)}
