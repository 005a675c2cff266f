"""Loads in time: their Taylor coefficients against 30 digits, cells, files, refusals."""

import math
import tracemalloc

import h5py
import mpmath
import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from nlds_vines.kernels.numerics.tones import fill_tones
from nlds_vines.loads.request import FORM
from nlds_vines.model.loads import record_text
from nlds_vines.model.loads.courses import TERMS, Sweep
from nlds_vines.model.loads.loading import Loading, Struck

STRUCK = Struck(mass=1000.0)


def loading_of(table):
    """Return the load that a table `[load]`, or the path of a record, means."""
    load = {"record": table} if isinstance(table, str) else table
    return Loading(**FORM.read({"load": load}, {}, "a test").of(Loading))


def cells_of(table, duration=3.0, reach=0.1, marks=(), struck=STRUCK):
    return loading_of(table).cells(struck, duration, reach, np.array(marks, float))


def force(cells, times):
    """Return the force on m1 (m,) [N] at times (m,) within the cells, by Horner's rule."""
    j = np.clip(np.searchsorted(cells.edges, times, side="right") - 1, 0, len(cells.rows) - 1)
    x = (times - cells.edges[j]) / np.diff(cells.edges)[j]
    return np.polynomial.polynomial.polyval(x, cells.rows[j].T, tensor=False)


def taylor(f, begin, length):
    """Return the coefficients of f(begin + length x), x from 0 to 1, from 40 digits."""
    with mpmath.workdps(60):
        a, h = mpmath.mpf(float(begin)), mpmath.mpf(float(length))
        return [float(c) for c in mpmath.taylor(lambda x: f(a + h * x), 0, TERMS - 1)]


TURNS = [int(raw) >> 11 for raw in np.random.PCG64(3).random_raw(20)]  # in units of 2^-53


def noise(t):
    """Return noise as `Noise` says that it is: rms 2, seed 3, 20 tones from 2 to 20 rad/s."""
    tones = (
        mpmath.cos((2 + (i + mpmath.mpf(0.5)) * 18 / 20) * t + 2 * mpmath.pi * turn / 2**53)
        for i, turn in enumerate(TURNS)
    )
    return 2 * mpmath.sqrt(mpmath.mpf(2) / 20) * mpmath.fsum(tones)


def logarithmic(t):
    ratio = mpmath.log(mpmath.mpf(2))
    return 7 * mpmath.sin(5 * 8 / ratio * (mpmath.exp(ratio * t / 8) - 1))


LOGARITHMIC = {"amplitude": 7.0, "first": 5.0, "last": 10.0, "length": 8.0,
               "spacing": "logarithmic"}  # fmt: skip

CASES = {
    "half_sine": (
        {"peak": 5.0, "length": 0.4, "at": 0.25},
        lambda t: 5 * mpmath.sin(mpmath.pi * (t - 0.25) / mpmath.mpf(0.4)),
        (0.25, 0.65),
    ),
    "rectangular": ({"peak": -2.0, "length": 0.4}, lambda t: mpmath.mpf(-2), (0.0, 0.4)),
    "triangular": (
        {"peak": 3.0, "length": 0.5, "at": 1.0, "rise": 0.0},
        lambda t: 3 * (1 - (t - 1) / mpmath.mpf(0.5)),
        (1.0, 1.5),
    ),
    "friedlander": (
        {"peak": 1e5, "length": 0.25, "decay": 1.5, "suction": True},
        lambda t: 10**5 * (1 - 4 * t) * mpmath.exp(-6 * t),
        (0.0, 3.0),
    ),
    "tone": (
        {"amplitude": 800.0, "omega": 6.28, "phase": 0.5},
        lambda t: 800 * mpmath.cos(mpmath.mpf(6.28) * t + 0.5),
        (0.0, 3.0),
    ),
    "sweep": (
        {"amplitude": 7.0, "first": 8.0, "last": 5.0, "length": 2.0, "at": 0.5},
        lambda t: 7 * mpmath.sin(8 * (t - 0.5) - mpmath.mpf(3) / 4 * (t - 0.5) ** 2),
        (0.5, 2.5),
    ),
    "sweep, logarithmic": (LOGARITHMIC, logarithmic, (0.0, 3.0)),
    "noise": ({"rms": 2.0, "low": 2.0, "high": 20.0, "seed": 3, "tones": 20}, noise, (0.0, 3.0)),
}


@pytest.mark.parametrize("kind", CASES)
def test_rows_are_the_taylor_coefficients_and_leave_out_round_off(kind):
    table, exact, (begin, end) = CASES[kind]
    cells = cells_of({kind.partition(",")[0]: table})
    lengths, size = np.diff(cells.edges), np.abs(cells.rows).max()
    inside = (cells.edges[:-1] > begin - 1e-9) & (cells.edges[1:] < end + 1e-9)
    assert inside.sum() >= 4
    for j in np.flatnonzero(inside)[:: max(1, inside.sum() // 7)]:
        wanted = taylor(exact, cells.edges[j], lengths[j])
        np.testing.assert_allclose(cells.rows[j], wanted, rtol=0, atol=4e-15 * size)
    assert (cells.rows[~inside] == 0).all()
    # at the end of each cell the polynomial is the function there, and so the next row's
    cells = cells_of({kind.partition(",")[0]: table}, reach=1.0)
    for j in np.flatnonzero((cells.edges[:-1] >= begin) & (cells.edges[1:] <= end))[::5]:
        with mpmath.workdps(40):
            wanted = float(exact(mpmath.mpf(float(cells.edges[j + 1]))))
        size = np.abs(cells.rows).max()
        assert cells.rows[j].sum() == pytest.approx(wanted, abs=2e-14 * size)


@pytest.mark.parametrize(
    ("first", "last", "length"),
    [(6.28, 6.28 * (1 + 1e-9), 60.0), (7.1, 7.101, 12000.0), (1.0, 20.0, 60.0), (20.0, 1.0, 60.0)],
)
def test_a_logarithmic_sweep_is_sharp_for_any_ratio_of_its_ends(first, last, length):
    """The error is round-off of the phase, 3e-16 of it, for nearly equal ends, too."""
    sweep = Sweep(amplitude=1.0, first=first, last=last, length=length, spacing="logarithmic")
    omegas = sweep.omegas(length * np.array([0.0, 0.5, 1.0, 1.1]))
    np.testing.assert_allclose(omegas, [first, math.sqrt(first * last), last, math.nan])
    times = np.linspace(0.0, length, 97)[:-1]
    with mpmath.workdps(40):
        ratio = mpmath.log(mpmath.mpf(last) / first)

        def exact(t):
            return mpmath.sin(first * length / ratio * mpmath.expm1(ratio * mpmath.mpf(t) / length))

        for place in (0.0, 0.8):
            rows = sweep.rows(times, np.full(96, 0.02))
            wanted = [float(exact(t + 0.02 * place)) for t in times]
            off = np.abs(rows @ place ** np.arange(15) - wanted).max()
            assert off < 3e-16 * length * max(first, last) + 1e-15


def test_far_from_the_start_a_tone_has_lost_nothing():
    cells = cells_of({"tone": {"amplitude": 1.0, "omega": 9.7}}, duration=20000.0, reach=1.0)
    with mpmath.workdps(40):
        w = mpmath.mpf(9.7 / (2 * math.pi)) * 2 * mpmath.pi
        wanted = [float(mpmath.cos(w * mpmath.mpf(float(t)))) for t in cells.edges[-50:-1]]
    np.testing.assert_allclose(cells.rows[-49:, 0], wanted, rtol=0, atol=1e-15)


def test_pulses_repeat():
    table = {"half_sine": {"peak": 1.0, "length": 0.1, "at": 0.2, "repeat": 3, "every": 0.5}}
    cells = cells_of(table)
    times = np.linspace(0.0, 2.99, 997)
    since = np.where(times >= 0.2, (times - 0.2) % 0.5, 1.0)
    wanted = np.where((since < 0.1) & (times < 1.5), np.sin(10 * math.pi * since), 0.0)
    np.testing.assert_allclose(force(cells, times), wanted, rtol=0, atol=1e-13)


def test_cells_are_cut_at_kinks_and_marks_and_are_no_longer_than_the_reach():
    pulse, blow = {"peak": 1.0, "length": 0.123456}, {"impulse": 3.0, "at": 0.7}
    cells = cells_of({"rectangular": pulse, "blow": blow}, marks=(0.5, 0.123456 + 1e-17))
    assert {0.0, 0.123456, 0.5, 0.7, 3.0} <= set(cells.edges)
    assert np.diff(cells.edges).max() <= 0.1 * (1 + 1e-12)
    assert np.diff(cells.edges).min() > 0.01
    (place,) = np.flatnonzero(cells.jumps)
    assert (cells.edges[place], cells.jumps[place]) == (0.7, 3.0 / 1000.0)


def test_the_ground_s_acceleration_pushes_all_masses_backwards():
    cells = cells_of({"rectangular": {"peak": 0.5, "length": 1.0, "unit": "g"}, "scale": 2.0})
    assert cells.share == 0.0
    assert force(cells, np.array([0.5]))[0] == -1000.0 * 9.80665
    assert cells_of({"impulse": 1.0}).share == 1.0


def test_sums_and_the_harmonic_force():
    table = {"harmonic": True, "scale": 3.0, "rectangular": [{"peak": 1.0, "length": 2.0}] * 2}
    cells = cells_of(table, struck=Struck(1.0, 800.0, 6.28))
    times = np.array([0.3, 1.7, 2.6])
    wanted = 800.0 * np.cos(6.28 * times) + 6.0 * (times < 2.0)
    np.testing.assert_allclose(force(cells, times), wanted, rtol=0, atol=1e-12)
    assert loading_of(loading_of(table).to_table()) == loading_of(table)
    still = cells_of({**table, "scale": 0.0}, struck=Struck(1.0, 800.0, 6.28))
    np.testing.assert_allclose(force(still, times), 800.0 * np.cos(6.28 * times), atol=1e-12)


def test_numbers_of_a_load_can_be_changed(error_of):
    loading = loading_of({"impulse": 4.0, "friedlander": {"peak": 5.0, "length": 0.2}})
    changed = loading.with_({"impulse": 2.0, "friedlander.peak": 7.0})
    assert (changed.impulse, changed.friedlander[0].peak) == (2.0, 7.0)
    for name in ("shape", "friedlander.size", "tone.omega", "nothing.peak"):
        assert name.partition(".")[0] in error_of(loading.with_, {name: 1.0})


def test_as_many_tones_as_are_allowed_have_room_of_their_own():
    frequencies, phases = np.linspace(0.1, 3.0, 100_000), np.linspace(0.0, 0.99, 100_000)
    begins, rows = 0.02 * np.arange(3), np.empty((3, TERMS))
    fill_tones(frequencies, phases, begins, np.full(3, 0.02), rows)
    wanted = np.cos(2 * np.pi * (np.outer(begins, frequencies) + phases)).sum(axis=1)
    assert rows[:, 0] == pytest.approx(wanted, abs=1e-9)


def test_tones_are_as_sharp_after_a_long_time():
    """In cells of one length, and of others in between, beside cosines of 30 digits."""
    frequencies, phases = np.array([0.37, 4.1, 6.3]), np.array([0.1, 0.5, 0.93])
    edges = 1e5 + np.concatenate([0.01 * np.arange(70), 0.7 + 0.007 * np.arange(1, 50)])
    rows = np.empty((len(edges) - 1, TERMS))
    fill_tones(frequencies, phases, edges[:-1].copy(), np.diff(edges), rows)
    with mpmath.workdps(30):
        wanted = [
            float(sum(
                mpmath.cos(2 * mpmath.pi * (mpmath.mpf(f) * mpmath.mpf(t) + mpmath.mpf(p)))
                for f, p in zip(frequencies.tolist(), phases.tolist(), strict=True)
            ))
            for t in edges.tolist()
        ]  # fmt: skip
    drift = 8 * np.spacing(1e5) * 2 * np.pi * frequencies.sum()  # ends of cells are rounded
    np.testing.assert_allclose(rows[:, 0], wanted[:-1], rtol=0, atol=3e-14 + drift)
    np.testing.assert_allclose(rows.sum(axis=1), wanted[1:], rtol=0, atol=3e-14 + drift)


def saved(tmp_path, text, name="quake.csv"):
    (tmp_path / name).write_text(text)
    return str(tmp_path / name)


SAMPLES = "time [s], acceleration [g]\n0.0, 0.0\n0.1, 0.3\n0.2, -0.2\n0.3, 0.1\n0.4, 0.05\n"


def test_lines_and_splines_between_samples(tmp_path):
    loading = loading_of(saved(tmp_path, SAMPLES))
    cells = loading.cells(STRUCK, 1.0, 0.03, np.zeros(0))
    times = np.linspace(0.0, 0.999, 200)
    wanted = np.interp(times, [0, 0.1, 0.2, 0.3, 0.4], [0, 0.3, -0.2, 0.1, 0.05], right=0.0)
    np.testing.assert_allclose(force(cells, times), -9806.65 * wanted, rtol=0, atol=1e-11)
    assert loading.record[0].source == "quake.csv"
    assert loading_of(loading.to_table()) == loading  # which needs the file no more
    # a spline between samples
    path = saved(tmp_path, SAMPLES.replace(",", ";"))
    cells = cells_of({"record": {"file": path, "interpolation": "cubic", "at": 0.5}}, 1.0, 0.03)
    spline = CubicSpline([0, 0.1, 0.2, 0.3, 0.4], [0, 0.3, -0.2, 0.1, 0.05], bc_type="natural")
    times = np.linspace(0.5, 0.8999, 200)
    np.testing.assert_allclose(force(cells, times), -9806.65 * spline(times - 0.5),
                               rtol=0, atol=1e-10)  # fmt: skip
    assert (force(cells, np.array([0.1, 0.95])) == 0.0).all()


def test_a_line_says_how_much_of_a_record_acts(tmp_path):
    later = "t [s], a [g]\n10, 0\n10.1, 0.3\n10.2, -0.4\n10.3, 0\n10.4, 0\n"
    (whole,) = loading_of(saved(tmp_path, SAMPLES)).records_in_words(60.0)
    (moved,) = loading_of(saved(tmp_path, later, "late.csv")).records_in_words(0.1)
    facts = "record quake.csv, 5 samples, step 0.1 s, 0.4 s, peak 0.3 g at 0.1 s"
    assert whole == facts
    used = "0.4 s, of which 0.1 s are computed, peak 0.4 g at 0.2 s, moved from 10 s to 0 s"
    assert moved.endswith(used)
    uneven = {"times": [1, 2, 4], "values": [0, 1, 0], "uneven": True, "at": 5.0}
    (line,) = loading_of({"record": uneven}).records_in_words(4.0)
    facts = "record, 3 samples, steps 1 to 2 s, 3 s, of which 0 s are computed, peak 1 N at 1 s"
    assert line == f"{facts}, moved from 1 s to 5 s"


def hdf5(tmp_path, **datasets):
    """Write datasets, arrays or the settings of h5py's `create_dataset`; return the path."""
    with h5py.File(tmp_path / "quake.h5", "w") as file:
        for name, values in datasets.items():
            settings = values if isinstance(values, dict) else {"data": np.array(values)}
            file.create_dataset(name, **settings)
    return {"record": {"file": str(tmp_path / "quake.h5"), "unit": "g"}}


HUGE = {"shape": 10**9, "chunks": 10**6, "dtype": "f8"}  # zeros: 8 GB of memory, 1 kB of the disk


def test_of_a_large_file_the_chosen_columns_alone_are_read(tmp_path, error_of):
    stamps, values = [0.0, 0.1, 0.2], [0.0, 1.0, 0.0]
    tracemalloc.start()
    record = loading_of(hdf5(tmp_path, time=stamps, up=values, west=HUGE)).record[0]
    assert record.values == (0.0, 1.0, 0.0)
    huge = hdf5(tmp_path, t=stamps, up=HUGE)
    assert "'up' holds 1000000000 numbers" in error_of(loading_of, huge)
    chunk = {"data": np.array(values), "chunks": (10**7,), "maxshape": (None,)}
    assert "'up' holds 10000000" in error_of(loading_of, hdf5(tmp_path, t=stamps, up=chunk))
    assert tracemalloc.get_traced_memory()[1] < 1e7
    tracemalloc.stop()


def test_the_time_is_named_or_ascends_alone(tmp_path, error_of):
    """h5py sorts datasets by name."""
    stamps, up, west = [0.0, 0.1, 0.2], [0.0, 1.0, 0.0], [2.0, 1.0, 3.0]
    table = hdf5(tmp_path, acc=up, stamps=stamps)
    with h5py.File(tmp_path / "quake.h5", "a") as file:
        file["acc"].attrs["units"] = "m/s^2"
    record = loading_of(table["record"]["file"]).record[0]
    assert (record.times, record.values) == (tuple(stamps), tuple(up))
    assert record.unit == "m/s^2"
    assert "unit = 'g', but the file states 'm/s^2' of column acc" in error_of(loading_of, table)
    assert loading_of(hdf5(tmp_path, acc=stamps, time=stamps)).record[0].values == tuple(stamps)
    for columns in ({"acc": up, "stamps": west}, {"acc": stamps, "stamps": stamps}):
        assert "`time`" in error_of(loading_of, hdf5(tmp_path, **columns))


def test_a_heading_is_no_sample(tmp_path, monkeypatch, error_of):
    monkeypatch.setattr(record_text, "MOST_SAMPLES", 4)
    four = "t, y [N]\n0, 1\n1, 2\n2, 1\n3, 0\n"
    assert len(loading_of(saved(tmp_path, four)).record[0].times) == 4
    assert "more than 4 samples" in error_of(loading_of, saved(tmp_path, four + "4, 0\n"))


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ({"shape": 1.0}, ["shape", "half_sine"]),
        ({"record": "nowhere.csv"}, ["nowhere.csv", "No such file"]),
        ({"record": {"file": "a.csv", "values": [1.0]}}, ["values", "beside"]),
        ({"record": {"times": [0.0, 1.0], "values": [0.0, 1.0, 2.0]}}, ["2 times for 3"]),
        ({"record": 3.0}, ["record", "table"]),
        ({"impulse": math.nan}, ["impulse", "nan"]),
        ({"half_sine": {"peak": 1.0}}, ["length", "missing"]),
        ({"half_sine": {"peak": 0.0, "length": 1.0}}, ["peak", "0"]),
        ({"half_sine": {"peak": 1.0, "length": 1.0, "repeat": 2}}, ["every", "at least"]),
        ({"friedlander": {"peak": 1.0, "length": 1.0, "suction": 1}}, ["suction", "true"]),
        ({"noise": {"rms": 1.0, "high": 1.0, "low": 2.0}}, ["high", "low"]),
        ({"blow": {"impulse": 1.0, "repeat": 2}}, ["every"]),
        ({"tone": {"amplitude": 1.0, "omega": 1.0, "unit": "g"}, "impulse": 1.0},
         ["impulse", "ground"]),
        ({"tone": [{"amplitude": 1.0, "omega": 1.0, "unit": unit} for unit in ("g", "N")]},
         ["tone", "'N'", "ground"]),
        ({"scale": "x", "impulse": 1.0}, ["scale", "x"]),
        ({"tone": {"amplitude": 1.0, "omega": 1.0, "scale": 2.0}}, ["tone", "--vary scale"]),
        ({"record": {"file": "a.csv", "scale": 2.0}}, ["scale belongs in [load]", "--vary scale"]),
        ({"half_sine": {"peak": 1.0, "length": 1.0, "impulse": 2.0}}, ["--impulse"]),
    ],
)  # fmt: skip
def test_faulty_loads_get_one_line(table, words, error_of):
    message = error_of(loading_of, table)
    assert all(word in message for word in words), message


def test_noise_must_not_repeat_itself_records_be_fine_enough_and_cells_few(tmp_path, error_of):
    loading = loading_of(saved(tmp_path, SAMPLES))
    loading.check(9.0, 1.0)
    line = error_of(loading.check, 9.0, 0.5)
    assert "0.1 s is too coarse" in line
    assert "0.5 s; allowed: up to 0.05 s" in line
    # noise must not repeat itself
    loading = loading_of({"noise": {"rms": 1.0, "low": 2.0, "high": 22.0, "tones": 100}})
    loading.check(31.0, 1.0)
    line = error_of(loading.check, 32.0, 1.0)
    assert "100 tones repeats itself after 31.4159 s of 32 s" in line
    # too many cells are refused
    fast = {"tone": {"amplitude": 1.0, "omega": 1e6}}
    assert "cells" in error_of(cells_of, fast, duration=60.0)
