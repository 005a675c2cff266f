"""HDF5 files of others that lead to other files: refused in one line, before anything is opened."""

import os

import h5py
import numpy as np
import pytest

import nlds_vines as nv
from nlds_vines.model.loads.record import RecordFile
from scans import archived, scan_of, unfilled

SECRET = b"a text of the user's that nobody else may read" * 4


def external_link(group, name, path):
    group[name] = h5py.ExternalLink(path, "/status")


def soft_link(group, name, path):
    group[name] = h5py.SoftLink("/scan")


def link_through_a_link(group, name, path):
    group["step"] = h5py.ExternalLink(path, "/")
    group[name] = h5py.SoftLink("step/status")


def external_storage(group, name, path):
    group.create_dataset(name, (8,), "f8", external=[(path, 0, 64)])


def virtual_dataset(group, name, path):
    layout = h5py.VirtualLayout((8,), "f8")
    layout[:] = h5py.VirtualSource(path, "status", shape=(8,))
    group.create_virtual_dataset(name, layout)


def growing_virtual_dataset(group, name, path):
    source = h5py.VirtualSource(path, "status", shape=(8,), maxshape=(None,))
    layout = h5py.VirtualLayout((8,), "f8", maxshape=(None,))
    unlimited = h5py.h5s.UNLIMITED
    layout[0:unlimited] = source[0:unlimited]
    group.create_virtual_dataset(name, layout)


WAYS = (
    external_link, soft_link, link_through_a_link, external_storage, virtual_dataset,
    growing_virtual_dataset,
)  # fmt: skip


@pytest.fixture
def original(here):
    """Write an archive, a pipe and a secret; return the bytes of the archive."""
    scan = scan_of("tmd", ("section",))
    path = archived(here / "original.h5", scan, unfilled(scan))
    os.mkfifo("pipe.h5")
    (here / "secret.h5").write_bytes(SECRET)
    return path.read_bytes()


def test_of_100_archives_that_lead_elsewhere_none_is_opened(here, original, error_of, refusal):
    rng = np.random.default_rng(61)
    commands = ("plot", "export", "rerun", "report")
    with h5py.File("original.h5") as file:
        names = list(file)
    for number in range(100):
        path = here / f"archive{number}.h5"
        path.write_bytes(original)
        way = WAYS[number % len(WAYS)]
        target = ("pipe.h5", "secret.h5", "original.h5", "nowhere.h5")[rng.integers(4)]
        name = (*names, "further")[rng.integers(len(names) + 1)]
        with h5py.File(path, "a") as file:
            group = file
            if name in file and rng.integers(2):
                del file[name]  # in place of a dataset that the program reads
            else:
                for depth in range(rng.integers(4)):
                    group = group.create_group(f"group{depth}")
                    group["back"] = file["/"]
                name = "further"
            way(group, name, target)
        line = error_of(nv.open_archive, path)
        assert line.startswith(f"{path}: '")
        assert "may lead to any file; allowed: datasets that lie in the file itself" in line
        if number < len(WAYS):
            for command in commands:
                assert line in refusal(command, path)
            assert line in refusal("continuation", "--from", path)


@pytest.mark.parametrize("way", WAYS)
def test_a_record_holds_its_samples_itself(here, original, way, error_of):
    with h5py.File("record.h5", "w") as file:
        file["time"] = np.arange(8.0)
        way(file, "acceleration", "secret.h5")
    assert "may lead to any file" in error_of(RecordFile(file="record.h5").read, "g")


def test_names_of_one_dataset_and_circles_of_groups_lead_nowhere_else(here):
    with h5py.File("record.h5", "w") as file:
        file["time"] = np.arange(8.0)
        file["acceleration"] = np.ones(8)
        file["further/circle"] = file["/"]
        file["further/again"] = file["time"]
    assert RecordFile(file="record.h5").read("g")["values"] == [1.0] * 8
