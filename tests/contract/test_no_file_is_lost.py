"""No output replaces a file unasked, nothing else replaces an archive, no link is followed."""

from pathlib import Path

import pytest
from commands import contents
from made_up import make_scan, write

import nlds_vines as nv
from nlds_vines.__main__ import main as console
from nlds_vines.archives import files
from nlds_vines.errors import RequestError
from paper import report
from paper.claims import measured
from paper.command import main as paper

NOTES = b"the notes of a year"


@pytest.fixture(scope="module")
def archive(tmp_path_factory):
    path = tmp_path_factory.mktemp("archive") / "a.h5"
    write(path, make_scan(want=("section", "energy")))
    return path


@pytest.fixture
def here(archive, here):
    """An empty folder but for that archive, `a.h5`, and the current one."""
    (here / "a.h5").write_bytes(archive.read_bytes())
    return here


WRITERS = {  # what writes a file that is no archive: the command, and the file's name in its place
    "report": ["report", "a.h5", "-o", "{}.html"],
    "plot": ["plot", "a.h5", "-o", "{}.png"],
    "export": ["export", "a.h5", "-o", "{}.csv"],
    "portrait": ["portrait", "--plot", "{}.png"],
    "accuracy, its picture": ["accuracy", "--plot", "{}.png"],
    "bifurcation, its picture": ["bifurcation", "-o", "n.h5", "--plot", "{}.png"],
    "transients, its picture": ["transients", "-o", "n.h5", "--plot", "{}.png"],
    "tuning, its picture": ["tuning", "-o", "n.h5", "--plot", "{}.png"],
    "continuation, its picture": ["continuation", "-o", "n.h5", "--plot", "{}.png"],
    "curves, their picture": ["response-curves", "-o", "n.h5", "--plot", "{}.png"],
}
ARCHIVERS = ("bifurcation", "transients", "tuning", "continuation", "response-curves")


def refused(here, capsys, arguments):
    """The line of an error with which a command refuses; it changes nothing."""
    before = contents(here)
    assert console(arguments) == 2, arguments
    assert contents(here) == before
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    return err


@pytest.mark.parametrize("writer", [*WRITERS, *ARCHIVERS])
def test_no_file_is_replaced_unasked_and_no_archive_or_file_that_is_read_only(here, capsys, writer):
    command = [word.format("own") for word in WRITERS.get(writer, [writer, "-o", "{}.h5"])]
    file = here / command[-1]
    file.write_bytes(NOTES)
    err = refused(here, capsys, command)
    assert "exists: " in err
    assert "--overwrite replaces it" in err
    file.chmod(0o444)
    assert "it is read-only" in refused(here, capsys, [*command, "--overwrite"])
    if writer in WRITERS:
        file.unlink()
        file.write_bytes((here / "a.h5").read_bytes())
        err = refused(here, capsys, [*command, "--overwrite"])
        assert "it is an archive, which nothing else replaces" in err
        file.rename("link.h5")
        file.symlink_to("link.h5")
        assert "it is an archive" in refused(here, capsys, [*command, "--overwrite"])


def test_nothing_but_an_archive_takes_the_name_of_one(here, capsys):
    for name in ("new.h5", "new.hdf5", "new.NC"):
        err = refused(here, capsys, ["report", "a.h5", "-o", name, "--overwrite"])
        assert "such a name is for archives alone" in err


@pytest.mark.parametrize("command", ARCHIVERS)
def test_a_dry_run_refuses_what_the_run_would(here, capsys, monkeypatch, command):
    assert "exists" in refused(here, capsys, [command, "-o", "a.h5", "--dry-run"])
    resumed = [command, "-o", "a.h5", "--dry-run", "--resume", "--plot", "n.png"]
    assert "--resume cannot continue it" in refused(here, capsys, resumed)
    glob, begun = Path.glob, [command, "-o", "begun.h5", "--dry-run"]
    with monkeypatch.context() as patch:
        block = [here / "0.npz"]
        patch.setattr(Path, "glob", lambda *a: iter(block) if a[1] == "*.npz" else glob(*a))
        assert "holds an unfinished run: --resume goes on" in refused(here, capsys, begun)


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


def test_a_dry_run_of_the_page_refuses_a_port_that_is_taken(here, capsys):
    from nlds_vines.explore.command import listening

    with listening(0) as server:
        port = str(server.getsockname()[1])
        err = refused(here, capsys, ["explore", "a.h5", "--port", port, "--dry-run"])
    assert "cannot be used" in err


def test_python_replaces_no_file_unasked_either(here):
    view = nv.read("a.h5")
    with pytest.raises(RequestError, match="exists: overwrite=True replaces it"):
        view.to_csv("a.h5")
    (here / "own.csv").write_bytes(NOTES)
    with pytest.raises(RequestError, match="exists: overwrite=True replaces it"):
        view.to_csv("own.csv")
    (here / "b.csv").write_bytes((here / "a.h5").read_bytes())
    for name in ("a.h5", "b.csv"):
        with pytest.raises(RequestError, match="it is an archive, which nothing else replaces"):
            view.to_csv(name, overwrite=True)
    assert (here / "own.csv").read_bytes() == NOTES
    view.to_csv("own.csv", overwrite=True)
    assert (here / "own.csv").read_text().startswith("omega,")


def test_no_temporary_file_has_a_name_that_can_be_foreseen(here, capsys):
    (here / "notes").write_bytes(NOTES)
    for name in ("p.html.tmp", "r.md.tmp", "e.csv.tmp"):
        (here / name).symlink_to("notes")
    assert console(["report", "a.h5", "-o", "p.html", "--quiet"]) == 0
    report.write(here / "r.md", here, "png", measured.not_followed)
    nv.read("a.h5").to_csv("e.csv")
    assert (here / "notes").read_bytes() == NOTES
    assert all((here / name).is_symlink() for name in ("p.html.tmp", "r.md.tmp", "e.csv.tmp"))


def test_what_is_written_meanwhile_is_seen_by_the_writer_itself(here):
    for name, protected in (("a.h5", "archive"), ("r.txt", "read-only")):
        if not (here / name).exists():
            (here / name).write_bytes(NOTES)
            (here / name).chmod(0o444)
        before = (here / name).read_bytes()
        with pytest.raises(RequestError, match=protected), files.whole(here / name) as file:
            file.write_bytes(b"other")
        assert (here / name).read_bytes() == before
