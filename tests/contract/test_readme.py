"""The README and the pages of `docs` do what they say: blocks run, commands and links exist."""

import contextlib
import io
import re
import shlex
import subprocess
import sys
from importlib import import_module
from importlib.util import find_spec
from itertools import pairwise
from pathlib import Path

import pytest

import nlds_vines
from nlds_vines.__main__ import COMMANDS
from nlds_vines.__main__ import main as console
from nlds_vines.bifurcation.command import main
from nlds_vines.bifurcation.request import Scan
from nlds_vines.bifurcation.request_file import load_scan
from nlds_vines.model.axis import Axis
from nlds_vines.model.catalogue import catalogue
from nlds_vines.model.parameters import PARAMETERS
from nlds_vines.model.scenes import SCENES
from nlds_vines.orbits.starts import POLICIES
from nlds_vines.orbits.status_words import STATUS
from nlds_vines.orbits.wants import WANTS, possible_want

ROOT = Path(__file__).resolve().parents[2]
README = ROOT / "README.md"
DOCS = ROOT / "docs"
PAGES = (README, *sorted(DOCS.glob("*.md")))
TEXT = "\n".join(page.read_text(encoding="utf-8") for page in PAGES)
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def text_of(name):
    """Return the text of a page of `docs`."""
    return (DOCS / name).read_text(encoding="utf-8")


def blocks(language, text=TEXT):
    """Return the code blocks of a language in a text, by default in all pages."""
    found = [body for name, body in BLOCK.findall(text) if name == language]
    assert found
    return found


def rows(text):
    """Return the rows of all tables in a text."""
    return set(re.findall(r"^\|.*\|$", text, re.MULTILINE))


@pytest.fixture
def own(tmp_path, monkeypatch):
    """Work in a folder that holds the scan file of the pages, and the request files of a clone."""
    (scan,) = blocks("toml")
    (tmp_path / "own.toml").write_text(scan)
    (tmp_path / "scans").symlink_to(ROOT / "scans")
    (tmp_path / "docs").mkdir()
    monkeypatch.chdir(tmp_path)
    return tmp_path / "own.toml"


def test_the_scan_file_means_what_its_comments_say(own):
    scan = load_scan(own)
    assert scan.system.K == 2.5e7
    assert (scan.shape, scan.transient, scan.periods) == ((41, 2), 300, 60)


def test_the_python_examples_print_what_is_shown(own):
    names = {}
    for program, shown in zip(blocks("python"), blocks("text"), strict=True):
        with contextlib.redirect_stdout(io.StringIO()) as printed:
            exec(compile(program, "python.md", "exec"), names)
        assert printed.getvalue() == shown


def commands(text=TEXT):
    """Return the words of every `python -m nlds_vines...` in a text, in code blocks or beside."""
    found = re.findall(r"python -m (nlds_vines\.[^`\n&]+)", text)
    return [shlex.split(line) for line in found]


def test_every_command_is_understood(own):
    found = commands()
    assert {words[0].removeprefix("nlds_vines.") for words in found} == {
        module.removeprefix("nlds_vines.").removesuffix(".command")
        for module, _ in COMMANDS.values()
        if "upkeep" not in module and "report" not in module  # they need an archive
    }
    for module, *arguments in found:
        assert import_module(f"{module}.command").main([*arguments, "--dry-run"]) == 0, arguments


def test_every_benchmark_exists():
    named = set(re.findall(r"python -m (benchmarks\.\w+)", TEXT))
    named |= set(re.findall(r"python -m (benchmarks\.[a-z]\w+)", text_of("../CONTRIBUTING.md")))
    assert len(named) >= 5
    for name in named:
        place = ROOT / name.replace(".", "/")
        assert place.with_suffix(".py").is_file() or (place / "__main__.py").is_file(), name


def test_the_scan_file_is_computed_and_drawn(own):
    found = commands(text_of("own-damper.md"))
    (line,) = [arguments for _, *arguments in found if "own.toml" in arguments]
    assert main([*line, "--quiet"]) == 0
    assert Path("own.h5").stat().st_size > 0
    assert Path("own.png").stat().st_size > 0


def sister_commands(text):
    """Return the words of every line in a text that begins with the console script."""
    lines = re.findall(r"^nlds-vines (.*)$", text, re.MULTILINE)
    return [shlex.split(line) for line in lines]


@pytest.mark.skipif(find_spec("distributed") is None, reason="distributed is not installed")
def test_the_long_scan_goes_on_as_it_is_told(own):
    (block,) = [body for body in blocks("sh", text_of("long-scans.md")) if "own.toml" in body]
    found = sister_commands(block)
    assert [console(words) for words in found] == [0, 0, 2, 0]  # shards are missing, then done
    assert Path("big.h5").stat().st_size > 0


def test_the_recipes_for_clusters_are_understood(own):
    text = text_of("long-scans.md")
    own.rename("map.toml")
    tried = re.findall(r"^<!-- tried: (\w+) -->\n```sh\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    assert len(tried) == 2
    for name, block in tried:
        found = [words for words in sister_commands(block) if words[0] == name]
        assert found
        for words in found:
            assert console([*words, "--dry-run"]) == 0


def test_an_archive_is_verified_repeated_and_compared(own):
    small = ["--vary", "omega=6:6.5:5", "--transient", "50", "--periods", "20", "--quiet"]
    assert main(small) == 0
    found = sister_commands("".join(blocks("sh", text_of("archive.md"))))
    assert [words[0] for words in found] == ["plot", "plot", "verify", "rerun", "diff"]
    assert [console(words) for words in found] == [0] * 5


@pytest.mark.skipif(find_spec("bokeh") is None, reason="Bokeh is not installed")
def test_pages_are_made_as_they_are_told(own):
    small = ["--vary", "omega=6:6.5:5", "--transient", "50", "--periods", "20", "--quiet"]
    assert main([*small, "-o", "map.h5"]) == 0
    found = sister_commands("".join(blocks("sh", text_of("explore.md"))))
    one, *others = [words for words in found if words[0] == "report"]
    assert console([word for word in one if word != "#"]) == 0
    assert Path("map.html").stat().st_size > 0
    assert len(others) == 2
    explored = [words[: words.index("#")] for words in found if words[0] == "explore"]
    assert len(explored) == 4
    for words in explored:
        assert console([*words, "--dry-run"]) == 0


def test_the_console_script_has_the_commands_that_are_told():
    named = set(re.findall(r"nlds-vines ([a-z][\w-]*)", TEXT))
    assert named <= set(COMMANDS)
    assert "consolidate" in named


FOLDERS = [module.removesuffix(".command") for module, _ in COMMANDS.values()]


@pytest.mark.parametrize(
    "program",
    [
        *(["nlds_vines", name] for name in COMMANDS),
        *([folder] for folder in FOLDERS if "upkeep" not in folder),
    ],
    ids=" ".join,
)
def test_every_command_has_help(program):
    done = subprocess.run(
        [sys.executable, "-m", *program, "--help"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0
    assert "example" in done.stdout


@pytest.mark.parametrize(
    ("command", "page"),
    [
        ("bifurcation", "own-damper.md"),
        ("portrait", "portrait.md"),
        ("tuning", "tuning.md"),
        ("continuation", "branches.md"),
        ("response_curves", "own-damper.md"),
    ],
)
def test_every_option_is_told(command, page, capsys):
    with contextlib.suppress(SystemExit):
        import_module(f"nlds_vines.{command}.command").main(["--help"])
    options = set(re.findall(r"(--[a-z-]+)", capsys.readouterr().out.split("examples:")[0]))
    always = {"--help", "--output", "--plot", "--threads", "--dry-run", "--quiet"}
    always |= {"--resume", "--overwrite"}  # in the README and with the scan file
    for option in options - always:
        assert option in text_of(page), option


def test_all_kinds_and_names_are_told():
    for kind in SCENES:
        assert f"`{kind}`" in TEXT
    for name in catalogue():
        stem = re.sub(r"\d$", "", name)
        assert f"`{name}`" in TEXT or f"`{stem}1` to `{stem}6`" in TEXT


def test_all_parameters_policies_and_records_are_told():
    text = text_of("own-damper.md")
    for name in (*PARAMETERS, *WANTS):
        assert re.search(rf"\b{name}\b", text), name
    for name in POLICIES:
        assert f"`{name}`" in text


def test_every_dataset_and_status_is_told():
    text = text_of("archive.md")
    for kind, scene in SCENES.items():
        system = next(s for s in systems() if s.kind == kind)
        want = possible_want(WANTS, scene, "rk4")
        axes = (Axis.spaced("omega", 5.0, 6.0, 2),)
        scan = Scan("all", system, axes, want, method="rk4")
        for name in (*scan.table.datasets, *(scale.name for scale in scan.scales())):
            assert name == "omega" or f"`{name}`" in text, name
    for status in STATUS.values():
        assert f"`{status.name}`" in text


def systems():
    """Yield a system of each kind."""
    yield from catalogue().values()
    ssbl = catalogue()["ssbl"]
    yield type(ssbl)("ssvi-b", ssbl.parameters)
    yield type(ssbl)("ssvi-c", {**ssbl.parameters, "L": 0.1})
    stops = {**catalogue()["hard-oscillator"].parameters, "C_2": 1.0}
    yield type(ssbl)("oscillator-2", stops, law="restitution")


def test_all_of_python_is_told():
    text = text_of("python.md")
    for name in nlds_vines.__all__:
        assert name == "__version__" or re.search(rf"`(nv\.)?{name}\b", text), name


def test_the_gate_runs_the_two_commands():
    readme = README.read_text(encoding="utf-8")
    gate = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    for name in ("main job", "tests"):
        marker = f"<!-- gate: {name} -->\n```sh\n"
        command, after = readme.split(marker)[1].split("\n", 1)
        assert after.startswith("```")
        assert command.startswith("python3 -m venv ")
        assert f'run_command "{name}"' in gate


def anchors(page):
    """Return the anchors of a page: its headings in lower case, with hyphens."""
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


def test_the_paths_in_contributing_exist():
    named = set(re.findall(r"`([\w./-]+/[\w./-]+)`", text_of("../CONTRIBUTING.md")))
    assert len(named) > 20
    for name in named:
        assert (ROOT / name).exists() or (ROOT / "nlds_vines" / name).exists(), name


def test_the_readme_leads_to_every_page():
    links = re.findall(r"\]\(docs/([^)#]+)", README.read_text(encoding="utf-8"))
    assert {page.name for page in DOCS.glob("*.md")} <= set(links)


def test_the_readme_measures_what_the_page_measures():
    measured = rows(README.read_text(encoding="utf-8")) & rows(text_of("accuracy-and-speed.md"))
    table = README.read_text(encoding="utf-8").split("## Accuracy and speed")[1]
    settings = [row for row in rows(table) if re.search(r"\d[.]\de-\d", row)]
    assert len(settings) >= 5
    assert set(settings) <= measured


def outputs(text):
    """Return the files that documented commands write, each with the commands that write it."""
    found = {}
    for line in re.findall(
        r"^(?:nlds-vines|python -m (?:nlds_vines|benchmarks)\.)(.*)$", text, re.M
    ):
        words = shlex.split(line.partition("&&")[0])
        plain = " ".join(w for w in words if w != "--resume" and not w.startswith("local:"))
        for option, name in pairwise(words):
            if option in ("-o", "--output", "--plot", "--markdown"):
                found.setdefault(name, set()).add(re.sub(r"--(shard|scheduler) \S*", "", plain))
    return found


def test_no_two_documented_commands_write_the_same_file():
    found = outputs(TEXT)
    assert len(found) > 15
    shared = {name: lines for name, lines in found.items() if len(lines) > 1}
    begun = {"big.h5", "reproduction"}  # a part first, then the rest of it
    assert set(shared) <= begun, shared


def test_a_file_that_two_commands_write_is_found():
    text = "nlds-vines tuning -o a.h5\npython -m nlds_vines.tuning --seed 1 -o a.h5\n"
    assert len(outputs(text)["a.h5"]) == 2
