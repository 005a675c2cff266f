"""Records as people have them: public formats, locales and units, read rightly or refused."""

import math
import random
import resource
import time

import numpy as np
import pytest

from nlds_vines.errors import RequestError
from nlds_vines.model.loads.courses import ACCELERATIONS, canonical
from nlds_vines.model.loads.record import Record

STEP = 0.01
VALUES = [0.0, 0.0125, -0.25, 0.5, -0.375, 0.125, 0.0, -0.0625, 0.03125, 0.25, -0.5, 0.0625, 0.0]
TIMES = [STEP * i for i in range(len(VALUES))]


def read(tmp_path, content, name="quake.csv", **keys):
    """Return the record in a file with this content, text or bytes, read with these keys."""
    path = tmp_path / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return Record.of({"file": str(path), **keys})


def is_right(record, unit="g", values=VALUES, step=STEP):
    np.testing.assert_allclose(record.times, [step * i for i in range(len(values))], atol=1e-12)
    np.testing.assert_allclose(record.values, values, rtol=1e-12)
    assert record.unit == unit


def rows(values, per_line, form="{:15.7E}"):
    """Return the lines of values, so many on each, as Fortran writes them."""
    cells = [form.format(value) for value in values]
    lines = ["".join(cells[i : i + per_line]) for i in range(0, len(cells), per_line)]
    return "\n".join(lines) + "\n"


PEER = """\
PEER NGA STRONG MOTION DATABASE RECORD
Imperial Valley-02, 5/19/1940, El Centro Array #9, 180
ACCELERATION TIME SERIES IN UNITS OF G
"""


def cosmos(values, step, unit="cm/sec2", channels=1):
    """Return a COSMOS volume: real headers 34 (step [s]), 62 (step [ms]) and 63 (duration [s])."""
    text = ""
    for channel in range(channels):
        reals = [-999.0] * 100
        reals[33], reals[61], reals[62] = step, 1e3 * step, step * len(values)
        text += "Corrected acceleration   (Format v01.20 with 13 text lines) Src: made up\n"
        text += "".join(f"text line {i}: 2 0.01 (cm)\n" for i in range(2, 14))
        text += " 100 Integer-header values follow on  10 lines, Format= (10I8)\n"
        text += ("".join(f"{-999:8d}" for _ in range(10)) + "\n") * 10
        text += " 100 Real-header values follow on  17 lines, Format= (6F13.6)\n"
        text += rows(reals, 6, "{:13.6f}")
        text += '   1 Comment line(s) follow, each starting with a "|":\n| made up\n'
        text += f"{len(values):8d} acceleration pts, approx {round(step * len(values)):3d} secs, "
        text += f"units={unit} (04),Format=(8F10.5)\n"
        text += rows([(channel + 1) * value for value in values], 8, "{:10.5f}")
        text += f"End-of-data for Chan  {channel + 1} acceleration\n"
    return text


def csmip(values, step, channels=1):
    """Return a CSMIP volume 2, in which accelerations, velocities and displacements follow."""
    text = ""
    for channel in range(channels):
        text += "Corrected accelerogram Chan 1\n" + "of 2019 title lines with 12 numbers\n" * 24
        text += ("".join(f"{7:5d}" for _ in range(16)) + "\n") * 7
        text += rows([0.5] * 100, 8, "{:10.3f}")
        for word, unit in (("accel", "cm/sec2"), ("veloc", "cm/sec"), ("displ", "cm")):
            text += f"{len(values):5d} points of {word} data equally spaced at  {step:.3f} sec, "
            text += f"in {unit}. (8f10.6)\n"
            text += rows([(channel + 1) * value for value in values], 8, "{:10.6f}")
        text += f"/&  ----------  End of data for channel {channel + 1}  ----------\n"
    return text


def smc(values, rate):
    integers, reals = [-32768] * 48, [1.7e38] * 50
    integers[15], integers[16], reals[1] = 2, len(values), rate
    text = "2 CORRECTED ACCELEROGRAM\n" + "*\n" * 10
    text += rows(integers, 8, "{:10d}") + rows(reals, 5, "{:15.7E}") + "|made up 1 2\n|\n"
    return text + rows(values, 8, "{:10.3E}")


def test_peer(tmp_path):
    for head, per_line in (("NPTS=    13, DT=   .0100 SEC", 5), ("   13    0.0100  NPTS, DT", 8)):
        record = read(tmp_path, PEER + head + "\n" + rows(VALUES, per_line), "RSN6.AT2")
        is_right(record)
        assert record.reading == "PEER"
    is_right(read(tmp_path, (PEER + "NPTS= 13, DT= .0100 SEC,\n" + rows(VALUES, 5)) + "\x1a"))
    joined = PEER + "NPTS=13, DT=.01\n" + rows(VALUES, 5, "{:12.4E}")
    is_right(read(tmp_path, joined))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("NPTS=    13", "NPTS=    14"), "states 14 values, 13 follow"),
        (("NPTS=    13", "NPTS=    12"), "states 12 values, more follow"),
        (("ACCELERATION", "VELOCITY"), "holds a velocity"),
        (("DT=   .0100", "DT=   .0"), "step"),
        (("UNITS OF G", "UNITS OF COUNTS"), "allowed"),
        (("UNITS OF G", ""), "unit"),
    ],
)
def test_peer_files_that_contradict_themselves(tmp_path, change, words, error_of):
    text = PEER + "NPTS=    13, DT=   .0100 SEC\n" + rows(VALUES, 5)
    assert words in error_of(read, tmp_path, text.replace(*change))


def test_cosmos_csmip_and_smc(tmp_path, error_of):
    is_right(read(tmp_path, cosmos(VALUES, STEP), "CE1.V2c"), "cm/s^2")
    is_right(read(tmp_path, csmip(VALUES, STEP), "CE1.V2"), "cm/s^2")
    is_right(read(tmp_path, smc(VALUES, 100.0), "1234.smc"), "cm/s^2")
    for text in (cosmos(VALUES, STEP, channels=2), csmip(VALUES, STEP, channels=2)):
        first, second = read(tmp_path, text), read(tmp_path, text, column=2)
        is_right(first, "cm/s^2")
        assert "values in column channel 1, not in column channel 2" in first.reading
        is_right(second, "cm/s^2", [2 * value for value in VALUES])
        assert "channel" in error_of(read, tmp_path, text, column=3)
    wrong = cosmos(VALUES, STEP).replace("approx   0", "approx  90")
    assert "give dt" in error_of(read, tmp_path, wrong)


@pytest.mark.parametrize("text", ["1\n2\n3\n", "3 1\n2 2\n1 3\n"])
def test_one_error_names_the_step_and_the_unit_that_a_file_lacks(tmp_path, text, error_of):
    both, step = error_of(read, tmp_path, text), error_of(read, tmp_path, text, unit="g")
    assert "dt" in both
    assert "give unit, too" in both
    assert "m/s^2" in both
    assert "dt" in step
    assert "unit" not in step


def test_fields_of_fortran_need_no_blanks(tmp_path):
    large = [1000.0 * value for value in VALUES]
    record = read(tmp_path, cosmos(large, STEP).replace("8F10.5", "8F10.4")
                  .replace(rows(large, 8, "{:10.5f}"), rows(large, 8, "{:10.4f}")))  # fmt: skip
    is_right(record, "cm/s^2", large)
    touching = [-123.45678] * 16
    is_right(read(tmp_path, cosmos(touching, STEP)), "cm/s^2", touching)


def test_one_column_with_its_step_in_front(tmp_path, error_of):
    text = "El Centro 1940, N-S\n   13  0.0100\n" + rows(VALUES, 1)
    is_right(read(tmp_path, text, unit="g"))
    is_right(read(tmp_path, text.replace("N-S", "N-S (m/s^2)")), "m/s^2")
    assert "unit" in error_of(read, tmp_path, text)
    is_right(read(tmp_path, "13 0.01\n" + rows(VALUES, 8), unit="g"))
    either = "4 0.1\n5 0.2\n6 0.3\n"
    assert "skip" in error_of(read, tmp_path, either, unit="g")


def test_plain_numbers_with_a_step(tmp_path, error_of):
    for per_line in (1, 5, 8):
        is_right(read(tmp_path, rows(VALUES, per_line), dt=STEP, unit="g"))
    is_right(read(tmp_path, rows(VALUES, 3), dt=STEP, unit="g", column=0))
    commas = "\n".join(f"{v:.5f}".replace(".", ",") for v in VALUES)
    assert "decimal" in error_of(read, tmp_path, commas, dt=STEP, unit="g")
    is_right(read(tmp_path, commas, dt=STEP, unit="g", decimal=","))
    is_right(read(tmp_path, " ".join(map(str, VALUES)), dt=STEP, unit="g"))
    three = "\n".join(f"{v} {2 * v} {3 * v}" for v in VALUES)
    assert "column = 1 to 3" in error_of(read, tmp_path, three, dt=STEP, unit="g")
    many = {"dt": STEP, "unit": "g", "column": "9" * 5000}
    assert "must be a whole number" in error_of(read, tmp_path, three, **many)
    is_right(read(tmp_path, three, dt=STEP, unit="g", column=1))
    assert "dt" in error_of(read, tmp_path, rows(VALUES, 1), unit="g")
    whole = "\n".join(f"{i % 3},{i % 7}" for i in range(9))
    assert "decimal" in error_of(read, tmp_path, whole, dt=STEP, unit="g")
    fractions = [float(f"{i % 3}.{i % 7}") for i in range(9)]
    is_right(read(tmp_path, whole, dt=STEP, unit="g", decimal=","), values=fractions)
    assert "beside" in error_of(read, tmp_path, table(), dt=STEP)


def table(heading="time [s], acceleration [g]", cut=", ", comma=False, form="{:.5f}", end=""):
    lines = [
        cut.join([f"{t:.2f}", form.format(v)]).replace(".", "," if comma else ".") + end
        for t, v in zip(TIMES, VALUES, strict=True)
    ]
    return "\n".join([*([heading] if heading else []), *lines]) + "\n"


TABLES = {
    "comma": table(),
    "semicolon": table("time [s];acceleration [g]", ";"),
    "German": table("Zeit [s];Beschleunigung [g]", ";", comma=True),
    "tabs": table("t (s)\ta (g)", "\t"),
    "tabs and decimal commas": table("t (s)\ta (g)", "\t", comma=True),
    "blanks": table("t (s)   a (g)", "   "),
    "blanks and decimal commas": table("t (s)   a (g)", "   ", comma=True),
    "names of several words": table("Time (s)   Ground acceleration (g)", "   "),
    "a note as heading": table("# time [s], acceleration [g]"),
    "MATLAB's notes": table("% t (s)  a (g)", " "),
    "trailing commas": table("t [s],a [g],", ",", end=","),
    "quotes": table('"time (s)","acceleration, vertical (g)"', ","),
    "quoted numbers": table('"t [s]","a [g]"', ",").replace(",0.50000", ',"0.50000"'),
    "D exponents": table(cut=" ", heading="t [s] a [g]", form="{:.7E}").replace("E", "D"),
    "title rows": "El Centro\nstation 117, 1940\n\n" + table(),
    "a row of units": table("time,acc\ns,g", ","),
    "units in brackets below": table("time;acc\n[s];[g]", ";"),
    "units behind slashes": table("t/s;a/g", ";"),
    "units behind names": table("time_s,acc_g", ","),
    "Ctrl-Z": table() + "\x1a",
    "Windows' line ends": table().replace("\n", "\r\n"),
    "old Mac's line ends": table().replace("\n", "\r"),
    "Unicode minus": table().replace("-", "\u2212"),
    "no-break spaces": table().replace(", ", ",\u00a0"),
    "UTF-8 with a mark": table().encode("utf-8-sig"),
    "UTF-16": table().encode("utf-16"),
    "UTF-16 without a mark": table().encode("utf-16-le"),
    "Latin-1": ("# Erdbeben in Köln\n" + table()).encode("latin-1"),
    "comments between": table().replace("\n0.05", "  # the peak\n# gap\n\n0.05"),
    "units apart": table("time  [s]   acceleration   ( g )", "   "),
    "exponents": table(form="{:+.6e}"),
    "bbp": "# Sim NGAH\n# time(sec) N-S(g) E-W(g)\n" + "\n".join(
        f"{t:.2f}\t{v}\t{2 * v}" for t, v in zip(TIMES, VALUES, strict=True)),
    "milliseconds": "t [msec], a [g]\n" + "\n".join(
        f"{1000 * t:.0f}, {v}" for t, v in zip(TIMES, VALUES, strict=True)),
}  # fmt: skip


@pytest.mark.parametrize("name", TABLES)
def test_tables_of_all_locales(tmp_path, name):
    is_right(read(tmp_path, TABLES[name]))


def test_a_table_without_headings_is_told(tmp_path):
    record = read(tmp_path, table(heading=""), unit="g")
    is_right(record)
    assert record.reading == "times [s] in column 1"
    record = read(tmp_path, table(heading="", cut=" ", comma=True), unit="g")
    assert record.reading == "decimal comma; times [s] in column 1"
    is_right(read(tmp_path, table(heading=""), unit="g", time_unit="ms"), step=STEP / 1000)
    record = read(tmp_path, TABLES["bbp"].replace("E-W(g)", "E-W(gal)"), column="e-w")
    is_right(record, "gal", [2 * value for value in VALUES])
    assert record.reading == ""
    assert "N-S, not in column E-W" in read(tmp_path, TABLES["bbp"]).reading
    is_right(read(tmp_path, "1 2 3\n" + table(heading="", cut=" "), unit="g", skip=1))


SPELLINGS = {
    "m/s^2": "m/s2 m/s² m/s/s m/s**2 m/s^2 m/sec^2 M/S2 m/(s^2) m.s-2 m*s^-2",
    "cm/s^2": "cm/s2 cm/sec^2 cm/sec/sec cm/s/s cm/sec2 cm/s²",
    "gal": "Gal gal gals GAL",
    "g": "g G",
    "%g": "%g",
    "mg": "mg",
    "mm/s^2": "mm/s2 mm/s²",
    "ft/s^2": "ft/s2 ft/s^2 ft/sec/sec",
    "in/s^2": "in/s/s in/s2 in/sec^2",
    "N": "N", "kN": "kN KN", "lbf": "lbf",
}  # fmt: skip


def test_units_as_people_write_them(tmp_path):
    for unit, spellings in SPELLINGS.items():
        for text in spellings.split():
            is_right(read(tmp_path, table(f"t [sec], a [{text}]")), unit)
            is_right(read(tmp_path, table("t [seconds], a"), unit=text), unit)
            if "/" in text:  # a unit alone, which ends as a time does
                is_right(read(tmp_path, table(f"t [sec], {text}")), unit)
    assert (ACCELERATIONS["%g"], ACCELERATIONS["mg"]) == (0.0980665, 0.00980665)
    for text in ("m/s", "m", "cm/s", "counts", "pound", "mN", "g/s", ""):
        assert canonical(text) is None


@pytest.mark.parametrize(
    ("text", "keys", "words"),
    [
        (table("t [s], v [cm/s]"), {}, "cm/s"),
        (table("time, m/s"), {}, "unknown unit of column 2 'm/s'"),
        (table("t [h], a [g]"), {}, "time_unit"),
        (table(heading="", cut=","), {}, "unit"),
        (table(heading="", cut=",", comma=True), {"unit": "g"}, "times"),
        (table("t [s],a [g]", ",", comma=True), {}, "semicolons"),
        ("time, a [g]\n2020-01-32 00:00:00, 1\n2020-01-01 00:00:01, 2\n", {}, "line 2: 2020-01-32"),
        ("1 2 3\n" + table(heading="", cut=" "), {"unit": "g"}, "skip = 1"),
        (table() + "End of data\n", {}, "line 15"),
        (table().replace("0.50000", "1_000"), {}, "line 5"),
        (b"PK\x03\x04" + bytes(99), {}, "workbook"),
        (b"\x89PNG\r\n\x1a\n" + bytes(99), {}, "text"),
        ("", {}, "quake.csv: holds no numbers"),
        ("time [s]\n0\n1\n", {}, "two columns"),
        ("time [s], force\n0, 1\n1, 2\n", {}, "unit of column force"),
        ("time [s], force [pound]\n0, 1\n1, 2\n", {}, "unit of column force 'pound'; allowed: N"),
        ("time [s], force [N]\n0, 1\n1, 2\n2, nan\n", {}, "sample 3, = nan must be a finite"),
        ("time [s], force [N]\n0, 1\n1, two\n", {}, "line 3: 'two'"),
        ("time [s], force [N]\n0, 1\n1\n", {}, "line 3: 1 columns"),
        ("time [s], force [N]\n0, 1\n1, \n", {}, "line 3: a value is missing"),
        ("t [s], F [N]\n0, 1\n2, 2\n1, 3\n", {}, "ascend: sample 3 at 1 s follows one at 2 s"),
        ("t [s], F [N]\n0, 1\n1, 2\n2, 3\n5, 2\n6, 2\n", {}, "a gap of 3 s"),
        ("time [s], force [N]\n0, 1\n", {}, "2 to"),
        ("a story\nwithout numbers\n", {}, "no numbers"),
        (table(), {"column": "east"}, "acceleration"),
        (table(), {"column": 3}, "acceleration"),
        (table(), {"decimal": ";"}, "decimal"),
        (table(), {"skip": -1}, "skip"),
        (table(), {"unit": "furlong"}, "allowed"),
        (table(), {"dt": "x"}, "dt"),
        (table(), {"colum": 2}, "colum"),
    ],
)
def test_what_cannot_be_read_is_refused_with_the_key_that_helps(
    tmp_path, text, keys, words, error_of
):
    message = error_of(read, tmp_path, text, **keys)
    assert words in message, message


def test_large_files_are_read_in_linear_time(tmp_path):
    count = 200_000
    text = "t [s], a [g]\n" + "".join(f"{i * 0.01:.2f}, {i % 97}.5\n" for i in range(count))
    began = time.process_time()
    assert len(read(tmp_path, text).values) == count
    assert time.process_time() - began < 3.0
    gaps = (" " * 90_000, "[" * 90_000, "a[" * 40_000, " (" * 40_000)
    for hostile in (
        " " * 10**6, "NPTS=" + " " * 10**6, "(" * 10**6, "1," * 500_000, '"' * 10**6,
        *(f"time{gap}[s, force{gap}[N] x" for gap in gaps),
    ):  # fmt: skip
        began = time.process_time()
        with pytest.raises(RequestError):
            read(tmp_path, hostile + "\n1 2\n")
        assert time.process_time() - began < 1.0
    began = time.process_time()
    assert read(tmp_path, " " * 10**6 + "t,y [N]\n0,1\n1,2\n").unit == "N"
    assert time.process_time() - began < 0.3


def made(random):
    """Return a table of a random dialect, with the keys that it needs."""
    cut, comma = random.choice([*((cut, False) for cut in ",;\t "), (";", True), ("  ", True)])
    unit = random.choice(["g", "G", "m/s2", "gal", "%g", "cm/s^2", "mg", "ft/s2"])
    heading = random.choice(["", f"t [s]{cut}a [{unit}]", f"# t (s){cut}a ({unit})"])
    text = table(heading, cut, comma, random.choice(["{:.5f}", "{:.6e}", "{:+.7f}"]))
    if random.random() < 0.3:
        text = random.choice(["# made up\n", "A title\n\n", "El Centro, 1940\n"]) + text
    if random.random() < 0.3:
        text = text.replace("\n", "\r\n")
    encoding = random.choice(["utf-8", "utf-8-sig", "utf-16", "latin-1"])
    return text.encode(encoding), {} if heading else {"unit": unit}, canonical(unit)


def broken(random, data):
    """Return bytes with some of them changed, taken away, doubled or put elsewhere."""
    data, marks = bytearray(data), [b",", b";", b"\t", b"\0", b'"', b"#", b"\x1a", b"1e400", b"("]
    for _ in range(random.randint(1, 6)):
        i, j = sorted(random.randrange(len(data) + 1) for _ in range(2))
        end, inserted = random.choice([
            (i + 1, random.randbytes(1)), (min(j, i + 40), b""), (i, random.choice(marks)),
            (i, data[i:j] * random.choice([1, 2, 30])), (j, random.randbytes(min(j - i, 9))),
        ])  # fmt: skip
        data[i:end] = inserted
    return bytes(data)


def test_a_thousand_files(tmp_path):
    """Every file is read rightly or refused in one line, within a second, and 300 MB in all."""
    draw = random.Random(49)
    seeds = [
        (PEER + "NPTS=    13, DT=   .0100 SEC\n" + rows(VALUES, 5)).encode(),
        cosmos(VALUES, STEP, channels=2).encode(), csmip(VALUES, STEP).encode(),
        smc(VALUES, 100.0).encode(), ("13 0.01\n" + rows(VALUES, 1)).encode(),
        *(text if isinstance(text, bytes) else text.encode() for text in TABLES.values()),
    ]  # fmt: skip
    before, refusals = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, []
    for i in range(1000):
        is_whole = i % 2 == 0
        data, keys, unit = made(draw)
        if not is_whole:
            data = broken(draw, draw.choice([data, *seeds]))
            keys = draw.choice([{}, {}, keys, {"dt": 0.01, "unit": "g"}, {"column": 0, "dt": 0.1}])
        began = time.process_time()
        try:
            record = read(tmp_path, data, **keys)
        except RequestError as error:
            refusals.append((is_whole, str(error)))
        else:
            assert all(map(math.isfinite, (*record.times, *record.values)))
            if is_whole:
                is_right(record, unit)
        assert time.process_time() - began < 1.0
    assert [text for is_whole, text in refusals if is_whole or "\n" in text] == []
    assert 100 < len(refusals) < 500
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 300_000
