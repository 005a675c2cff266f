"""Records by the headers of real networks, with numbers of our own.

The headers are facts: their words, order and columns are those of files that the networks
distribute.  The values are drawn, written as counts or decimals by the test, and what must come
back is worked out here from what was written.
"""

import gzip
import random
from fractions import Fraction

import h5py
import numpy as np
import pytest

import nlds_vines as nv
from nlds_vines.model.loads.formats import FORMATS
from nlds_vines.model.loads.record import Record

DRAW = random.Random(17)
COUNTS = [DRAW.randint(6000, 8000) for _ in range(200)]  # 1 s at 200 Hz, 2 s at 100 Hz
VALUES = [round(DRAW.uniform(-300.0, 300.0), 3) for _ in range(200)]
OTHERS = [round(DRAW.uniform(-300.0, 300.0), 3) for _ in range(200)]
THIRD = [round(DRAW.uniform(-300.0, 300.0), 3) for _ in range(200)]


def rows(values, per_line, form):
    cells = [form.format(value) for value in values]
    lines = ["".join(cells[i : i + per_line]) for i in range(0, len(cells), per_line)]
    return "\n".join(lines) + "\n"


def kik_net(rate, scale, direction, name):
    seconds = len(COUNTS) // rate
    header = f"""\
Origin Time       2000/10/06 13:30:00
Lat.              35.278
Long.             133.345
Depth. (km)       11
Mag.              7.3
Station Code      {name}
Station Lat.      34.9319
Station Long.     137.0568
Station Height(m) 5
Record Time       2000/10/06 13:31:24
Sampling Freq(Hz) {rate}Hz
Duration Time(s)  {seconds}
Dir.              {direction}
Scale Factor      {scale}
Max. Acc. (gal)   3.896
Last Correction   2000/10/06 13:00:00
Memo.{" " * 13}
"""
    return header + rows(COUNTS, 8, "{:9d}")


def centered(numerator, denominator):
    """Return counts less their mean, in gal, by exact arithmetic."""
    mean = Fraction(sum(COUNTS), len(COUNTS))
    return [float((count - mean) * Fraction(numerator, denominator)) for count in COUNTS]


def esm(stream, first, kind="ACCELERATION", unit="cm/s^2", interval="0.005000", count="200"):
    return f"""\
EVENT_NAME: GREECE
EVENT_ID: EMSC-20190728_0000106
EVENT_DATE_YYYYMMDD: 20190728
EVENT_TIME_HHMMSS: 160908
EVENT_DEPTH_KM: 9.0
MAGNITUDE_W:{" "}
NETWORK: HI
STATION_CODE: ARS1
STATION_NAME: Town Hall,Argos,Argolis,Peloponnese
STATION_ELEVATION_M: 34
LOCATION:{" "}
VS30_M/S:{" "}
DATE_TIME_FIRST_SAMPLE_YYYYMMDD_HHMMSS: {first}
DATE_TIME_FIRST_SAMPLE_PRECISION: milliseconds
SAMPLING_INTERVAL_S: {interval}
NDATA: {count}
DURATION_S: 1.000
STREAM: {stream}
UNITS: {unit}
INSTRUMENT_ANALOG/DIGITAL: D
PGA_CM/S^2: 0.300022
BASELINE_CORRECTION: BASELINE REMOVED
FILTER_ORDER: 2
DATABASE_VERSION: DYNA 1.0
HEADER_FORMAT: DYNA 1.2
DATA_TYPE: {kind}
PROCESSING: manual (Paolucci et al., 2011)
ORIGINAL_DATA_MEDIATOR: http://eida.gein.noa.gr/
USER1: --le 0.100 --he 30.000
USER2:{" "}
USER5:{" "}
""" + rows(VALUES, 1, "{:.6f}")


def in_columns(form, *columns):
    lines = ["".join(form.format(value) for value in row) for row in zip(*columns, strict=True)]
    return "\n".join(lines) + "\n"


AFAD = """\
STRONG GROUND MOTION RECORDS OF TURKIYE
PLACE                   : AYDN GERMENCIK DEVLET HASTANESI
EARTHQUAKE DATE         : 2017/07/20 22:31:09 (GMT)
EPICENTER COORDINATES   : 36.91980N-27.44350E
EARTHQUAKE DEPTH (km)   : 19.44
EARTHQUAKE MAGNITUDE    : 6.5 Mw
STATION ID              : 0921
STATION ALTITUDE (m)    : 66
RECORDER TYPE           : Sara acebox
RECORD TIME             : 20/07/2017 22:30:58.000000 (GMT)
NUMBER OF DATA          : 200
SAMPLING INTERVAL (sec) : 0.01
RAW PGA VALUES (gal)    : (N-S) 13.200332 (E-W) 12.163827 (U-D) 9.840572
Copyright EARTHQUAKE DEPARTMENT
DISASTER AND EMERGENCY MANAGEMENT PRESIDENCY
       N-S          E-W          U-D
""" + in_columns("{:14.6f}", VALUES, OTHERS, THIRD)

CSMNC = """\
051BXD130420080201
0130420080246 2013-04-20 8:2:46 BTM
LUSHAN EARTHQUAKE, LUSHAN,CHN
EPICENTER  30.300N 103.000E DEPTH 13 KM
MAGNITUDE  7.0(Ms)
STATION: 51BXD 30.400N 102.800E
SITE CONDITION: ROCK
INSTRUMENT TYPE: MR2002/SLJ-100
OBSERVING POINT: GROUND
COMP. EW
UNCORRECTED ACCELERATION          UNIT: CM/SEC/SEC
NO. OF POINTS:  200  EQUALLY SPACED INTERVALS OF:  0.005  SEC
PEAK VALUE:    -1005.350   AT   26.35 SEC    DURATION:  60 SEC
PRE-EVENT TIME:  20  SEC
CSMNC

""" + rows(VALUES, 8, "{:13.6E} ")

UNAM = """\
**************************************************************************************
                       INSTITUTO DE INGENIERIA, UNAM
 Tel.(52-5)622-3414    Fax.(52-5)616-1514    e-mail: isismica@pumas.iingen.unam.mx
**************************************************************************************
ARCHIVO ESTANDAR DE ACELERACION:
VERSION DEL FORMATO                    : 2.0
NOMBRE DEL ARCHIVO                     : ACAC1709.191
================================================================================
DATOS DE LA ESTACION:
CLAVE DE LA ESTACION                   : ACAC
                                       : Ingenieria, UNAM, Cd. Universitaria,
ALTITUD (msnm)                         : 2240
================================================================================
DATOS DEL ACELEROGRAFO:
NUMERO DE CANALES                      : 3
ORIENTACION C1-C6 (rumbo;orientacion)  : /V/N00E/N90E
ORIENTACION C7-C12 (rumbo;orientacion) :
VEL. DE MUESTREO, C1-C6 (muestras/s)   : /200/200/200
ESC. COMPLETA DE SENSORES, C1-C6, (g)  : /4/4/4
INTERVALO DE MUESTREO, C1-C6 (s)       : /0.005/0.005/0.005
INTERVALO DE MUESTREO, C7-C12 (s)      :
================================================================================
DATOS DE ESTE REGISTRO:
DURACION DEL REGISTRO (s), C1-C6       : /1.00/1.00/1.00
NUM. TOTAL DE MUESTRAS, C1-C6          : /200/200/200
NUM. TOTAL DE MUESTRAS, C7-C12         :
ACEL. MAX.(Gal), C1-C6                 : /25.6114/58.7394/-42.3377
UNIDADES DE LOS DATOS                  : Gal (cm/s/s)
FACTOR DE DECIMACION                   : 1
FORMATO DATOS (FORTRAN,10 campos/dato) : 3F10.4
================================================================================
CALIDAD DEL ACELEROGRAMA:
REGISTRO DIGITAL COMPLETO CON TIEMPO ABSOLUTO CORRECTO
================================================================================
DATOS DE ACELERACION:
---------+---------+---------+---------+---------+---------+---------+---------+
   CANAL-1   CANAL-2   CANAL-3
         V      N00E      N90E
---------+---------+---------+---------+---------+---------+---------+---------+
"""

CWB = """\
#Earthquake Information
#Origin Time(GMT+08): 2018/02/06-23:50:42
#EpicenterLongitude(E): 121.69
#Depth(km): 10.0
#Magnitude(Ml): 6.0

#Station Information
#StationCode: EAS
#StationLongitude(E): 120.857
#InstrumentKind: FBA
#StartTime(GMT+08): 2018/02/06-23:50:29.000
#RecordLength(sec): 4
#SampleRate(Hz): 50
#AmplitudeUnit:  gal. DCoffset(corr)
#AmplitudeMAX. U:    0.658~   -0.837
#DataSequence: Time U(+); N(+); E(+)
#Data: 4F10.3
"""


def volume_1(channels, network="", per_line=5):
    """Return a volume of times and values that touch, in G/10, as CDMG and RENADIC write it."""
    text = ""
    for number, (name, values) in enumerate(channels.items(), 1):
        text += f"""\
UNCORRECTED ACCELEROGRAM DATA              PROCESSED: 06/30/2011
0911131
11/12/2009 23:09:53 (GMT)               (ORIGIN: 11/12/2009 23:09:53 GMT)
                                   TRIGGER TIME: 11/12/2009 23:10:03.000 GMT
STATION NO.          0.000N    0.000E  QDR       S/N  673 (3  CHNS OF 3  AT STA)
QDR S/N 673
CHAN  {number}: {name}       (STA CHN:  {number})
{network or "BIG BEAR EARTHQUAKE     JUNE 28, 1992 08:05 PDT"}
HYPOCENTER:   0.000N    0.000E  H=   0.0KM   ML= 0.00
INSTR PERIOD = 0.0391 SEC,  DAMPING =0.7000,  SENSITIVITY =1.250 VDC/G
NO. OF POINTS =   {len(values)}  RECORD LENGTH = 2.000 SEC
UNITS OF UNCOR ACCEL ARE SEC AND G/10.     MAX  = -0.051 G, AT   3.910 SEC
RMS ACCEL OF COMPLETE RECORD = 0.010 G
"""
        text += rows([7] * 100, 16, "{:5d}") + rows([0.5] * 50, 8, "{:10.3f}")
        pairs = [x for i, value in enumerate(values) for x in (0.01 * i, value)]
        text += rows(pairs, 2 * per_line, "{:7.3f}")
        text += f"/&  ----------  END OF DATA FOR CHANNEL {number}  ----------\n"
    return text


def geonet(corrected, scale="1.00"):
    text = ""
    for name, values in (("N10E", VALUES), ("N80W", OTHERS), ("Up", THIRD)):
        word = "Corrected" if corrected else "Uncorrected"
        sampling = (
            "Instrument corrected data at 0.020 sec intervals\n"
            "Band-pass filter transition bands are .10-.25 Hz and 24.50-25.50 Hz\n"
            if corrected
            else f"Raw readings in units of {scale} mm/s/s  at intervals of 0.005 s\n"
            "Data is unfiltered\n"
        )
        text += f"""\
{word} accelerogram 20161113_110256_HSES_20 GNS Science
Site HSES      42 31 24S  172 49 50E     Basalt file:  20161113_110300_HSES
Hanmer Springs Emergency Centre
Instrument Basalt_2430
Resolution: 24-bit   Instr Period: 0.0050 s   Damping: 0.700
Accelerogram 20161113_110256_HSES_20                 Processed 2016 December 09
5 km south-west of Waiau
2016 November 13         11:02:56 UT
Epicentre  42 41 33S 173 01 19E  Bearing S40E  Dist   25km  Depth   15km Mw 7.82
Number of points    200    Duration {4.0 if corrected else 1.0:.2f} s
{sampling}Component {name}
Acceleration:  Peak   2394.8 mm/s/s at  48.13 s     RMS   209.89 mm/s/s
Velocity record unevaluated
Displacement record unevaluated
"""
        text += rows([65536] * 40, 10, "{:8d}") + rows([9806.6] * 60, 10, "{:8.1f}")
        text += rows(values, 10, "{:8.3f}")
        if corrected:  # velocities and displacements
            text += rows([1.0] * 400, 10, "{:8.2f}")
    return text


PEER = """\
PEER NGA STRONG MOTION DATABASE RECORD
Loma Prieta, 10/18/1989, Gilroy - Gavilan Coll., 67
ACCELERATION TIME SERIES IN UNITS OF G
NPTS=    200, DT=   .0050 SEC,
""" + rows(VALUES, 5, "{:15.7E}")

CGS = "Corrected accelerogram   89146-L2500-12044.02      Chan  {n}: {name}     from   \n"
CGS += "Uncorrected Accelerogram Data             Processed: 02/13/12, CGS  146be002    \n"
CGS += "No. of Points =  13200  Record Length = 66.000 sec   at 200 Samples/sec         \n"
CGS += "Chan  {n}: {name}                                                               \n"


def csmip(form, width):
    text = ""
    for n, (name, values) in enumerate((("360 Deg", VALUES), (" Up", OTHERS)), 1):
        text += CGS.format(n=n, name=name) + rows([7] * 100, 16, "{:5d}")
        text += rows([-999.0] * 100, 8, "{:10.5f}") + form + rows(values, 8, f"{{:{width}.5f}}")
        text += "  200 points of veloc data equally spaced at  .005 sec, in cm/sec.  (8f10.7)\n"
        text += rows([9.0] * 200, 8, "{:10.7f}") + f"/&  --- End of data for channel {n}  ---\n"
    return text


CSMIP = "  200 points of accel data equally spaced at  .005 sec, in cm/sec2. (8f10.5)    \n"
CDMG = "  200 POINTS OF ACCEL DATA EQUALLY SPACED AT  .005 SEC.  (UNITS: CM/SEC/SEC)\n"
USC = "  200 POINTS OF ACC DATA EQUALLY SPACED AT   .005 SEC.  IN UNITS CM/SEC/SEC\n"
VOLUME_1 = "  200 Accelerogram points at 200 pts/sec in units of g .      Format: (8f10.5)  \n"


def cosmos(data, kind="Corrected acceleration "):
    reals = [-999.0] * 100
    reals[33], reals[61] = 0.005, 5.0
    text = ""
    for name, values in (("360 deg", VALUES), ("Up", OTHERS)):
        text += f"{kind}  (Format v01.20 with 13 text lines) Src: made up\n"
        text += f"Sta Chan   1: {name} (Rcrdr Chan  ?) Location:Basement NW corner\n"
        text += " 100 Integer-header values follow on  10 lines, Format= (10I8)\n"
        text += rows([-999] * 100, 10, "{:8d}")
        text += " 100 Real-header values follow on  17 lines, Format= (6F13.6)\n"
        text += rows(reals, 6, "{:13.6f}")
        text += '   1 Comment line(s) follow, each starting with a "|":\n| RcrdId: NC.73177305.NP\n'
        text += f"     200 {data}\n" + rows(values, 8, "{:10.5f}")
        text += "End-of-data for ChanHNE acceleration\n"
    return text


COSMOS = "acceleration pts, approx    1 secs, units=cm/sec2(04),Format=(8F10.5)"


def smc(title, rate, numbers, per_line, form):
    integers, reals = [-32768] * 48, [1.7e38] * 50
    integers[15], integers[16], reals[1] = 2, len(numbers), rate
    text = f"{title}\n*\nA020A\n     1989  10  18    0004 Loma Prieta, CA\n"
    text += "Moment Mag=      7.1 Ms=      7.1 Ml=      7.0\n"
    text += "station = APEEL Array #2 - Redwood City  component=    133\n"
    text += "epicentral dist =     63.0       pk acc =   -228.4\n" + "*\n" * 4
    text += rows(integers, 8, "{:10d}") + rows(reals, 5, "{:15.7E}") + "|ref - A.G. Brady\n|\n"
    return text + rows(numbers, per_line, form)


UP = {"N80W": OTHERS, "Up": THIRD}
WEST = [round(value / 1000.0, 3) for value in OTHERS]
TENTHS = [round(value / 1000.0, 3) for value in VALUES]  # of g/10, three decimals in 7 characters
PAIRS = [x for i, value in enumerate(VALUES) for x in (float(f"{0.005 * i:.3e}"), value)]
MILLI = [float(f"{value:.3e}") for value in VALUES]

# name, file, its text, what is read by default: unit, step [s], values, words; others by component
FILES = [
    ("KiK-net", "AICH04.EW2", kik_net(200, "2000(gal)/8388608", "5", "AICH04"),
     "gal", 0.005, centered(2000, 8388608), "component E-W, surface", {}),
    ("KiK-net, borehole", "NGNH31.EW1", kik_net(100, "2940(gal)/6170270", "2", "NGNH31"),
     "gal", 0.01, centered(2940, 6170270), "component E-W, borehole", {}),
    ("K-NET", "AOM001.EW", kik_net(100, "3920(gal)/6182761", "E-W", "AOM001"),
     "gal", 0.01, centered(3920, 6182761), "counts times 3920/6182761", {}),
    ("ESM", "HI.ARS1..HNE.ASC", esm("HNE", "20190728_160919.870"),
     "cm/s^2", 0.005, VALUES, "component HNE", {}),
    ("ITACA", "19971014_152309ITDPC_NCR__WEX.DAT",
     esm("HNE", "", "UNPROCESSED ACCELERATION").replace("STREAM: HNE", "COMPONENT: WE"),
     "cm/s^2", 0.005, VALUES, "component WE", {}),
    ("AFAD, new", "2010_3104.asc", esm("HNN", "14/11/2010 23:09:19.300", "Acceleration",
                                       interval="0.005", count=""),
     "cm/s^2", 0.005, VALUES, "ESM, ITACA or AFAD", {}),
    ("AFAD, old", "20170720_0921.txt", AFAD, "gal", 0.01, VALUES, "column N-S, not in column E-W",
     {"E-W": OTHERS, "u-d": THIRD, 2: OTHERS}),
    ("CSMNC", "051BXD.dat", CSMNC, "cm/s^2", 0.005, VALUES, "component EW", {}),
    ("UNAM", "ACAC1709.191", UNAM + in_columns("{:10.4f}", OTHERS, VALUES, THIRD),
     "gal", 0.005, VALUES, "column N00E, not in column V", {"V": OTHERS, "N90E": THIRD}),
    ("UNAM, touching", "CUP5.191",
     UNAM + in_columns("{:10.4f}", [-1234.5678] * 200, [10000.25] * 200, [-9876.5] * 200),
     "gal", 0.005, [10000.25] * 200, "UNAM", {"V": [-1234.5678] * 200, "N90E": [-9876.5] * 200}),
    ("CWB", "2-ECU.dat",
     CWB + in_columns("{:10.3f}", [0.02 * i for i in range(200)], OTHERS, VALUES, THIRD),
     "gal", 0.02, VALUES, "column N, not in column U", {"U": OTHERS, "E": THIRD, 1: OTHERS}),
    ("RENADIC", "altohospicio.v1",
     volume_1({"EW": TENTHS, "Z": WEST}, "UNIVERSIDAD DE CHILE - RENADIC"),
     "g", 0.01, [float(Fraction(str(v)) / 10) for v in TENTHS], "RENADIC",
     {"Z": [float(Fraction(str(v)) / 10) for v in WEST]}),
    ("CDMG, volume 1", "NEWPORT.RAW", volume_1({"90 DEG": TENTHS}),
     "g", 0.01, [float(Fraction(str(v)) / 10) for v in TENTHS], "CSMIP volume 1", {}),
    ("GeoNet V1A", "HSES_20.V1A", geonet(False), "mm/s^2", 0.005, VALUES, "column N10E", UP),
    ("GeoNet V1A, scaled", "HSES_21.V1A", geonet(False, "0.50"),
     "mm/s^2", 0.005, [0.5 * v for v in VALUES], "GeoNet", {}),
    ("GeoNet V2A", "HSES_20.V2A", geonet(True), "mm/s^2", 0.02, VALUES, "column N10E", UP),
    ("PEER", "RSN763.AT2", PEER, "g", 0.005, VALUES, "PEER", {}),
    ("CSMIP V2", "CE89146.V2", csmip(CSMIP, 10), "cm/s^2", 0.005, VALUES, "column 360 Deg",
     {"Up": OTHERS, 2: OTHERS}),
    ("CDMG V2", "CE36456.V2", csmip(CDMG, 10), "cm/s^2", 0.005, VALUES, "CSMIP", {"Up": OTHERS}),
    ("USC V2", "017m30bt.s0a", csmip(USC, 10), "cm/s^2", 0.005, VALUES, "CSMIP", {"Up": OTHERS}),
    ("CGS V1", "CIWLT.RAW", csmip(VOLUME_1, 10), "g", 0.005, VALUES, "CSMIP", {"Up": OTHERS}),
    ("COSMOS", "AKBMR.V2c", cosmos(COSMOS), "cm/s^2", 0.005, VALUES, "column 360 deg",
     {"Up": OTHERS}),
    ("SMC, corrected", "0111a.smc",
     smc("2 CORRECTED ACCELEROGRAM", 200.0, VALUES, 8, "{:10.3f}"),
     "cm/s^2", 0.005, VALUES, "component 133", {}),
    ("SMC, with empty lines", "hsl90.smc",
     smc("2 CORRECTED ACCELEROGRAM", 200.0, VALUES, 8, "{:10.3f}").replace("*\n", "\n"),
     "cm/s^2", 0.005, VALUES, "component 133", {}),
    ("SMC, with times", "4225a.smc",
     smc("1 UNCORRECTED ACCELEROGRAM", 1.7e38, PAIRS, 8, "{:10.3E}"),
     "cm/s^2", 0.005, MILLI, "SMC", {}),
]  # fmt: skip
NAMES = [one[0] for one in FILES]


def read_file(path, **keys):
    return Record.of({"file": str(path), **keys})


def read(tmp_path, name, text, **keys):
    path = tmp_path / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode("latin-1"))
    return read_file(path, **keys)


@pytest.mark.parametrize("file", FILES, ids=NAMES)
def test_a_network_s_file_needs_no_key(tmp_path, file):
    _, name, text, unit, step, values, words, others = file
    record = read(tmp_path, name, text)
    np.testing.assert_allclose(record.values, values, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(record.times, [step * i for i in range(200)], rtol=2e-3, atol=1e-12)
    assert record.unit == unit
    assert words in record.reading
    for component, expected in others.items():
        other = read(tmp_path, name, text, column=component)
        np.testing.assert_allclose(other.values, expected, rtol=1e-12, atol=1e-12)
    peak = max(values, key=abs)
    summary = record.summary(1e9)
    assert f"200 samples, step{'s' * (len({*np.diff(record.times).round(9)}) > 1)}" in summary
    assert f"peak {abs(peak):g} {unit} at {record.times[values.index(peak)]:g} s" in summary


@pytest.mark.parametrize("file", FILES, ids=NAMES)
def test_line_ends_and_gzip_change_nothing(tmp_path, file):
    _, name, text, *_ = file
    record = read(tmp_path, name, text)
    dos = text.replace("\n", "\r\n").encode("latin-1")
    for data in (dos, gzip.compress(dos)):
        other = read(tmp_path, name, data)
        assert (other.values, other.times, other.reading) == (
            record.values, record.times, record.reading,
        )  # fmt: skip


@pytest.mark.parametrize("file", FILES, ids=NAMES)
def test_keys_that_contradict_a_network_s_file_are_refused(tmp_path, file, error_of):
    _, name, text, unit, step, *_ = file
    wrong = error_of(read, tmp_path, name, text, dt=0.5)
    assert "dt = 0.5 s" in wrong
    assert f"{step:g} s" in wrong or "column time, which has times" in wrong
    other = "N" if unit != "N" else "g"
    wrong = error_of(read, tmp_path, name, text, unit=other)
    assert f"unit = {other!r}, but the file states" in wrong
    assert read(tmp_path, name, text, unit=unit).values == read(tmp_path, name, text).values


@pytest.mark.parametrize("file", [one for one in FILES if one[0] != "PEER"])
def test_a_header_that_is_not_recognized_is_refused_with_keys_as_well(tmp_path, file, error_of):
    """Without the line that a format is known by, nothing is guessed from the others."""
    _, name, text, *_ = file
    lines = text.split("\n")
    marks = ("GNS", "Scale", "SAMPLING", "STRONG", "EQUALLY", "ARCHIVO", "#SampleRate", "UNITS OF")
    marks += ("points", "POINTS", "Format v", "CORRECTED ACC", "NPTS", "RENADIC")
    kept = [line for line in lines if not any(mark in line for mark in marks)]
    for keys in ({}, {"unit": "g"}, {"dt": 0.01, "unit": "g"}):
        message = error_of(read, tmp_path, name, "\n".join(kept), **keys)
        assert len(message) < 500
        assert "\n" not in message


def test_skip_overrides_a_header(tmp_path):
    text = kik_net(100, "3920(gal)/6182761", "E-W", "AOM001")
    record = read(tmp_path, "AOM001.EW", text, skip=17, dt=0.01, unit="gal")
    assert record.values == tuple(map(float, COUNTS))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (esm("HNE", "20190728_160919", "VELOCITY"), "holds a velocity"),
        (esm("HNE", "20190728_160919", "PROCESSED VELOCITY"), "holds a velocity"),
        (esm("HNE", "20190728_160919", "ACCELERATION RESPONSE SPECTRUM"),
         "holds an acceleration response spectrum; needs an acceleration or a force"),
        (esm("HNE", "20190728_160919", count="201"), "states 201 values, 200 follow"),
        (esm("HNE", "20190728_160919", count="199"), "states 199 values, more follow"),
        (esm("HNE", "20190728_160919", interval="0"), "step of '0', which must be above 0"),
        (esm("HNE", "20190728_160919", unit="counts"), "'counts'"),
        (kik_net(100, "3920(gal)/0", "E-W", "AOM001"), "scale of '0'"),
        (kik_net(100, "3920(gal)/6182761", "E-W", "AOM001").replace("(s)  2", "(s)  9"),
         "states 900 values, 200 follow"),
        (AFAD.replace(": 200", ": 210"), "states 210 values, 200 follow"),
        (UNAM.replace("/0.005/0.005/0.005", "/0.005/0.01/0.005"), "steps of 0.005 and 0.01 s"),
        (geonet(False).replace("0.005 s\n", "0.010 s\n", 1), "components have the steps"),
        (cosmos(COSMOS.replace(" 1 secs", "2.2.2 secs")), "duration of '2.2.2'"),
        (cosmos(COSMOS.replace(" 1 secs", " 9 secs")), "give dt"),
        (cosmos("raw accel.   pts, approx    1 secs, units=counts (50),Format=(8F10.5)",
                "Raw acceleration counts "), "unknown unit of column 360 deg 'counts'"),
        (volume_1({"EW": VALUES[:3]}, "UNIVERSIDAD DE CHILE - RENADIC")
         .replace("G/10", "VOLTS"), "unit"),
        (PEER.replace("IN UNITS OF G", "IN UNITS OF FURLONGS"), "FURLONGS"),
        (geonet(False)[:600], "no values below it"),
    ],
)  # fmt: skip
def test_contradictions_within_a_file_are_refused(tmp_path, text, words, error_of):
    if "ORIENTACION" in text:
        text += in_columns("{:10.4f}", OTHERS, VALUES, THIRD)
    message = error_of(read, tmp_path, "quake.txt", text)
    assert words in message, message


def test_components_without_names_are_numbered_and_names_that_repeat_too(tmp_path, error_of):
    twice = geonet(False).replace("Component N80W", "Component N10E")
    assert (
        "column channel 1 N10E, not in column channel 2 N10E, column Up"
        in read(tmp_path, "quake.V1A", twice).reading
    )
    assert read(tmp_path, "quake.V1A", twice, column=2).values == tuple(OTHERS)
    wrong = error_of(read, tmp_path, "quake.V1A", twice, column="E-W")
    assert "allowed: channel 1 N10E, channel 2 N10E, Up" in wrong


def test_each_component_has_its_own_times(tmp_path):
    text = volume_1({"EW": TENTHS, "NS": TENTHS[:150]}, "UNIVERSIDAD DE CHILE - RENADIC")
    assert len(read(tmp_path, "quake.v1", text, column="NS").times) == 150


def test_every_format_has_a_file_here():
    used = {form.name for form in FORMATS}
    assert used == {
        "PEER", "K-NET or KiK-net", "ESM, ITACA or AFAD", "AFAD", "CSMNC", "UNAM", "CWB", "GeoNet",
        "CSMIP", "CSMIP volume 1", "COSMOS", "RENADIC", "SMC",
    }  # fmt: skip


# ---- other texts ---------------------------------------------------------------------------------


def test_a_title_with_as_many_words_as_a_row_has_numbers(tmp_path):
    """Two hundred samples, five a row: no word of the title becomes the name of a column."""
    for title in (
        "El Centro 1940 NS component", "El Centro (g) NS 1940",
        "Imperial, Valley, 1940, NS, 117",
    ):  # fmt: skip
        text = f"{title}\n" + rows(VALUES, 5, "{:12.4f}")
        assert read(tmp_path, "quake.txt", text, dt=0.01, unit="g").values == tuple(VALUES)
    ascending = "Time history of El Centro\n" + rows(range(200), 5, "{:12.4f}")
    with pytest.raises(nv.RequestError, match="give dt"):
        read(tmp_path, "quake.txt", ascending.replace("   0.0000", "   9.0000", 1), unit="g")


@pytest.mark.parametrize("form", ["{:10.4f}", "{:10.3E}", "{:9.4f}"])
def test_fixed_fields_that_touch(tmp_path, form):
    """Fortran leaves no blank where a number fills its field."""
    numbers = [-1000.0 - value for value in range(200)]
    expected = [float(form.format(number)) for number in numbers]
    text = "El Centro\n" + rows(numbers, 8, form)
    record = read(tmp_path, "quake.txt", text, dt=0.01, unit="gal")
    assert record.values == tuple(expected)
    assert "fields of" in record.reading
    some = [*VALUES[:100], *numbers[:100]]  # they touch in a few rows alone
    text = rows(some, 8, "{:10.4f}")
    record = read(tmp_path, "quake.txt", text, dt=0.01, unit="gal")
    np.testing.assert_allclose(record.values, some, rtol=1e-12)
    pairs = in_columns("{:10.4f}", [0.01 * i for i in range(200)], numbers)
    record = read(tmp_path, "quake.txt", pairs, unit="gal")
    np.testing.assert_allclose(record.values, numbers, rtol=1e-12)


@pytest.mark.parametrize(
    ("heading", "stamp", "cut"),
    [
        ("time,a [g]", "2020-02-29T23:59:59.{:03d}", ","),
        ("time;a [g]", "2020-02-29 23:59:59.{:03d}Z", ";"),
        ("UTC\ta [g]", "2020-02-29T23:59:59.{:03d}+01:00", "\t"),
        ("a [g]", "2020/02/29 23:59:59.{:03d}", " "),
    ],
)
def test_times_as_dates(tmp_path, heading, stamp, cut):
    stamps = [stamp.format(10 * i) for i in range(100)]
    stamps += [one.replace("-29", "-XX").replace("/29", "/XX").replace("23:59:59", "00:00:00")
               for one in stamps]  # fmt: skip
    stamps = [one.replace("02-XX", "03-01").replace("02/XX", "03/01") for one in stamps]
    lines = [f"{one}{cut}{value}" for one, value in zip(stamps, VALUES, strict=True)]
    text = "\n".join([heading, *lines]) + "\n"
    keys = {} if cut != " " else {"unit": "g"}
    record = read(tmp_path, "quake.csv", text, **keys)
    np.testing.assert_allclose(record.times, [0.01 * i for i in range(200)], atol=1e-9)
    assert record.values == tuple(VALUES)


@pytest.mark.parametrize(
    "header",
    [
        "NPTS=   200, DT=   .0050 SEC\nACCELERATION IN UNITS OF G",
        "ACCELERATION (G)\nNPTS=   200, DT=   .0050 SEC",
        "NPTS=   200, DT=   .0050 SEC\nAcceleration (g)",
        "ACCELERATION TIME HISTORY IN UNITS OF G\n 200    0.0050    NPTS, DT",
    ],
)
def test_a_header_of_peer_states_its_unit_above_or_below_its_step(tmp_path, header):
    text = f"PEER NGA STRONG MOTION DATABASE RECORD\nEl Centro, 180\n{header}\n"
    record = read(tmp_path, "a.AT2", text + rows(VALUES, 5, "{:15.7E}"))
    np.testing.assert_allclose(record.values, VALUES, rtol=1e-7)
    assert record.unit == "g"
    assert record.times[-1] == pytest.approx(199 * 0.005)


def test_the_index_of_a_table_of_pandas_is_neither_times_nor_values(tmp_path, error_of):
    lines = [f"{i},{0.01 * i},{value}" for i, value in enumerate(VALUES)]
    record = read(tmp_path, "quake.csv", "\n".join([",time,a [g]", *lines]))
    assert record.values == tuple(VALUES)
    assert record.times[-1] == pytest.approx(1.99)
    lines = [f"{i},{value}" for i, value in enumerate(VALUES)]
    text = "\n".join([",a [g]", *lines])
    assert "one column needs dt, its step" in error_of(read, tmp_path, "quake.csv", text)
    assert read(tmp_path, "quake.csv", text, dt=0.01, column=2).values == tuple(VALUES)
    lines = [f"{0.01 * i},{value}" for i, value in enumerate(VALUES)]  # an index of times
    record = read(tmp_path, "quake.csv", "\n".join([",a [g]", *lines]))
    assert record.times[-1] == pytest.approx(1.99)


def test_files_of_other_programs_are_refused_with_the_way_out(tmp_path, error_of):
    np.save(tmp_path / "quake.npy", VALUES)
    assert "np.savetxt writes it as text" in error_of(read_file, tmp_path / "quake.npy")
    binary = np.array(VALUES).tobytes() + bytes(99)
    for name in ("quake.sac", "quake.MSEED"):
        assert "; obspy reads SAC and miniSEED" in error_of(read, tmp_path, name, binary)
    assert "obspy" not in error_of(read, tmp_path, "quake.bin", binary)


def test_a_step_beside_times_without_a_heading_is_refused(tmp_path, error_of):
    text = in_columns("{:10.3f}", [0.01 * i for i in range(200)], VALUES)
    wrong = error_of(read, tmp_path, "quake.txt", text, dt=0.02, unit="g", column=2)
    assert "dt = 0.02 s, but column 1 ascends in steps of 0.01" in wrong
    record = read(tmp_path, "quake.txt", text, dt=0.01, unit="g", column=2)
    assert record.values == tuple(VALUES)
    numbered = in_columns("{:10.3f}", range(1, 201), VALUES)
    record = read(tmp_path, "quake.txt", numbered, dt=0.02, unit="g", column=2)
    assert record.times[1] == 0.02


@pytest.mark.parametrize(
    "header",
    [
        "Sampling 100 Hz",
        "dt = 0.01",
        "# scale: 0.5",
        "FACTOR DE ESCALA 2.5",
        "Raw counts",
        "1 2 3\n4 5 6",
        "Interval 0.02",
    ],
)
def test_a_header_that_says_more_than_a_title_is_refused(tmp_path, header, error_of):
    text = f"El Centro\n{header}\n" + rows(VALUES, 5, "{:12.4f}")
    wrong = error_of(read, tmp_path, "quake.txt", text, dt=0.01, unit="g")
    assert "skip" in wrong
    lines = 1 + len(header.split("\n"))
    record = read(tmp_path, "quake.txt", text, dt=0.01, unit="g", skip=lines)
    assert record.values == tuple(VALUES)
    # a table that states its times and its unit needs none of it
    table = f"# {header}\n".replace("\n4", "\n# 4") + "t [s], a [g]\n0, 1\n0.1, 2\n0.2, 3\n"
    assert read(tmp_path, "quake.csv", table).values == (1.0, 2.0, 3.0)


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"1 " * 6_000_000, "6000000 numbers or words; allowed: up to 5000000"),
        (b"\n" * 2_000_000, "has 2000000 lines; allowed: up to 1200000"),
        (b"1\r" * 2_000_000, "has 2000000 lines"),
        (gzip.compress(b"1 " * 40_000_000, 1), "more than 67108864 bytes"),
        (gzip.compress(PEER.encode())[:-20], "gzip: its end is missing"),
        (b"\x1f\x8b" + b"x" * 99, "cannot be unpacked as gzip"),
        (b"t [s]" + b", a [g]" * 2000 + b"\n" + b"0" + b", 1" * 2000 + b"\n", "2001 columns"),
    ],
)
def test_what_would_fill_the_memory_is_refused_before(tmp_path, data, words, error_of):
    assert words in error_of(read, tmp_path, "quake.txt", data, unit="g")


def test_a_message_names_a_screen_of_columns_at_most(tmp_path, error_of):
    with h5py.File(tmp_path / "many.h5", "w") as file:
        for i in range(1001):
            file[f"{'a long name of a column ' * 2}{i}"] = [0.0, 1.0]
    wrong = error_of(read_file, tmp_path / "many.h5", unit="g")
    assert "has 1001 datasets; allowed: up to 1000" in wrong
    with h5py.File(tmp_path / "many.h5", "a") as file:
        del file[f"{'a long name of a column ' * 2}7"]
    assert "has 1000 datasets; allowed" in error_of(read_file, tmp_path / "many.h5", unit="g")
    keys = {"column": "east", "dt": 0.01, "unit": "g"}
    wrong = error_of(read_file, tmp_path / "many.h5", **keys)
    assert "(1000 in all)" in wrong
    assert len(wrong) < 5000
