"""The verbs of Python: they compute in memory, and write a file only where `to` says so."""

import gc
import os
import pickle

import numpy as np
import pytest

import nlds_vines as nv
from nlds_vines.archives.archive import ArchivePath

SHORT = {"transient": 20, "periods": 12}
FEW = {"omega": {"start": 6.0, "stop": 6.2, "num": 3}}


def scan(**changes):
    return nv.scan(
        "ssul-set6", vary=FEW, sampling=SHORT, record=["section", "impacts", "energy", "regime"],
        quiet=True, **changes,
    )  # fmt: skip


def test_a_scan_in_memory_leaves_no_file(here):
    request = scan()
    assert os.listdir(here) == []
    assert request.request.axes[0].values.tolist() == [6.0, 6.1, 6.2]
    assert request.read()["E1max"].shape == (3, 1)
    assert not os.path.lexists(str(request.parent))  # nothing is written before a file is needed
    assert list(request.to_xarray()["label"].values.ravel()) == ["T,1"] * 3
    assert request.to_dataframe()["E1max"].gt(0).all()
    assert request.plot().axes
    place, folder = str(request), request.parent
    with request.read() as view:
        del request
        gc.collect()
        assert view["E1max"].shape == (3, 1)  # what is open stays open
    del view
    gc.collect()
    assert not os.path.exists(place)
    assert not folder.exists()


def test_a_file_has_what_memory_has(here):
    named, nameless = scan(to="scan.h5"), scan()
    assert named == ArchivePath("scan.h5")
    assert os.listdir(here) == ["scan.h5"]
    a, b = (one.to_xarray() for one in (named, nameless))
    assert a.equals(b)
    with pytest.raises(nv.RequestError, match=r"scan\.h5' exists"):
        scan(to="scan.h5")
    assert scan(to="scan.h5", resume=True) == named


def test_an_archive_in_memory_is_read_as_its_file(here):
    nameless = scan()
    with nameless.read() as memory, nv.read(os.fspath(nameless)) as file:
        assert sorted(memory.names) == sorted(file.names)
        for name in (*memory.names, "omega", "component"):
            assert str(memory.describe(name)) == str(file.describe(name))  # nan is not nan
            assert memory.shape(name) == file.shape(name)
            np.testing.assert_array_equal(memory[name], file[name])
            assert memory[name].dtype == file[name].dtype
        assert {**memory.attrs, "hdf5_version": file.attrs["hdf5_version"]} == file.attrs
        assert (memory.content, memory.axes) == (file.content, file.axes)
        values = memory["E1max"]
        values[:] = 0.0  # a copy
        assert memory.take("E1max", omega=1)[0] > 0.0
        for call in (lambda view: view["x9"], lambda view: view.take("E1max", omega=9)):
            for view in (memory, file):
                with pytest.raises(nv.RequestError):
                    call(view)


@pytest.mark.parametrize("name", ["resume", "overwrite"])
def test_without_a_file_nothing_is_resumed(name):
    with pytest.raises(nv.RequestError, match="name it by to="):
        scan(**{name: True})


def test_a_start_may_be_a_word():
    assert scan(start="up").request.start.policy == "up"


@pytest.mark.slow("an ensemble of its own records")
@pytest.mark.kernels
def test_an_ensemble(here):
    ensemble = nv.transient_lifetimes("ssul-set6", starts=8, transient=200, periods=20, quiet=True)
    assert os.listdir(here) == []
    assert ensemble.labels.size == 8
    assert ensemble.request.starts == 8
    assert "label" in ensemble.to_xarray()
    assert ensemble.plot().axes
    assert nv.open_archive(
        nv.transient_lifetimes("tmd", starts=3, transient=9, quiet=True, to="e.h5").archive
    )


@pytest.mark.slow("kernels of the structure alone")
@pytest.mark.kernels
def test_curves(here):
    curves = nv.response_curves(["none", "ssul-set6"], vary=FEW, sampling=SHORT, quiet=True)
    assert os.listdir(here) == []
    assert curves["SSul NES, Set 6"].E1max.shape == (3,)
    assert curves.request.axis == "omega"
    assert curves.plot().axes
    again = nv.response_curves(
        ["none", "ssul-set6"], vary=FEW, sampling=SHORT, quiet=True, to="c.h5"
    )
    opened = nv.open_archive("c.h5")
    assert type(opened) is type(again)
    np.testing.assert_array_equal(opened.curves[1].E1max, curves.curves[1].E1max)
    assert curves.to_xarray().equals(opened.to_xarray())


@pytest.mark.slow("designs of a tuning")
@pytest.mark.kernels
def test_a_tuning(here):
    few = {"population": 5, "generations": 1, "seeds": 1, "polish": 0}
    free = {"k2": {"low": 100.0, "high": 3000.0}}
    tuned = nv.tune("ssul-set6", free=free, search=few, sampling=SHORT, quiet=True)
    assert os.listdir(here) == []
    assert tuned.request == tuned.tuning
    nv.tune("ssul-set6", free=free, search=few, sampling=SHORT, quiet=True, to="t.h5")
    assert nv.open_archive("t.h5").best.objective == tuned.best.objective
    assert "objective" in tuned.to_xarray()


@pytest.mark.slow("branches")
def test_branches(here):
    path = nv.continue_branch("ssul-set6", parameter="omega", bounds=(6.2, 6.4), quiet=True)
    assert os.listdir(here) == []
    assert path.branches[0].labels[0] == "T,1"
    assert path.request.along.name == "omega"
    assert path.plot().axes
    assert "label" in path.to_xarray()
    nv.continue_branch("ssul-set6", parameter="omega", bounds=(6.2, 6.4), quiet=True, to="b.h5")
    np.testing.assert_array_equal(
        nv.open_archive("b.h5").branches[0].states, path.branches[0].states
    )


def test_a_portrait_is_a_figure_and_a_file_where_it_is_asked_for(here):
    options = {"transient": 5, "periods": 3, "samples": 32, "panels": ["phase"]}
    assert nv.orbit_portrait("ssul-set6", quiet=True, **options).axes
    assert os.listdir(here) == []
    nv.orbit_portrait("ssul-set6", to="p.png", quiet=True, **options)
    assert os.listdir(here) == ["p.png"]


def test_results_and_requests_are_pickled(here):
    request = scan()
    copy = pickle.loads(pickle.dumps(request))
    assert copy != request
    assert copy.to_xarray().equals(request.to_xarray())
    assert pickle.loads(pickle.dumps(nv.scan)) is nv.scan
    assert pickle.loads(pickle.dumps(request.request)) == request.request
    named = scan(to="scan.h5")
    assert pickle.loads(pickle.dumps(named)) == named


def test_an_archive_is_opened_as_what_it_holds(here):
    scan(to="scan.h5")
    assert type(nv.open_archive("scan.h5")) is type(scan())
    with pytest.raises(nv.RequestError, match="no such file"):
        nv.open_archive("no.h5")
    with pytest.raises(nv.RequestError, match="path of a file"):
        nv.open_archive(3)
