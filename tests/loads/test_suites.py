"""Suites of records: how they are named and scaled, and that each is its own single run."""

import math
from pathlib import Path

import numpy as np
import pytest

import nlds_vines as nv
from nlds_vines.loads.result import quantile_of
from nlds_vines.model.loads.suite import size_of, suite_of

STEP = 0.02


def write_record(path, seed, count=150):
    generator = np.random.default_rng(seed)
    times = STEP * np.arange(count)
    values = generator.uniform(-1.0, 1.0, count) * np.sin(np.pi * times / times[-1])
    rows = [f"{time:.2f},{value:.6f}" for time, value in zip(times, values, strict=True)]
    path.parent.mkdir(exist_ok=True)
    path.write_text("\n".join(["time [s],acceleration [m/s^2]", *rows]) + "\n")


@pytest.fixture
def records(here):
    """Three records of different lengths in a folder."""
    for number in range(3):
        write_record(here / "records" / f"r{number}.csv", number, 150 + 20 * number)
    return [f"records/r{number}.csv" for number in range(3)]


def history(load, systems="tmd", **tables):
    return nv.load_response_history(
        systems, {"load": load, "sampling": {"duration": 4.0}, **tables}
    )


def test_a_folder_is_a_suite_in_the_order_of_names(records, here):
    for name in ("_note.csv", ".hidden", "r0.DT2", "r0.vt2"):
        (here / "records" / name).write_text("not read")
    assert [one.source for one in suite_of("records")] == ["r0.csv", "r1.csv", "r2.csv"]
    assert suite_of(records) == suite_of("records")
    shared = suite_of({"file": records, "unit": "m/s^2", "interpolation": "cubic"})
    assert [one.interpolation for one in shared] == ["cubic"] * 3


def test_records_of_one_name_are_told_apart_by_their_folders(records, here):
    write_record(here / "other" / "r0.csv", 7)
    names = [one.source for one in suite_of(["records/r0.csv", "other/r0.csv"])]
    assert names == ["records/r0.csv", "other/r0.csv"]


def test_what_is_no_suite_is_refused(records, here, error_of):
    (here / "empty").mkdir()
    assert "must be one or more records" in error_of(suite_of, [])
    assert "has no record" in error_of(suite_of, "empty")
    assert "must be paths or tables" in error_of(suite_of, 3.0)
    assert "must be the path of a record" in error_of(suite_of, {"file": [3.0]})
    assert "stands 2 times" in error_of(suite_of, [records[0], records[0]])
    assert "several files are a suite" in error_of(history, {"record": {"file": records}})
    assert "there is no record" in error_of(history, {"impulse": 1.0, "scale_to": "peak=1"})
    force = {"times": [0.0, 1.0], "values": [0.0, 1.0], "unit": "N"}
    refused = error_of(history, {"suite": [*records, force]})
    assert "beside an acceleration" not in refused  # each acts by itself


@pytest.mark.parametrize(
    ("size", "words"),
    [
        ({}, "allowed: peak, or Sa and T"),
        ({"peak": 1.0, "Sa": 1.0}, "allowed: peak, or Sa and T"),
        ({"peak": 1.0, "T": 1.0}, "T stands beside peak"),
        ({"Sa": 1.0}, "Sa needs T"),
        ({"Sa": "1 kN", "T": 1.0}, "must be an acceleration"),
        ({"Sa": 1.0, "T": 0.0}, "allowed: above 0"),
        ({"Sa": 1.0, "T": 1.0, "zeta": 1.0}, "below 1"),
        ({"peak": -1.0}, "must be > 0"),
        ({"peak": "much"}, "must be a number with a unit"),
        ({"PGA": 1.0}, "unknown key"),
    ],
)
def test_a_size_that_is_none_is_refused(size, words, error_of):
    assert words in error_of(size_of, size)


def test_records_are_scaled_to_a_peak_or_to_a_spectral_ordinate(records):
    request = history({"suite": records, "scale_to": {"peak": "0.3 g"}})
    for record in request.load.suite:
        assert max(map(abs, record.values)) == pytest.approx(0.3 * 9.80665, rel=1e-14)
        assert "to a peak of 2.94199 m/s^2" in record.reading
    assert request.load.scale_to is None
    again = nv.load_response_history(request.document())
    assert again.hash == request.hash
    request = history({"suite": records, "scale_to": "Sa=2,T=0.5,zeta=0.02"})
    for record in request.load.suite:
        spectrum = nv.response_spectrum(record, 0.02, [0.5])
        assert spectrum.pseudo_acceleration[0] == pytest.approx(2.0, rel=1e-8)  # nine digits


def test_a_size_that_a_record_cannot_have_is_refused(records, error_of):
    assert "of a record in m/s^2" in error_of(
        history, {"suite": records, "scale_to": {"peak": "3 kN"}}
    )
    zeros = {"times": [0.0, 1.0], "values": [0.0, 0.0], "unit": "g"}
    assert "all samples are 0" in error_of(history, {"record": zeros, "scale_to": {"peak": 1.0}})


def test_every_record_of_a_suite_is_checked(records, error_of, here):
    coarse = {"times": [0.0, 1.0, 2.0], "values": [0.0, 1.0, 0.0], "unit": "g"}
    error = error_of(history, {"suite": [records[0], coarse, records[1]]})
    assert "record record 2: a step of 1 s is too coarse" in error


def test_quantiles_are_those_of_numpy():
    values = np.random.default_rng(1).normal(size=11)
    for share in (0.0, 0.5, 0.84, 1.0):
        assert quantile_of(values, share) == pytest.approx(np.quantile(values, share), rel=1e-14)
    assert quantile_of(np.array([1.0, math.inf, math.inf]), 0.84) == math.inf
    assert quantile_of(np.array([1.0, 2.0, math.inf]), 0.5) == 2.0


@pytest.mark.kernels
def test_each_record_of_a_suite_has_the_bits_of_its_single_run(records, here):
    frame = nv.shear_frame([1e4] * 3, [8e6] * 3, ratio=0.02)
    walls = [nv.Wall(0.002, side, law="restitution", e=0.6) for side in "+-"]
    cell = nv.Damper("cell", "roof", m=900.0, k=5e3, c=100.0, walls=walls)
    general = nv.System.from_host(frame, [cell], name="one cell")
    for systems, of in (([general], {"of": ["roof", "roof-floor2"]}), (["tmd", "ssul-set6"], {})):
        task = {"duration": 6.0, "quiet": True, **of}
        suite = nv.response_history(systems, load="records", **task)
        assert suite.loads == ("r0.csv", "r1.csv", "r2.csv")
        for place, record in enumerate(records):
            single = nv.response_history(systems, load=record, **task)
            for number, one in enumerate(single.results.values()):
                for name, values in suite.numbers.items():
                    np.testing.assert_array_equal(values[number, place], one.numbers[name])


@pytest.mark.kernels
def test_statistics_tables_and_pictures_of_a_suite(records, here):
    suite = nv.response_history(
        ["none", "ssul-set6"], load=records, duration=4.0, to="suite.h5", quiet=True
    )
    again = nv.open_archive("suite.h5")
    assert again.statistics() == suite.statistics()
    by_name = {(one.system, one.quantity): one for one in suite.statistics()}
    one = by_name["none", "x1_max"]
    values = suite["x1_max"][0]
    assert (one.smallest, one.largest, one.records) == (values.min(), values.max(), 3)
    assert one.median == np.median(values)
    assert one.quantile_84 == pytest.approx(np.quantile(values, 0.84), rel=1e-14)
    assert ("none", "impact_count") not in by_name
    # E1 exceeds 1 % at the end of so short a run
    assert by_name["none", "last_1"].median == math.inf
    table = suite.to_dataframe("statistics")
    assert table.set_index(["system", "quantity"])["median"]["none", "x1_max"] == one.median
    assert suite.to_dataframe()["load"].tolist() == ["r0.csv", "r1.csv", "r2.csv"] * 2
    (line,) = [line for line in suite.lines() if line.startswith("x1_max [m]")]
    assert f"{one.median:.4g} ({one.quantile_84:.4g})" in line
    suite.to_csv("suite.csv")
    assert Path("suite.csv").read_text().startswith("system,quantity,unit,median,quantile_84,")
    suite.plot("x1_max,impact_count")
    suite.plot("a1_max").savefig("suite.png")


@pytest.mark.kernels
def test_a_suite_beside_axes_and_samples(records, error_of):
    task = {"load": records, "duration": 3.0, "quiet": True}
    scan = nv.response_history(["none", "tmd"], vary={"scale": [1.0, 2.0]}, **task)
    assert scan["x1_max"].shape == (2, 3, 2)
    single = nv.response_history(
        ["none", "tmd"], load=records[1], vary={"scale": [1.0, 2.0]}, duration=3.0, quiet=True
    )
    np.testing.assert_array_equal(scan["x1_max"][:, 1], single["x1_max"])
    medians = scan.over_records("x1_max")
    np.testing.assert_array_equal(medians, np.median(scan["x1_max"], axis=1))
    assert "statistics along scale" in error_of(scan.statistics)
    assert "there is no suite" in error_of(single.over_records, "x1_max")
    assert "allowed: 0 to 1" in error_of(scan.over_records, "x1_max", 1.5)
    scan.plot()
    samples = {"scale": np.array([1.0, 2.0]), "C": np.array([0.01, 0.02])}
    sampled = nv.response_history("ssul-set6", samples=samples, **task)
    assert sampled["x1_max"].shape == (1, 3, 2)
    sampled.plot()
    sampled.plot("x1_max:C")
    vary = {"scale": [1.0, 2.0], "C": [0.01, 0.02]}
    nv.response_history("ssul-set6", vary=vary, **task).plot()


@pytest.mark.kernels
def test_the_command_takes_several_records_and_a_folder(records, answer):
    words = ["response-history", "--system", "tmd", "--duration", 3, "-o", "a.h5", "--quiet"]
    answer(*words, "--load", records[0], "--load", records[1], "--scale-to", "peak=0.1g")
    assert nv.open_archive("a.h5").loads == ("r0.csv", "r1.csv")
    plan = answer(*words, "--load", "records", "--overwrite", "--dry-run")
    assert "each of 3 records" in plan
    assert "3 orbits" in plan


@pytest.mark.kernels
def test_a_tuning_judges_a_design_by_the_worst_record(records):
    small = {"population": 5, "generations": 1, "polish": 0, "optima": 1, "objective": "x1_max"}
    free = {"k2": {"low": 2000.0, "high": 2500.0}}
    tuned = nv.tune("tmd", load=records, free=free, search=small, quiet=True,
                    sampling={"duration": 4.0})  # fmt: skip
    assert tuned.request.case_count == 3
    suite = nv.response_history("tmd", load=records, set=dict(tuned.parameters), duration=4.0,
                                quiet=True)  # fmt: skip
    assert tuned.objective == suite["x1_max"].max()
