"""Surveys are kept task by task, resumed, and leave nothing where they cannot begin."""

from dataclasses import dataclass, replace
from typing import Annotated

import pytest

from nlds_vines.archives import archive
from nlds_vines.archives.record_columns import Column, columns, record_of, row_of
from nlds_vines.errors import RequestError
from nlds_vines.runs import survey
from nlds_vines.runs.interrupts import INTERRUPTED, Interrupted, Stopped
from nlds_vines.runs.survey import Survey, Task


@dataclass(frozen=True)
class Found:
    """A record with a name of its own in the table, an enumeration and a default."""

    name: Annotated[str, Column("1", "what")]
    x: Annotated[float, Column("m", "how much")]
    status: Annotated[bool, Column("1", "done?", flags={"ok": 0, "failed": 1})] = False
    count: Annotated[int, Column("1", "how often", "times")] = 3
    aside: tuple[int, ...] = ()


def test_a_record_describes_its_columns():
    found = {column.name: column for column in columns(Found, without=("x",))}
    assert list(found) == ["name", "status", "times"]
    assert [column.dtype for column in found.values()] == ["str", "int8", "int32"]
    assert found["status"].flag_meanings == "ok failed"
    assert (found["times"].units, found["times"].long_name) == ("1", "how often")


def test_a_record_is_read_back_from_its_row():
    record = Found("a", 0.1, True, 2, aside=(1, 2))
    assert dict(row_of(record)) == {"name": "a", "x": 0.1, "status": True, "times": 2}
    assert record_of(Found, row_of(record), aside=(1, 2)) == record
    assert record_of(Found, {"name": "a", "x": 1, "status": 0}) == Found("a", 1.0)


def made_up_survey(calls, fail_at=None):
    def rows(index):
        def of():
            calls.append(index)
            if index == fail_at:
                raise Stopped
            return [row_of(Found(f"task {index}", index / 3))] * (index + 1)

        return of

    tasks = tuple(Task(f"{index}", rows(index)) for index in range(4))
    return Survey("Made up", "made up", {"a": 1.0}, columns(Found), tasks)


def table(path):
    with archive.read(path) as view:
        return {name: view[name].tolist() for name in view.names}


def test_a_survey_is_resumed_where_it_ended(tmp_path):
    whole, cut = tmp_path / "whole.h5", tmp_path / "cut.h5"
    survey.run(made_up_survey([]), whole)
    with pytest.raises(Interrupted) as stop:
        survey.run(made_up_survey([], fail_at=2), cut)
    assert stop.value.status == INTERRUPTED
    assert not cut.exists()
    calls = []
    survey.run(made_up_survey(calls), cut, resume=True)
    assert calls == [2, 3]
    assert table(cut) == table(whole)
    assert len(table(cut)["x"]) == 10


def test_a_damaged_part_is_measured_again(tmp_path):
    path = tmp_path / "a.h5"
    with pytest.raises(Interrupted):
        survey.run(made_up_survey([], fail_at=3), path)
    part = sorted((tmp_path / "a.h5.parts").glob("*.part"))[1]
    data = bytearray(part.read_bytes())
    data[-60] ^= 1
    part.write_bytes(data)
    calls = []
    survey.run(made_up_survey(calls), path, resume=True)
    assert calls == [1, 3]


def test_what_cannot_begin_leaves_nothing(tmp_path):
    def refused():
        raise RequestError("there is no reference")

    begun = made_up_survey([])
    for count in (0, 2):
        path = tmp_path / f"{count}.h5"
        tasks = (*begun.tasks[:count], Task("refused", refused))
        with pytest.raises(RequestError, match="no reference"):
            survey.run(replace(begun, tasks=tasks), path)
        assert path.with_name(f"{count}.h5.parts").exists() is (count > 0)


def test_an_archive_is_not_touched_unasked(tmp_path):
    path = tmp_path / "a.h5"
    survey.run(made_up_survey([]), path)
    with pytest.raises(RequestError, match="exists"):
        survey.run(made_up_survey([]), path)
    calls = []
    survey.run(made_up_survey(calls), path, resume=True)  # complete: nothing to do
    assert calls == []
