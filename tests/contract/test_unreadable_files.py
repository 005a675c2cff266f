"""Files that cannot be read, or not at once: the reason in words, and nothing is lost."""

import errno
import os

import pytest
from made_up import make_scan, write


@pytest.fixture
def path(here):
    return write(here / "scan.h5", make_scan())


def test_permission_denied_is_said_as_such(path, monkeypatch, refusal):
    really = os.open

    def refused(place, *arguments, **keywords):
        if str(place) == "scan.h5":
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(place))
        return really(place, *arguments, **keywords)

    monkeypatch.setattr(os, "open", refused)
    for words in (["export"], ["plot", "--show", "?"], ["rerun"]):
        err = refusal(*words, "scan.h5")
        assert err.count("\n") == 1
        assert "Permission denied" in err
        assert "damaged" not in err
