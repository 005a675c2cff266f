"""Output that is closed or full, little memory, a signal at the very beginning: one line."""

import os
import signal
import subprocess
import sys

import pytest
from made_up import make_scan, write

from nlds_vines.cli.terminal import exit_status_of

PROGRAM = f"{sys.executable} -m nlds_vines"


def ask(line, folder):
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path), "PYTHONUNBUFFERED": ""}
    done = subprocess.run(
        ["bash", "-c", line.replace("nlds-vines", PROGRAM)],
        capture_output=True, text=True, cwd=folder, env=environment, check=False,
    )  # fmt: skip
    return done.returncode, done.stdout, done.stderr


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("streams")
    write(place / "a.h5", make_scan(("energy", "regime")))
    return place


@pytest.mark.parametrize("closed", [">&-", "2>&-", "<&- >&- 2>&-"])
def test_a_closed_stream_changes_nothing(folder, closed):
    sound = (folder / "a.h5").read_bytes()
    assert ask(f"nlds-vines plot a.h5 --show '?' {closed}", folder)[::2] == (0, "")
    assert ask(f"nlds-vines bifurcation --dry-run {closed}", folder)[::2] == (0, "")
    assert (folder / "a.h5").read_bytes() == sound
    assert ask(f"nlds-vines plot no.h5 {closed}", folder)[0] == 2


def test_no_file_gets_the_number_of_a_closed_stream(folder):
    program = (
        "from nlds_vines.cli.terminal import exit_status_of; exit_status_of('', lambda: 0);"
        "print(open('a.h5').fileno())"
    )
    line = f'{sys.executable} -W ignore -c "{program}"'
    assert int(ask(f"{line} <&- 2>&-", folder)[1]) > 2


@pytest.mark.parametrize("words", ["plot a.h5 --show '?'", "plot --help", "--help", "--version"])
def test_a_full_disk_for_output_is_one_line(folder, words):
    status, _, errors = ask(f"nlds-vines {words} > /dev/full", folder)
    assert status == 2
    assert errors.endswith("error: No space left on device\n")
    assert errors.count("\n") == 1


@pytest.mark.parametrize("kilobytes", [3_000_000, 1_500_000])
def test_little_memory_is_enough(folder, kilobytes):
    for words in ("bifurcation --dry-run", "plot no.h5 --help"):
        assert ask(f"ulimit -v {kilobytes}; nlds-vines {words}", folder)[::2] == (0, "")


@pytest.mark.parametrize("words", ["cannot open x.so: failed to map segment from shared object"])
def test_a_library_without_room_is_one_line(words, capsys):
    def work(text):
        raise ImportError(text)

    assert exit_status_of("", lambda: work(words)) == 2
    assert capsys.readouterr().err.count("\n") == 1
    with pytest.raises(ImportError, match="other"):
        exit_status_of("", lambda: work("another reason: other"))


SLOW_IMPORT = """
import builtins, sys, time
from nlds_vines import __main__ as program

plain = builtins.__import__

def slow(name, *rest):
    if name == "numpy" and builtins.__import__ is slow:
        builtins.__import__ = plain
        print("here", flush=True)
        time.sleep(60.0)
    return plain(name, *rest)

builtins.__import__ = slow
sys.exit(program.main(["bifurcation", "--dry-run"]))
"""


@pytest.mark.parametrize(("number", "status"), [(signal.SIGTERM, 143), (signal.SIGINT, 130)])
def test_a_signal_while_modules_are_loaded_is_one_line(folder, number, status):
    with subprocess.Popen(
        [sys.executable, "-c", SLOW_IMPORT],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=folder,
    ) as running:  # fmt: skip
        assert running.stdout.readline() == "here\n"
        running.send_signal(number)
        errors = running.communicate()[1]
    assert (running.returncode, errors) == (status, "nlds-vines: interrupted\n")
