"""What request files name: paths, which count from their folder, and keys in shared tables."""

import numpy as np
import pytest

import nlds_vines as nv

QUAKE = "t [s],a [g]\n0,0\n0.01,0.1\n0.02,0\n"
MATRIX = "%%MatrixMarket matrix coordinate real symmetric\n1 1 1\n1 1 2.0\n"
FILES = {
    "sub/quake.csv": QUAKE,
    "sub/sets.csv": "m2\n50\n60\n",
    "sub/m.mtx": MATRIX,
    "sub/own.toml": 'system = "tmd"\n[set]\nm2 = 70\n',
    "sub/host.toml": (
        '[system]\nkind = "host"\n[system.host]\nM = "m.mtx"\nK = "./m.mtx"\n'
        "[[system.dampers]]\n"
        'name = "c"\nattached_to = "x1"\nm = 0.1\nk = 3\n[system.force]\nat = { x1 = 1.0 }\n'
        "f = 2.0\n"
    ),
    "sub/plain.toml": 'systems = ["none", "own.toml"]\nload.record = "quake.csv"\n',
    "sub/list.toml": (
        'systems = ["tmd"]\n[[load.record]]\nfile = "quake.csv"\n'
        '[[load.record]]\nfile = "quake.csv"\n'
    ),
    "sub/deep.toml": 'systems = ["./own.toml"]\nload.impulse = 1.0\n',
    "sub/samples.toml": 'system = "tmd"\nsamples.file = "sets.csv"\n',
}


@pytest.fixture
def folder(tmp_path, monkeypatch):
    (tmp_path / "sub").mkdir()
    for name, text in FILES.items():
        (tmp_path / name).write_text(text)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("place", ["", "sub"])
def test_paths_count_from_the_file_that_names_them(folder, monkeypatch, place):
    monkeypatch.chdir(folder / place)
    prefix = "" if place else "sub/"
    request = nv.load_response_history(f"{prefix}plain.toml")
    assert request.load.record[0].values == (0.0, 0.1, 0.0)
    assert request.systems[1].parameters["m2"] == 70.0
    assert len(nv.load_response_history(f"{prefix}list.toml").load.record) == 2
    assert nv.load_response_history(folder / "sub/deep.toml").systems[0].parameters["m2"] == 70.0
    scan = nv.load_scan(f"{prefix}samples.toml")
    np.testing.assert_array_equal(scan.sampled.columns["m2"], [50.0, 60.0])


def test_paths_of_options_and_of_python_count_from_the_working_folder(folder):
    load = {"load": {"record": "sub/quake.csv"}}
    assert nv.load_response_history("sub/plain.toml", load).load.record[0].source == "quake.csv"
    with pytest.raises(nv.RequestError, match=r"changes: \[load\]: .*: quake.csv: cannot be read"):
        nv.load_response_history("sub/plain.toml", {"load": {"record": "quake.csv"}})
    absolute = str(folder / "sub/quake.csv")
    (folder / "sub/plain.toml").write_text(f'systems = ["tmd"]\nload.record = "{absolute}"\n')
    assert nv.load_response_history("sub/plain.toml").load.record


def test_matrices_of_a_host_stand_beside_its_file(folder):
    for source in ("sub/host.toml", folder / "sub/host.toml"):
        assert float(nv.load_system(source).host.K[0, 0]) == 2.0
    (folder / "all.toml").write_text(
        'systems = ["sub/host.toml"]\nload.impulse = 1.0\nload.on="x1"\n'
    )
    assert float(nv.load_response_history("all.toml").systems[1].host.M[0, 0]) == 2.0


HOST = """
[system]
kind = "host"
[system.host]
shear_frame = { masses = [1.0, 1.0], stiffnesses = [90.0, 90.0] }
[[system.dampers]]
name = "cell"
attached_to = "floor1"
m = 0.1
k = 3
[system.force]
at = { roof = 1.0 }
f = 2.0
"""


def test_one_word_names_the_displacements_of_scans_and_histories(folder):
    """`[record] of` serves both; a history leaves `want` of a scan aside."""
    shared = '[record]\nwant = ["response"]\nof = ["roof"]\n[load]\nimpulse = 1.0\non = "roof"\n'
    (folder / "both.toml").write_text(HOST + "[vary]\nf = { values = [1.0, 2.0] }\n" + shared)
    scan = (
        HOST + '[vary]\nf = { values = [1.0, 2.0] }\n[record]\nwant = ["response"]\nof = ["roof"]\n'
    )
    (folder / "scan.toml").write_text(scan)
    (folder / "history.toml").write_text(HOST + shared)
    assert nv.load_scan("scan.toml").of == ("roof",)
    with pytest.warns(UserWarning, match=r"left aside here: want of \[record\]$"):
        assert nv.load_response_history("history.toml").of == ("roof",)
    with pytest.warns(UserWarning, match=r"left aside here: \[load\]$"):
        assert nv.load_scan("both.toml").of == ("roof",)
    with pytest.warns(UserWarning, match="left aside"):
        request = nv.load_response_history("history.toml", {"record": {"of": ["floor1", "roof"]}})
    assert request.of == ("floor1", "roof")
    assert nv.load_response_history(request.document()).of == ("floor1", "roof")


def test_the_former_place_of_that_word_is_refused(folder):
    (folder / "old.toml").write_text(HOST + '[sampling]\nof = ["roof"]\n[load]\nimpulse = 1.0\n')
    with pytest.raises(
        nv.RequestError, match=r"^old.toml: \[sampling\]: of = .* belongs in \[record\]$"
    ):
        nv.load_response_history("old.toml")
