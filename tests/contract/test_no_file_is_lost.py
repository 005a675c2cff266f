"""No output replaces a file unasked, nothing else replaces an archive, no link is followed."""

from pathlib import Path

import pytest
from commands import contents
from made_up import make_scan, write

import nlds_vines as nv
from nlds_vines.archives import files
from paper import report
from paper.claims import measured
from paper.command import main as paper

NOTES = b"the notes of a year"


@pytest.fixture
def here(here):
    """The current folder, with an archive `a.h5`."""
    write(here / "a.h5", make_scan(want=("section", "energy")))
    return here


ARCHIVERS = ("bifurcation", "transients", "tuning", "continuation", "response-curves")
WRITERS = {  # what writes a file that is no archive: the command, and the file's name in its place
    "report": ["report", "a.h5", "-o", "{}.html"],
    "plot": ["plot", "a.h5", "-o", "{}.png"],
    "export": ["export", "a.h5", "-o", "{}.csv"],
    "portrait": ["portrait", "--plot", "{}.png"],
    "accuracy, its picture": ["accuracy", "--plot", "{}.png"],
    **{f"{task}, its picture": [task, "-o", "n.h5", "--plot", "{}.png"] for task in ARCHIVERS},
}


@pytest.fixture
def refused(here, refusal):
    """Return a function that returns the line with which words are refused; it changes nothing."""

    def line(*words):
        before = contents(here)
        error = refusal(*words)
        assert contents(here) == before
        return error

    return line


@pytest.mark.parametrize("writer", [*WRITERS, *ARCHIVERS])
def test_no_file_is_replaced_unasked_and_no_archive_or_file_that_is_read_only(
    here, refused, writer
):
    command = [word.format("own") for word in WRITERS.get(writer, [writer, "-o", "{}.h5"])]
    file = here / command[-1]
    file.write_bytes(NOTES)
    err = refused(*command)
    assert "exists: " in err
    assert "--overwrite replaces it" in err
    file.chmod(0o444)
    assert "it is read-only" in refused(*command, "--overwrite")
    if writer in WRITERS:
        file.unlink()
        file.write_bytes((here / "a.h5").read_bytes())
        for _ in ("the archive", "a link to it"):
            err = refused(*command, "--overwrite")
            assert "it is an archive, which nothing else replaces" in err
            file.rename("link.h5")
            file.symlink_to("link.h5")


def test_nothing_but_an_archive_takes_the_name_of_one(refused):
    for name in ("new.h5", "new.hdf5", "new.NC"):
        err = refused("report", "a.h5", "-o", name, "--overwrite")
        assert "such a name is for archives alone" in err


@pytest.mark.parametrize("command", ARCHIVERS)
def test_a_dry_run_refuses_what_the_run_would(here, refused, monkeypatch, command):
    assert "exists" in refused(command, "-o", "a.h5", "--dry-run")
    err = refused(command, "-o", "a.h5", "--dry-run", "--resume", "--plot", "n.png")
    assert "--resume cannot continue it" in err
    glob, block = Path.glob, [here / "0.npz"]
    with monkeypatch.context() as patch:
        patch.setattr(Path, "glob", lambda *a: iter(block) if a[1] == "*.npz" else glob(*a))
        err = refused(command, "-o", "begun.h5", "--dry-run")
    assert "holds an unfinished run: --resume goes on" in err


@pytest.mark.parametrize("name", ["figure3.png", "figure8.png", "figure10.png", "reproduction.md"])
def test_figures_and_their_report_replace_none_but_their_own(here, capsys, name):
    (here / name).write_bytes(NOTES)
    for options in ([], ["--dry-run"]):
        assert paper(["-o", ".", *options]) == 2
        assert f"{name}' exists" in capsys.readouterr().err
    report.write(here / "other.md", here, "png", measured.not_followed)
    (here / name).unlink()
    (here / "other.md").rename("reproduction.md")
    assert paper(["-o", ".", "--dry-run"]) == 0


def test_a_dry_run_of_the_page_refuses_a_port_that_is_taken(refused):
    from nlds_vines.upkeep.explore import listening

    with listening(0) as server:
        port = server.getsockname()[1]
        assert "cannot be used" in refused("explore", "a.h5", "--port", port, "--dry-run")


def test_python_replaces_no_file_unasked_either(here, error_of):
    view = nv.read("a.h5")
    (here / "own.csv").write_bytes(NOTES)
    (here / "b.csv").write_bytes((here / "a.h5").read_bytes())
    for name in ("a.h5", "own.csv"):
        assert "exists: overwrite=True replaces it" in error_of(view.to_csv, name)
    for name in ("a.h5", "b.csv"):
        line = error_of(view.to_csv, name, overwrite=True)
        assert "it is an archive, which nothing else replaces" in line
    assert (here / "own.csv").read_bytes() == NOTES
    view.to_csv("own.csv", overwrite=True)
    assert (here / "own.csv").read_text().startswith("omega,")


def test_no_temporary_file_has_a_name_that_can_be_foreseen(here, ask):
    (here / "notes").write_bytes(NOTES)
    temporary = [here / name for name in ("p.html.tmp", "r.md.tmp", "e.csv.tmp")]
    for file in temporary:
        file.symlink_to("notes")
    ask("report", "a.h5", "-o", "p.html", "--quiet")
    report.write(here / "r.md", here, "png", measured.not_followed)
    nv.read("a.h5").to_csv("e.csv")
    assert (here / "notes").read_bytes() == NOTES
    assert all(file.is_symlink() for file in temporary)


def test_what_is_written_meanwhile_is_seen_by_the_writer_itself(here):
    (here / "r.txt").write_bytes(NOTES)
    (here / "r.txt").chmod(0o444)
    for name, protected in (("a.h5", "archive"), ("r.txt", "read-only")):
        before = (here / name).read_bytes()
        with pytest.raises(nv.RequestError, match=protected), files.whole(here / name) as file:
            file.write_bytes(b"other")
        assert (here / name).read_bytes() == before
