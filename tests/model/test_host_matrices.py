"""Matrices of hosts as programs write them; 1000 damaged files, each of which ends in one line."""

import io
import os
import re
import resource
import struct
import time
import zipfile

import numpy as np
import pandas as pd
import pytest
import scipy.io
import scipy.sparse

import nlds_vines as nv
from nlds_vines.errors import checked_names, shown
from nlds_vines.model.loads.loading import Loading

M = np.diag([1.0, 2.0, 3.0])
K = np.array([[3.25, -1.5, 0.0], [-1.5, 2.0, -1e-3], [0.0, -1e-3, 4.125]])
NAMES = ("x1", "x2", "x3")


def rows(cut, decimal="."):
    lines = (cut.join(repr(value).replace(".", decimal) for value in row) for row in K.tolist())
    return "\n".join(lines)


def with_row_names(names):
    return "\n".join(
        f"{name},{row}" for name, row in zip(names, rows(",").split("\n"), strict=True)
    )


NUMBERED = ("101", "102", "103")
TEXTS = {
    "MATLAB's writematrix": (rows(","), "utf-8", NAMES),
    "MATLAB's save -ascii": (rows("   "), "utf-8", NAMES),
    "MATLAB's dlmwrite by tabs": (rows("\t"), "utf-8", NAMES),
    "Excel, Germany": (rows(";", ",") + "\r\n", "utf-8-sig", NAMES),
    "Excel, Unicode text": (rows("\t", ",").replace("\n", "\r\n"), "utf-16", NAMES),
    "Excel, Macintosh": (rows(",").replace("\n", "\r"), "utf-8", NAMES),
    "a comma after each number": (rows(",").replace("\n", ",\n") + ",", "utf-8", NAMES),
    "blanks and decimal commas": (rows(" ", ","), "latin-1", NAMES),
    "Fortran": (
        rows("  ").replace("-0.001", "-0.1D-02").replace("4.125", "4.125d0"),
        "utf-8",
        NAMES,
    ),
    "typographic minus": (rows(",").replace("-", "\u2212"), "utf-8", NAMES),
    "comments": ("% K\n# by rows\n\n" + rows(" ") + "\n\n", "utf-8", NAMES),
    "names": ('"roof","floor","cellar"\n' + rows(","), "utf-8", ("roof", "floor", "cellar")),
    "pandas": ("0,1,2\n" + rows(","), "utf-8", NAMES),
    "pandas, nodes": ("101,102,103\n" + rows(","), "utf-8", NUMBERED),
    "pandas with its index": (",a,b,c\n" + with_row_names("abc"), "utf-8", ("a", "b", "c")),
    "pandas with an index that counts": (",0,1,2\n" + with_row_names("012"), "utf-8", NAMES),
    "pandas with an index of nodes": (
        ",101,102,103\n" + with_row_names(NUMBERED),
        "utf-8",
        NUMBERED,
    ),
    "pandas with an index and its name": (
        "node,101,102,103\n" + with_row_names(NUMBERED),
        "utf-8",
        NUMBERED,
    ),
    "pandas to_string": (
        "   a b c\n" + with_row_names("abc").replace(",", " "),
        "utf-8",
        ("a", "b", "c"),
    ),
    "rows with names": (with_row_names(("n1", "n2", "n3")), "utf-8", ("n1", "n2", "n3")),
    "Excel, with empty cells around": (
        ",,,,,\n" + "\n".join(f",{row},," for row in rows(",").split("\n")) + "\n,,,,,\n",
        "utf-8",
        NAMES,
    ),
    "Excel, with its separator": ("sep=;\r\n" + rows(";", ","), "utf-8", NAMES),
}


@pytest.mark.parametrize("kind", TEXTS)
@pytest.mark.parametrize("suffix", [".csv", ".txt", ".dat", ".tsv", ".asc"])
def test_texts_are_read_as_programs_write_them(here, kind, suffix):
    text, encoding, names = TEXTS[kind]
    path = here / f"K{suffix}"
    path.write_bytes(text.encode(encoding))
    host = nv.Host(M, path)
    assert np.array_equal(host.K, K)
    assert host.dofs == names


def test_files_of_numpy_and_of_scipy_are_read(here):
    np.save("K.npy", K)
    np.save("columns.npy", np.asfortranarray(K))
    np.save("complex.npy", K.astype(complex))
    np.save("M.npy", M.astype(np.int32))
    for name in ("K.npy", "columns.npy", "complex.npy"):
        assert np.array_equal(nv.Host("M.npy", name).K, K)
    for form in ("coo", "csr", "csc", "bsr", "dia"):
        scipy.sparse.save_npz("sparse.npz", scipy.sparse.coo_array(K).asformat(form))
        assert np.array_equal(nv.Host(M, "sparse.npz").K, K)
    written = (K, scipy.sparse.coo_array(K), K.astype(complex), scipy.sparse.coo_array(1j * K))
    for symmetry in ("general", "symmetric"):
        for array in written[:3]:
            scipy.io.mmwrite("K.mtx", array, symmetry=symmetry)
            assert np.array_equal(nv.Host(M, "K.mtx").K, K)
    scipy.io.mmwrite("K.mtx", K.astype(complex), symmetry="hermitian")
    assert np.array_equal(nv.Host(M, "K.mtx").K, K)
    assert np.array_equal(nv.Host(M, scipy.sparse.csr_array(K.astype(complex))).K, K)


def test_sparse_files_of_blocks_and_of_diagonals_are_read_whatever_their_shapes(here, error_of):
    """Blocks of 2 x 2; diagonals longer than the matrix, whose ends are no entries."""
    rng = np.random.default_rng(4)
    for _ in range(30):
        A = rng.integers(-3, 4, (4, 4))
        A = A + A.T + 20 * np.eye(4)
        scipy.sparse.save_npz("blocks.npz", scipy.sparse.bsr_array(A, blocksize=(2, 2)))
        assert np.array_equal(nv.Host(np.eye(4), "blocks.npz").K, A)
        offsets = np.array([0, -1, 1])
        length = rng.integers(4, 7)
        band = rng.integers(1, 4, (3, length)).astype(float)
        band[0] += 10.0
        band[2, 1:4] = band[1, :3]
        diagonals = scipy.sparse.dia_array((band, offsets), shape=(4, 4))
        scipy.sparse.save_npz("diagonals.npz", diagonals)
        assert np.array_equal(nv.Host(np.eye(4), "diagonals.npz").K, diagonals.toarray())
    np.savez("sparse.npz", format="dia", shape=(4, 4), data=band, offsets=offsets[:2])
    assert "its diagonals and their offsets differ" in error_of(nv.Host, np.eye(4), "sparse.npz")
    whole = {"indices": [0], "indptr": [0, 1], "shape": (4, 4)}
    for blocks in (np.ones((1, 3, 3)), np.ones((1, 0, 2))):
        np.savez("sparse.npz", format="bsr", data=blocks, **whole)
        assert "its blocks do not fit its shape" in error_of(nv.Host, np.eye(4), "sparse.npz")


def test_a_host_is_read_from_one_file_of_each_matrix(here, error_of):
    np.save("M.npy", M)
    np.savetxt("K.txt", K)
    scipy.io.mmwrite("C.mtx", 0.1 * K)
    host = nv.Host.from_file("M.npy", here / "K.txt", "C.mtx", dofs=[101, 102, 103])
    expected = nv.Host(M, K, 0.1 * K, dofs=NUMBERED)
    assert host.dofs == expected.dofs
    for name in ("M", "K", "C"):
        assert np.array_equal(getattr(host, name), getattr(expected, name))
    assert "4 files; allowed: those of M, K and C" in error_of(nv.Host.from_file, *["M.npy"] * 4)
    assert error_of(nv.Host.from_file, "M.npy", K) == f"path = {shown(K)} must be a path"
    assert error_of(nv.Host.from_file, 5) == "path = 5 must be a path"


@pytest.mark.parametrize(
    "names", [("M", "K", "C"), ("m", "k", "c"), ("mass", "stiffness", "damping")]
)
def test_one_file_has_all_matrices_under_the_usual_names(here, names):
    arrays = dict(zip(names, (M, K, 0.1 * K), strict=True))
    np.savez("frame.npz", **arrays, dofs=[101, 102, 103], influence=[1.0, 0.0, 1.0], other="text")
    host = nv.Host.from_file("frame.npz")
    assert host.dofs == NUMBERED
    assert np.array_equal(host.C, 0.1 * K)
    assert host.inertia.tolist() == [1.0, 0.0, 3.0]
    assert nv.Host.from_file("frame.npz", ratio=0.1).damping_ratios == pytest.approx([0.1] * 3)
    assert nv.Host.from_file("frame.npz", dofs=["a", "b", "c"]).dofs == ("a", "b", "c")
    assert np.array_equal(nv.Host("frame.npz", "frame.npz").K, K)


def test_names_come_from_tables_of_pandas_and_from_numbers_of_nodes(error_of):
    plain, named = pd.DataFrame(M), pd.DataFrame(K, columns=[7, 8, 9], index=[7, 8, 9])
    assert nv.Host(plain, named).dofs == ("7", "8", "9")
    assert nv.Host(plain, named, dofs=list("abc")).dofs == ("a", "b", "c")
    assert nv.Host(plain, pd.DataFrame(K)).dofs == NAMES
    host = nv.Host(M, K, dofs=np.array([101, 102, 103]), ratio=0.01)
    force = {"103": 2.0}
    system = nv.System.from_host(host, [], force=force, omega=1.0)
    assert system.with_(**{"force.102": 3.0}).parameters["force.102"] == 3.0
    assert system.displacement("101-103")[0].tolist() == [1.0, 0.0, -1.0]
    for place, same in ((103, "103"), ((101, 103), ("101", "103")), (np.int64(102), "102")):
        mass = {"m": 1.0} if same in NUMBERED else {}
        one, other = (nv.Damper("a", to, **mass, k=2.0) for to in (place, same))
        assert one == other
        with_numbers = nv.System.from_host(host, [one], force={103: 2.0}, omega=1.0)
        with_texts = nv.System.from_host(host, [other], force=force, omega=1.0)
        assert with_numbers.to_table() == with_texts.to_table()
    moved = with_texts.with_(**{"a.attached_to": 101})
    assert moved.dampers[0].places == ("101",)
    assert host.reduced(1, statics=[103]).heading() == host.reduced(1, statics=["103"]).heading()
    assert np.array_equal(host.row(102), host.row("102"))
    response = host.frequency_response(1.0, force={102: 1.0})
    assert np.array_equal(response, host.frequency_response(1.0, force={"102": 1.0}))
    assert checked_names("of", [101, np.int64(102), "roof"]) == ("101", "102", "roof")
    assert Loading(on=102).on == "102"
    assert Loading(on={101: 1, "102": 2}).on == {"101": 1.0, "102": 2.0}
    assert "names a degree of freedom twice" in error_of(Loading, on={1: 1.0, "1": 2.0})
    shaken = {"influence": {101: 1.0}, "acceleration": 1.0}
    assert nv.System.from_host(host, base=shaken, omega=1.0).host.inertia.tolist() == [1.0, 0, 0]


MASKED = np.ma.array(K, mask=K == 2.0)
MARKET = "%%MatrixMarket matrix coordinate real general\n"
WRONG_FILES = {
    "K.mat": (b"", "MATLAB's files are not read here: a = scipy.io.loadmat"),
    "K.xlsx": (b"", "allowed: .csv, .txt, .dat, .tsv, .asc, .npy, .npz and .mtx"),
    "lower.txt": (b"1\n2 1\n0 2 1", "is the lower triangle of a symmetric matrix alone"),
    "upper.csv": (b"1,2,3\n1,2\n1", "is the upper triangle of a symmetric matrix alone"),
    "sheet.csv": (b"1,,\n2,1,\n0,2,1", "is the lower triangle of a symmetric matrix alone"),
    "page.csv": (b"1;2,5;3\n;1;2,5\n;;1", "is the upper triangle of a symmetric matrix alone"),
    "full.csv": (b"1,0,0\n2,5,0\n0,1,5", "it is its lower triangle alone; give all of it"),
    "empty.csv": (b"\n\n# nothing\n", "holds no numbers"),
    "gap.csv": (b"1,,0\n0,1,0\n0,0,1", "row 1, column 2 is empty: give all numbers, also 0"),
    "blank.csv": (b"1, ,0\n0,1,0\n0,0,1", "row 1, column 2: '' must be a number"),
    "diagonal.csv": (b"1,,\n,1,\n,,1", "row 1, column 2 is empty: give all numbers, also 0"),
    "thousands.csv": (b'"20,000",0,0\n0,1,0\n0,0,1', 'holds "20,000": export its numbers without'),
    "words.csv": (b"Stiffness of a frame\n1,0,0\n0,1,0\n0,0,1", "but 3 columns need names; a tit"),
    "triplets.txt": (b"1 1 2.5\n1 2 -1\n2 2 1\n3 3 1", "rows of `row, column, value` are read by"),
    "swapped.csv": (b",a,b,c\nb,0,1,0\na,1,0,0\nc,0,0,1", "names its rows otherwise than its"),
    "node.csv": (b"1,0,0\n0,node,0\n0,0,1", "row 2, column 2: 'node' must be a number"),
    "script.csv": ("1,\u0661,0\n0,1,0\n0,0,1".encode(), "row 1, column 2: '\u0661' must be"),
    "python.csv": (b"1,0,0\n0,1_0,0\n0,0,1", "row 2, column 2: '1_0' must be a number"),
    "signs.csv": (b"1.0;0,5\n0,5;2", "a comma and a point: one of them is a decimal sign"),
    "short.csv": (b"1,0,0\n0,1\n0,0,1", "row 2 has 2 numbers, the first one 3"),
    "flat.csv": (b"1,0,0\n0,1,0", r"has the shape \(2, 3\); it must be square"),
    "book.csv": (b"PK\x03\x04 more", "is a workbook or compressed"),
    "binary.txt": (bytes(range(256)), "is no text: utf-16-be fails at byte 216"),
    "cut.mtx": (f"{MARKET}2 2 1E".encode(), "its size '2 2 1E' must be rows, columns and entries"),
    "few.mtx": (f"{MARKET}3 3 4\n1 1 1\n2 2 1\n".encode(), "states 4 entries, and has 2 lines"),
    "huge.mtx": (f"{MARKET}30000 30000 1\n1 1 1".encode(), r"K has the shape \(30000, 30000\)"),
    "vast.mtx": (f"{MARKET}999999999 999999999 1\n1 1 1".encode(), "allowed: as many, from 1 to"),
    "outside.mtx": (f"{MARKET}3 3 1\n4 1 1\n".encode(), "an index is no whole number from 1 to 3"),
    "half.mtx": (f"{MARKET}3 3 1\n1.5 1 1\n".encode(), "an index is no whole number from 1 to 3"),
    "twice.mtx": (f"{MARKET}3 3 2\n1 1 1\n1 1 1\n".encode(), "entry in row 1, column 1 twice"),
    "signs.mtx": (MARKET.replace("real", "pattern").encode() + b"3 3 1\n1 1\n", "is of the kind"),
    "abaqus.mtx": (b"1,1,2.5e6\n", "has no header of Matrix Market"),
}  # fmt: skip


@pytest.mark.parametrize("name", WRONG_FILES)
def test_files_that_hold_no_matrix_are_refused_in_one_line(here, name, error_of):
    content, message = WRONG_FILES[name]
    (here / name).write_bytes(content)
    line = error_of(nv.Host, M, name)
    assert re.search(message, line)
    assert line.startswith((f"K = '{name}': ", "K has the shape"))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"K": MASKED}, "K has masked entries, which have no value"),
        ({"M": np.ma.array(M, mask=M == 1.0)}, "M has masked entries"),
        ({"C": MASKED}, "C has masked entries"),
        ({"K": K * (1 + 1e-9j)}, "K holds a value that is no finite real number"),
        ({"dofs": [1.5, 2, 3]}, "dofs: 1.5 must be a text or a whole number"),
        ({"dofs": [True, 2, 3]}, "dofs: True must be a text or a whole number"),
        ({"K": pd.DataFrame(K, index=list("abc"))}, "K names its rows otherwise than its columns"),
        (
            {"M": pd.DataFrame(M, columns=list("abd")), "K": pd.DataFrame(K, columns=list("abc"))},
            "K names its columns otherwise than M",
        ),
        ({"K": pd.DataFrame(K).replace(2.0, None)}, "K holds a value that is no finite real"),
    ],
)
def test_values_that_would_be_read_wrongly_are_refused(options, message, error_of):
    assert re.search(message, error_of(nv.Host, **{"M": M, "K": K, **options}))


def test_what_is_no_regular_file_is_refused_at_once(here, error_of):
    for suffix in (".csv", ".npy", ".npz", ".mtx"):
        os.mkfifo(f"pipe{suffix}")
        os.symlink("/dev/zero", f"zero{suffix}")
        os.mkdir(f"folder{suffix}")
        for name in ("pipe", "zero", "folder"):
            assert "cannot be read: it is no regular file" in error_of(
                nv.Host, M, f"{name}{suffix}"
            )
        assert "No such file" in error_of(nv.Host, M, f"absent{suffix}")
    assert "no regular file" in error_of(nv.Host.from_file, "pipe.npz")


def test_files_of_one_matrix_and_files_without_one_say_what_they_lack(here, error_of):
    np.savez("a.npz", M=M, Kay=K)
    np.savez("b.npz", M=M, K=K, stiffness=K)
    np.savez("c.npz", **{f"a{i}": M for i in range(20)})
    for path, message in (
        ("a.npz", "has no array K (or k, stiffness); it has: M, Kay"),
        ("c.npz", "has no array M (or m, mass); it has: a0, a1, a2, a3, a4, a5, a6, a7, ..."),
        ("b.npz", "K stands beside stiffness: give one of them"),
        ("K.mtx", "a .mtx file holds one matrix: nv.Host(M='M.mtx', K='K.mtx') reads two"),
        ("K.mat", "MATLAB's files are not read here"),
        ("frame.toml", "a .toml file holds no host: nv.load_system reads a system of .toml"),
        ("absent.npz", "cannot be read: No such file"),
    ):
        line = error_of(nv.Host.from_file, path)
        assert line.startswith(f"{path}: ")
        assert message in line


# ---- damaged files -------------------------------------------------------------------------------


def saved(write, *arrays, **named):
    file = io.BytesIO()
    write(file, *arrays, **named)
    return file.getvalue()


SOUND = {
    ".csv": "\n".join(",".join(map(repr, row)) for row in K.tolist()).encode(),
    ".txt": rows(" ").encode(),
    ".npy": saved(np.save, K),
    ".npz": saved(np.savez_compressed, M=M, K=K, C=0.1 * K),
    ".mtx": saved(scipy.io.mmwrite, scipy.sparse.coo_array(K), symmetry="symmetric"),
}
SIZES = ("0", "-3", "2", "4", "3000", "999999999", "99999999999999999999", "1E", "")


def damaged(rng, suffix):
    """Return the content of a file that was cut, or has changed bytes or sizes that are lies."""
    data = bytearray(SOUND[suffix])
    way = rng.integers(4)
    if way == 0:
        return bytes(data[: rng.integers(len(data))])
    if way == 1:
        for place in rng.integers(len(data), size=rng.integers(1, 9)):
            data[place] ^= 1 << rng.integers(8)
        return bytes(data)
    if way == 2:
        place, length = rng.integers(len(data)), rng.integers(1, 40)
        data[place : place + length] = rng.bytes(rng.integers(40))
        return bytes(data)
    size = SIZES[rng.integers(len(SIZES))].encode()
    if suffix == ".npz":  # the sizes of a member: four bytes each, in its header and in the index
        for mark, offset in ((b"PK\x03\x04", 18), (b"PK\x01\x02", 20)):
            place = data.find(mark, rng.integers(len(data) // 2)) + offset
            data[place : place + 8] = struct.pack("<II", *rng.integers(2**32, size=2))
        return bytes(data)
    numbers = [*re.finditer(rb"\d+", data)]
    spot = numbers[rng.integers(len(numbers))]
    return bytes(data[: spot.start()]) + size + bytes(data[spot.end() :])


@pytest.mark.slow("1000 files")
@pytest.mark.parametrize("suffix", SOUND)
def test_of_200_damaged_files_each_ends_in_one_line(here, suffix):
    rng = np.random.default_rng(610)
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    lines, longest = [], 0.0
    for _ in range(200):
        path = here / f"K{suffix}"
        path.write_bytes(damaged(rng, suffix))
        began = time.process_time()
        try:
            host = nv.Host(M, path)
            assert np.isfinite(host.K).all()  # a changed digit, or a name that is not read
        except nv.RequestError as error:
            lines.append(str(error))
        longest = max(longest, time.process_time() - began)
    assert len(lines) > 133
    assert "\n" not in "".join(lines)
    assert longest < 1.0
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - memory < 100e3  # 100 MB


@pytest.mark.slow("200 files")
def test_of_200_files_with_damaged_arrays_under_a_right_checksum_each_ends_in_one_line(here):
    """Names that are no characters, lengths that overflow, types that are none."""
    rng = np.random.default_rng(63)
    lines = []
    for number in range(200):
        names = ["roof", "fl\u00f6\u00f6r", "x"]
        texts = [name.encode() for name in names] if number % 3 else names
        arrays = {"M": M, "K": K, "c": K, "dofs": np.array(texts), "influence": np.ones(3)}
        members = {name: bytearray(saved(np.save, array)) for name, array in arrays.items()}
        content = members[list(members)[rng.integers(len(members))]]
        for place in rng.integers(len(content), size=rng.integers(1, 6)):
            content[place] ^= 1 << rng.integers(8)
        (here / "frame.npz").write_bytes(packed(zipfile.ZIP_STORED, **members))
        try:
            nv.Host.from_file("frame.npz")
        except nv.RequestError as error:
            lines.append(str(error))
    assert len(lines) > 133
    assert "\n" not in "".join(lines)


def packed(method, **members):
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", method) as archive:
        for name, content in members.items():
            archive.writestr(f"{name}.npy", bytes(content))
    return file.getvalue()


def header(shape, dtype="<f8"):
    file = io.BytesIO()
    description = {"descr": dtype, "fortran_order": False, "shape": shape}
    np.lib.format.write_array_header_1_0(file, description)
    return file.getvalue()


def objects():
    return saved(np.save, np.array([[{}]], dtype=object), allow_pickle=True)


ZEROS = bytes(600_000_000)
LARGE = {
    "bomb.npz": (lambda: packed(zipfile.ZIP_DEFLATED, K=ZEROS), "holds 600000000 bytes; allowed"),
    "bzip.npz": (lambda: packed(zipfile.ZIP_BZIP2, K=bytes(1000)), "encrypted or packed otherwise"),
    "liar.npy": (lambda: header((10**9, 10**9)) + bytes(80), "is damaged: its shape"),
    "minus.npy": (lambda: header((-3, -3)) + bytes(72), "is damaged: its shape"),
    "objects.npy": (objects, "holds values of type object"),
    "version.npy": (lambda: b"\x93NUMPY\x09\x09", "is damaged|version"),
    "line.txt": (lambda: b"1 " * 20_000_000, r"has the shape \(1, 4097\)"),
    "ends.csv": (lambda: b"\n" * 64_000_000, "holds no numbers"),
    "column.csv": (lambda: b"1\n" * 20_000_000, "has more than 4096 rows"),
    "sheet.csv": (lambda: (b"1" + b"," * 4000 + b"1\n") * 4001, "row 1, column 2 is empty"),
    "line.mtx": (lambda: f"{MARKET}3 3 1\n".encode() + b"1 " * 20_000_000, "longer than an entry"),
    "sparse.csv": (None, "bytes; allowed: up to 268435456"),
}


@pytest.mark.slow("files of up to 60 MB")
@pytest.mark.parametrize("name", LARGE)
def test_a_large_file_takes_neither_memory_nor_time(here, name, error_of):
    write, message = LARGE[name]
    if write is None:
        with (here / name).open("wb") as file:
            file.truncate(10**11)
    else:
        (here / name).write_bytes(write())
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    began = time.process_time()
    assert re.search(message, error_of(nv.Host, M, name))
    assert time.process_time() - began < 5.0
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - memory < 500e3


def test_commands_refuse_a_damaged_file_with_status_2(here, refusal):
    (here / "K.mtx").write_text(f"{MARKET}2 2 1E")
    np.save("M.npy", M)
    text = '[system]\nkind = "host"\n[system.host]\nM = "M.npy"\nK = "K.mtx"\n'
    (here / "frame.toml").write_text(f"{text}[system.force]\nat = {{ x1 = 1.0 }}\nomega = 1.0\n")
    for words in (["bifurcation", "frame.toml", "--dry-run"], ["portrait", "frame.toml"]):
        assert "K.mtx': is damaged: its size '2 2 1E' must be" in refusal(*words)
