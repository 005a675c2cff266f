"""The README and the pages of `docs` do what they say: blocks run, commands and links exist.

What the README and the tutorial tell a reader to do is done in the gate, by `.ci/walk.py`.
"""

import contextlib
import io
import json
import re
import shlex
import shutil
import sys
import tomllib
from importlib import import_module
from importlib.machinery import SourceFileLoader
from importlib.util import find_spec, module_from_spec, spec_from_loader
from itertools import pairwise
from pathlib import Path

import jsonschema
import matplotlib
import pytest
from commands import printed, python

import nlds_vines
from nlds_vines.__main__ import COMMANDS
from nlds_vines.__main__ import main as console
from nlds_vines.archives.files import toml_text
from nlds_vines.bifurcation.command import main
from nlds_vines.bifurcation.request import Scan, load_scan
from nlds_vines.engine.records import WANTS
from nlds_vines.engine.starts import POLICIES
from nlds_vines.model.axis import Axis
from nlds_vines.model.catalog import catalog, system_named, system_names
from nlds_vines.model.scenes import SCENES

ROOT = Path(__file__).resolve().parents[2]
README = ROOT / "README.md"
DOCS = ROOT / "docs"
PAGES = (README, *sorted(DOCS.glob("*.md")))
TEXT = "\n".join(page.read_text(encoding="utf-8") for page in PAGES)
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def loaded(path):
    """Return the module in a file of the repository that is no part of the package."""
    spec = spec_from_loader(path.stem, SourceFileLoader(path.stem, str(path)))
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


gate = loaded(ROOT / ".ci" / "gate.py")
walk = loaded(ROOT / ".ci" / "walk.py")
reference = loaded(DOCS / "site" / "reference.py")
kinds = loaded(DOCS / "site" / "kinds.py")
AT2 = """PEER NGA STRONG MOTION DATABASE RECORD
MADE UP, 1/1/2000, STATION, 90
ACCELERATION TIME SERIES IN UNITS OF G
NPTS=      4, DT=   .0200 SEC
   .1000E-01  -.3000E-01   .2000E-01   .0000E+00
"""
TUTORIAL = "docs/tutorial.md"  # which the gate walks, beside the README

RUN = (
    "archive.md", "python.md", "branches.md", "hosts.md", "springs.md", "finite-elements.md",
    "loads-in-time.md", "response-curves.md", "scans.md", "base-excitation.md",
)  # fmt: skip
"""Pages whose programs in Python are run here."""

COMPUTE = {name for name, (module, _) in COMMANDS.items() if "upkeep" not in module}
PATTERNS = {"long-scans.md", "tutorial.md"}  # pages whose commands have tests of their own
ARCHIVES = {
    "figure8.h5",
    "regimes.h5",
    "omega-force.h5",
    "reproduction",
}  # of earlier commands: they must be there
SMALL = ["--vary", "omega=6:6.5:5", "--transient", "50", "--periods", "20", "--quiet"]


def text_of(name):
    return (DOCS / name).read_text(encoding="utf-8")


def blocks(language, text=TEXT):
    bodies = [body for name, body in BLOCK.findall(text) if name == language]
    assert bodies
    return bodies


def rows(text):
    return set(re.findall(r"^\|.*\|$", text, re.MULTILINE))


@pytest.fixture
def scan_file(here):
    """Work in a folder that holds the scan file of the pages, and the request files of a clone."""
    for page in PAGES:
        for kind, name, text in walk.steps(page.read_text(encoding="utf-8")):
            if kind == "file":
                assert not (here / name).exists(), "two pages save different files so"
                (here / name).write_text(text)
    (here / "scans").symlink_to(ROOT / "scans")
    (here / "docs").mkdir()
    return here / "own.toml"


def test_the_scan_file_means_what_it_says(scan_file):
    scan = load_scan(scan_file)
    assert scan.system.K == 2.5e7
    assert (scan.shape, scan.transient, scan.periods) == ((41, 2), 300, 60)


@pytest.mark.kernels
@pytest.mark.parametrize("page", RUN)
def test_the_python_examples_print_what_is_shown(page, scan_file):
    names = {}
    if page == "archive.md":  # which begins with the archive of scans.md
        nlds_vines.scan("own.toml", to="own.h5", quiet=True)
    programs = [step for step in walk.steps(text_of(page)) if step[0] == "python"]
    assert programs
    with_python = {page.name for page in PAGES if "\n```python\n" in page.read_text("utf-8")}
    assert with_python == {*RUN, "tutorial.md", "long-scans.md"}  # which others run
    with matplotlib.rc_context({"backend": "Agg"}):
        for _, program, shown in programs:
            with contextlib.redirect_stdout(io.StringIO()) as printed:
                exec(compile(program, page, "exec"), names)
            assert printed.getvalue() == shown


@pytest.mark.kernels
def test_the_program_with_a_pool_of_processes_runs(scan_file):
    (program,) = blocks("python", text_of("long-scans.md"))
    Path("pool.py").write_text(program)
    done = python("pool.py", cwd=scan_file.parent)
    assert done.returncode == 0, done.stderr
    assert Path("pool.h5").stat().st_size > 0


def commands(text):
    """Return the words of every line of a text that is a command.

    `python -m nlds_vines.bifurcation` is the same as `nlds-vines bifurcation`.
    """
    lines = re.findall(r"^(?:nlds-vines |python -m nlds_vines\.)(.*)$", text, re.MULTILINE)
    return [[name.replace("_", "-"), *rest] for name, *rest in map(shlex.split, lines)]


@pytest.mark.kernels
def test_every_command_is_understood(scan_file):
    texts = [page.read_text(encoding="utf-8") for page in PAGES if page.name not in PATTERNS]
    listed = [words for text in texts for words in commands(text.replace("\n.venv/bin/", "\n"))]
    listed = [words for words in listed if words[0] in COMPUTE]
    assert {words[0] for words in listed} == COMPUTE
    for record in ("quake.csv", "elcentro_chopra.csv"):
        Path(record).write_text("time [s], acceleration [g]\n0.00, 0.01\n0.02, -0.03\n")
    Path("records").mkdir()
    for record in ("a.AT2", "b.AT2", "c.AT2", "records/a.AT2", "records/b.AT2"):
        Path(record).write_text(AT2)
    Path("table.csv").write_text("k1,C\n4e4,0.05\n")
    for words in listed:
        needs_an_archive = words[0] == "report" or ARCHIVES & set(words)
        if not needs_an_archive:
            assert console([*words, "--dry-run"]) == 0, words


@pytest.mark.kernels
@pytest.mark.skipif(find_spec("distributed") is None, reason="distributed is not installed")
def test_the_long_scan_goes_on_as_it_is_told(scan_file):
    (block,) = [body for body in blocks("sh", text_of("long-scans.md")) if "own.toml" in body]
    listed = commands(block)
    assert [console(words) for words in listed] == [0, 0]  # a shard, then what is missing
    assert Path("big.h5").stat().st_size > 0


def test_the_recipes_for_clusters_are_understood(scan_file):
    text = text_of("long-scans.md")
    scan_file.rename("map.toml")
    tried = re.findall(r"^<!-- tried: (\w+) -->\n```sh\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    assert len(tried) == 2
    for name, block in tried:
        listed = [words for words in commands(block) if words[0] == name]
        assert listed
        for words in listed:
            assert console([*words, "--dry-run"]) == 0


def test_an_archive_is_drawn_and_repeated(scan_file):
    assert main(SMALL) == 0
    shutil.copy("figure8.h5", "own.h5")
    listed = commands("".join(blocks("sh", text_of("archive.md"))))
    assert [words[0] for words in listed] == ["plot", "plot", "rerun", "export", "export"]
    assert [console(words) for words in listed] == [0] * 5


@pytest.mark.skipif(find_spec("bokeh") is None, reason="Bokeh is not installed")
def test_pages_are_made_as_they_are_told(scan_file, capsys):
    assert main(SMALL) == 0
    listed = commands("".join(blocks("sh", text_of("explore.md"))))
    one, *others = [words for words in listed if words[0] == "report"]
    assert console(one) == 0
    assert Path("figure8.html").stat().st_size > 0
    for words in others:  # all it lacks is the archive of branches
        assert console(words) == 2
        assert "'branches.h5'" in capsys.readouterr().err
    explored = [words for words in listed if words[0] == "explore"]
    assert len(explored) == 4
    for words in explored:
        assert console([*words, "--dry-run"]) == 0


def test_every_command_that_is_told_exists_and_has_help():
    named = set(re.findall(r"nlds-vines ([a-z][\w-]*)", TEXT))
    assert named <= set(COMMANDS)
    assert "rerun" in named
    programs = [["nlds_vines", name] for name in COMMANDS]
    for folder in (module.removesuffix(".command") for module, _ in COMMANDS.values()):
        if ROOT.joinpath(*folder.split("."), "__main__.py").exists():  # it runs by itself
            programs.append([folder])
    assert len(programs) > len(COMMANDS) + 5
    output = json.loads(printed("-c", HELP, json.dumps(programs)))
    assert output == {" ".join(words): True for words in programs}


HELP = """
import contextlib, io, json, runpy, sys
found = {}
for words in json.loads(sys.argv[1]):
    sys.argv = [*words, "--help"]
    with contextlib.redirect_stdout(io.StringIO()) as text, contextlib.suppress(SystemExit):
        runpy.run_module(words[0], run_name="__main__", alter_sys=True)
    found[" ".join(words)] = "example" in text.getvalue()
print(json.dumps(found))
"""


def test_all_names_policies_and_records_are_told():
    for name in system_names():
        stem = re.sub(r"\d$", "", name)
        assert f"`{name}`" in TEXT or f"`{stem}1` to `{stem}6`" in TEXT
    text = text_of("scans.md")
    for name in WANTS:
        assert re.search(rf"\b{name}\b", text), name
    for name in POLICIES:
        assert f"`{name}`" in text


def test_every_dimension_of_scans_is_told():
    scan = Scan("all", catalog()["ssbl"], (Axis.spaced("omega", 5.0, 6.0, 2),), WANTS)
    names = {scale.name for scale in scan.scales()} - {"omega"}
    assert {"wall", "multiplier", "line"} <= names
    assert all(f"`{name}`" in text_of("datasets.md") for name in names), names


def test_all_of_python_is_told_with_its_docstrings():
    text = text_of("python.md")
    for name in set(nlds_vines.__all__) - {"__version__"}:
        assert re.search(rf"`(nv\.)?{name}\b", text), name
        assert re.search(rf"^\.\. auto\w+:: nlds_vines[\w.]*\.{name}$", text, re.M), name


def test_the_gate_walks_the_readme_and_the_tutorial():
    """Every step of the README once, each in the section of its name; the tutorial as a whole."""
    assert TUTORIAL in gate.TUTORIAL
    steps = [*walk.steps(README.read_text(encoding="utf-8"))]
    taken = {
        section.name: [line for _, line, _ in steps[walk.chosen_steps(span)]]
        for section in gate.SECTIONS
        for span in re.findall(r"walk\.py README\.md:([\d-]+)", section.commands)
    }
    assert [line for lines in taken.values() for line in lines] == [line for _, line, _ in steps]
    assert taken["first commands of the README"][0].startswith("python3 -m venv .venv ")
    assert ".[test,docs]" in taken["environment of the tests"][0]
    assert taken["default tests"] == [".venv-test/bin/python -m pytest"]
    assert "-m sphinx -W" in taken["site"][0]


def test_a_section_of_the_gate_waits_for_others_of_its_part_that_stand_above_it():
    parts = {part: gate.sections_of(part) for part in ("", "kernels", "others")}
    for sections in parts.values():
        names = [section.name for section in sections]
        assert len(set(names)) == len(names)
        for place, section in enumerate(sections):
            assert {*section.after} <= {*names[:place]}, section.name
    kernels, others = ({one.name for one in parts[name]} for name in ("kernels", "others"))
    assert kernels | others == {one.name for one in parts[""]}
    assert kernels - others == {gate.KERNELS}
    with pytest.raises(SystemExit, match="allowed: kernels, others"):
        gate.sections_of("kernel")


def test_the_gate_begins_with_kernels_that_are_kept(tmp_path):
    one, other = tmp_path / "one", tmp_path / "other"
    one.mkdir()
    (one / "a.compiled").write_bytes(b"a")
    (one / "a.py").write_bytes(b"")
    gate.copy_kernels(tmp_path / "absent", other)
    gate.copy_kernels(one, other)
    assert [path.name for path in other.iterdir()] == ["a.compiled"]
    (one / "a.compiled").rename(one / "b.compiled")
    gate.copy_kernels(one, other)
    assert [path.name for path in other.iterdir()] == ["b.compiled"]


PASSES = """
echo '$ one'; echo '  (7 s)'; echo '5 passed in 1 s'
echo '{"test": "tests/a.py::test", "seconds": 12.1, "compiling": {"run_cell": 9.0}}'
""".strip()


def test_a_red_gate_names_the_tests_and_what_repeats_them(tmp_path, capsys):
    """Tests with and without the compiler; the last command of a walk, if it ran no tests."""
    (tmp_path / "log").mkdir()
    red = "echo 'FAILED tests/a.py::test[x y] - assert 1'; echo 'E   FAILED tests/plain_b.py::test'"
    for commands, expected in (
        (f"{red}; exit 1", ["'tests/a.py::test[x y]'", "NUMBA_DISABLE_JIT=1", "tests/plain_b.py"]),
        ("echo '$ make all'; echo wrong; exit 3", ["wrong", "repeat: make all"]),
        (f"{PASSES} >$TEST_COSTS", ["passed: a name", "7  $ one", "5 passed in", "12    tests/a"]),
    ):
        stopped = pytest.raises(SystemExit) if "exit" in commands else contextlib.nullcontext()
        with stopped:
            gate.run_all(tmp_path, tmp_path, [gate.Section("a name", commands)])
        printed = capsys.readouterr().out
        last = printed.partition("FAILED: a name")[2] if "exit" in commands else printed
        assert all(text in last for text in expected), printed


def test_a_walk_notices_what_goes_wrong(tmp_path):
    """A command that fails, a text that is not printed, a file that is written twice."""
    pages = {
        "```sh\ntrue\nfalse\n```\n": "status 1",
        "```sh\necho one\n```\n\n```console\ntwo\n```\n": "was not printed: 'two'",
        "```sh\ndate +%N >a\ndate +%N >a\n```\n": "changed a",
        "```python\nprint(1)\n```\n\n```text\n2\n```\n": "it should print",
        "```sh\nx=1\n```\n\n```sh\necho $x\n```\n\n```console\n1\n```\n": "",
    }
    for text, complaint in pages.items():
        (tmp_path / "page.md").write_text(text)
        done = python(ROOT / ".ci" / "walk.py", "page.md", cwd=tmp_path)
        assert done.returncode == bool(complaint), done.stdout + done.stderr
        assert complaint in done.stderr


@pytest.mark.parametrize("page", list(reference.pages()), ids=lambda page: page.name)
def test_the_tables_of_the_reference_are_the_programs_own(page):
    text = page.read_text(encoding="utf-8")
    assert reference.filled(text) == text, "run python docs/site/reference.py"
    assert reference.filled(text.replace("| `k1` |", "| `k7` |").replace("--quiet", "-q")) == text


def test_a_structure_that_is_shaken_has_more_datasets():
    rows_of = {line.split("|")[1].strip(): line for line in rows(text_of("datasets.md"))}
    shaken = nlds_vines.load_system("ssul-set6", base_displacement=0.01)
    scan = Scan("all", shaken, (Axis.spaced("omega", 5.0, 6.0, 2),), ("response",))
    usual = Scan("all", catalog()["ssul-set6"], scan.axes, ("response",))
    added = scan.table.datasets.keys() - usual.table.datasets.keys()
    assert {"P", "x1_abs_max", "x1_abs_rms", "transmissibility"} <= added
    for name in added | usual.table.datasets.keys():
        assert ("where the ground moves" in rows_of[f"`{name}`"]) == (name in added), name


def test_every_made_table_is_on_a_page_and_every_kind_is_drawn():
    texts = [page.read_text(encoding="utf-8") for page in reference.pages()]
    marks = {name for text in texts for _, name, _ in reference.MARKED.findall(text)}
    assert marks == set(reference.MADE)
    assert "SUPPRESS" not in text_of("commands.md")  # which help hides
    assert set(kinds.DRAWINGS) == set(SCENES)
    assert len(kinds.figure().axes) >= len(SCENES)


def key_rows():
    """Return the rows of keys.md: (table, key, kind of file); "" is the table of top-level keys."""
    place = first = ""
    lines = [line for line in text_of("keys.md").splitlines() if line.startswith("|")]
    for line in lines:
        table, keys, files = (cell.strip() for cell in line.split("|")[1:4])
        if set(table + keys) == {"-"} or table == "table":
            continue
        place = table.strip("`[]") or place
        first = keys or first
        for key in re.findall(r"`(\w+)`", first) or [first]:
            yield from ((place, key, file) for file in files.split(", "))


FORMS = {
    module.FORM.kind: module.FORM
    for module in (
        import_module(f"nlds_vines.{path.parent.name}.request")
        for path in sorted((ROOT / "nlds_vines").glob("*/request.py"))
    )
    if hasattr(module, "FORM")
}


@pytest.mark.parametrize("kind", FORMS)
def test_every_key_is_told(kind):
    assert {"scan", "tuning", "portrait", "continuation"} < set(FORMS)
    documented = {(table, key) for table, key, file in key_rows() if file in (kind, "all")}
    for table, keys in FORMS[kind].tables.items():
        assert any(place == table for place, _ in documented), table
        for key in keys or ():
            assert (table, key) in documented, (table, key)
        for place, key in documented:
            assert place != table or not keys or key in keys, f"{kind} has no {key} in {table}"
    for name in FORMS[kind].lists:
        assert any(place == name for place, _ in documented), name


def anchors(page):
    headings = re.findall(r"^#+ (.*)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", line).lower().replace(" ", "-") for line in headings}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_what_it_points_to_exists(page):
    links = re.findall(r"\]\(([^)]+)\)", page.read_text(encoding="utf-8"))
    for link in links:
        path, _, anchor = link.partition("#")
        place = page.parent / path if path else page
        assert place.is_file(), link
        assert not anchor or anchor in anchors(place), link


def test_the_paths_and_benchmarks_that_are_named_exist():
    named = set(re.findall(r"`([\w./-]+/[\w./-]+)`", text_of("../CONTRIBUTING.md")))
    assert len(named) > 20
    for name in named:
        assert (ROOT / name).exists() or (ROOT / "nlds_vines" / name).exists(), name
    named = set(re.findall(r"python -m (benchmarks\.\w+)", TEXT))
    named |= set(re.findall(r"python -m (benchmarks\.[a-z]\w+)", text_of("../CONTRIBUTING.md")))
    assert len(named) >= 5
    for name in named:
        place = ROOT / name.replace(".", "/")
        assert place.with_suffix(".py").is_file() or (place / "__main__.py").is_file(), name


def test_the_contents_lead_to_every_page_and_tables_of_the_readme_are_those_of_pages():
    text = text_of("index.md")
    for page in (*DOCS.glob("*.md"), *DOCS.glob("*.ipynb")):
        assert page.stem == "index" or re.search(rf"^{page.stem}$", text, re.MULTILINE), page.name
    links = re.findall(r"\]\(docs/([^)#]+)", README.read_text(encoding="utf-8"))
    assert {"index.md", "tutorial.md", "how-it-works.md"} <= set(links)
    measured = rows(README.read_text(encoding="utf-8")) & rows(text_of("accuracy.md"))
    table = README.read_text(encoding="utf-8").split("## Accuracy and speed")[1]
    settings = [row for row in rows(table) if re.search(r"\d[.]\de-\d", row)]
    assert len(settings) == 5
    assert set(settings) <= measured


def outputs(text):
    written = {}
    programs = r"^(?:nlds-vines|python -m (?:nlds_vines|benchmarks)\.)(.*)$"
    for line in re.findall(programs, text, re.MULTILINE):
        words = shlex.split(line.partition("&&")[0])
        plain = " ".join(w for w in words if w != "--resume" and not w.startswith("local:"))
        for option, name in pairwise(words):
            if option in ("-o", "--output", "--plot", "--markdown"):
                written.setdefault(name, set()).add(re.sub(r"--(shard|scheduler) \S*", "", plain))
    return written


def test_no_two_documented_commands_write_the_same_file():
    written = outputs(TEXT)
    assert len(written) > 15
    shared = {name: lines for name, lines in written.items() if len(lines) > 1}
    begun = {"big.h5", "reproduction"}  # a part first, then the rest of it
    assert set(shared) <= begun, shared
    # two that do are found
    text = "nlds-vines tuning -o a.h5\npython -m nlds_vines.tuning --seed 1 -o a.h5\n"
    assert len(outputs(text)["a.h5"]) == 2


# ---- the schema of request files -----------------------------------------------------------------

sys.path.append(str(DOCS / "site"))  # it reads the file beside it
schema = loaded(DOCS / "site" / "schema.py")


def test_the_schema_is_the_programs_own():
    remedy = "run python docs/site/schema.py"
    assert schema.PATH.read_text(encoding="utf-8") == schema.text(), remedy


@pytest.mark.parametrize("path", [*(ROOT / "scans").glob("*.toml")], ids=lambda path: path.name)
def test_request_files_are_as_the_schema_says(path):
    jsonschema.validate(tomllib.loads(path.read_text(encoding="utf-8")), schema.schema())


def test_every_system_is_as_the_schema_says():
    host = nlds_vines.chain([1.0, 2.0], [100.0, 200.0])
    wall = nlds_vines.Wall(0.05, law="restitution", e=0.7)
    damper = nlds_vines.Damper("cell", attached_to="x2", m=0.1, k=1.0, walls=[wall])
    of_host = nlds_vines.System.from_host(host, [damper], force={"x1": 1.0}, omega=6.0)
    for system in (*map(system_named, system_names()), of_host):
        document = tomllib.loads(toml_text({"system": system.to_table()}))
        jsonschema.validate(document, schema.schema())


def test_the_schema_refuses_mistakes():
    for wrong in (
        {"sampling": {"periods": 0}},
        {"sampling": {"period": 10}},
        {"vary": {"omgea": {"start": 1.0, "stop": 2.0, "num": 3}}},
        {"search": {"method": "newton"}},
        {"figure": {"reduction": 1}},
        {"system": {"kind": "ssul", "contact": {"lwa": "hertz"}}},
        {"system": {"kind": "host", "dampers": [{"name": "a", "walls": [{"gpa": 0.1}]}]}},
        {"system": {"kind": "host", "force": {"omgea": 6.0}}},
    ):
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate(wrong, schema.schema())


@pytest.mark.parametrize(
    ("system", "place"),
    [
        ({"kind": "ssul", "paramters": {"m1": 1.0}}, ["system"]),
        ({"kind": "ssul", "parameters": {"m_1": 1.0}}, ["system", "parameters"]),
        ({"kind": "host", "host": {"M": [[1.0]], "Kk": [[1.0]]}}, ["system", "host"]),
        ({"kind": "host", "dampers": [{"attached": "x1"}]}, ["system", "dampers", 0]),
    ],
)
def test_the_schema_points_at_the_wrong_key_of_a_system(system, place):
    """An alternative of several forms would be wrong as a whole, and be underlined as a whole."""
    validator = jsonschema.Draft7Validator(schema.schema())
    (error,) = validator.iter_errors({"system": system})
    assert list(error.absolute_path) == place
    assert error.validator == "additionalProperties"
    assert [*validator.iter_errors({"system": "ssul-set6"})] == []
    (error,) = validator.iter_errors({"system": 3})
    assert list(error.absolute_path) == ["system"]
