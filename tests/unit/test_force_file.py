"""Files of measured force as oscilloscopes and spreadsheets write them: layouts imitated, numbers known."""

from pathlib import Path

import numpy as np
import pytest

from bristle_sim.force_file import read_force_csv, split_unit

TIME = np.array([-2e-5, -1e-5, 0.0, 1e-5, 2e-5, 3e-5])
FORCE = np.array([0.0, 0.25, 12.5, 40.0, 12.5, -0.5])


def rows(scale_time=1.0, scale_force=1.0, between=",", decimal=".", before="", after=""):
    """The points written out; twelve digits, so that reading them back is exact to 1e-12."""
    lines = []
    for t, f in zip(TIME * scale_time, FORCE * scale_force, strict=True):
        cells = [f"{value:.12g}".replace(".", decimal) for value in (t, f)]
        lines.append(f"{before}{between.join(cells)}{after}")
    return "\n".join(lines) + "\n"


def beside(settings):
    """Tektronix TDS: settings in the first three columns, beside the first samples; a comma ends each line."""
    lines = rows().splitlines()
    return "\n".join(f"{left},{right}," for left, right in zip(settings, lines, strict=True)) + "\n"


FILES = {
    "two columns": rows(),
    "semicolons and decimal commas": "Zeit (ms);Kraft (N)\n" + rows(1e3, between=";", decimal=","),
    "tabs and decimal commas": "t [s]\tF [kN]\n" + rows(1, 1e-3, between="\t", decimal=","),
    "blanks and decimal commas": "t [us]   F [N]\n" + rows(1e6, between="  ", decimal=","),
    "quoted decimal commas": '"time / ms","force / N"\n' + rows(1e3, between='","', decimal=",", before='"', after='"'),
    "byte order mark, remarks": "\ufeff# Yu et al.\n# sampled at 100 kHz\n\ntime_us,force_mN\n" + rows(1e6, 1e3),
    "tektronix mso": (
        "Model,MSO54\nFirmware Version,1.20.5\n,\nWaveform Type,ANALOG\nPoint Format,Y\nHorizontal Units,s\n"
        "Horizontal Scale,4e-05\nSample Interval,1e-05\nRecord Length,6\nVertical Units,N\n,\nLabels,\nTIME,CH1\n"
        + rows()
    ),
    "tektronix tds": beside(
        [
            "Record Length,6,",
            "Sample Interval,1e-05,",
            "Trigger Point,3,",
            "Vertical Units,N,",
            "Horizontal Units,s,",
            ",,",
        ]
    ),
    "lecroy": (
        "LECROYWR64Xi,21432,Waveform\nSegments,1,SegmentSize,6\nSegment,TrigTime,TimeSinceSegment1\n"
        "#1,17-Nov-2020 12:02:03,0\nTime,Ampl\n" + rows()
    ),
    "picoscope": "Time,Channel A\n(us),(mN)\n\n" + rows(1e6, 1e3),
    "picoscope, german": "Zeit;Kanal A\n(µs);(N)\n\n" + rows(1e6, between=";", decimal=","),
    "keysight infiniivision": "x-axis,1\nsecond,Newton\n" + rows(),
    "keysight infiniium": (
        "Revision:,1\nType:,raw\nPoints:,6\nXInc:,1e-05\nXUnits:,second\nYUnits:,Newton\nMin Bandwidth:,0\nData:,\n"
        + rows()
    ),
    "blanks": "\n".join(f"   {line}  " for line in rows(between="   ").splitlines()),
}


def written(folder: Path, text: str, encoding="utf-8") -> Path:
    path = folder / "points.csv"
    path.write_bytes(text.encode(encoding))
    return path


@pytest.mark.parametrize("ends", ["\n", "\r\n"])
@pytest.mark.parametrize("name", FILES)
def test_layouts(tmp_path, name, ends):
    time, force, _ = read_force_csv(written(tmp_path, FILES[name].replace("\n", ends)))
    # Twelve digits are written.
    np.testing.assert_allclose(time, TIME, rtol=1e-11, atol=1e-17)
    np.testing.assert_allclose(force, FORCE, rtol=1e-11)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "cp1252"])
def test_encodings(tmp_path, encoding):
    time, _, _ = read_force_csv(written(tmp_path, "Zeit (µs);Kraft (N)\n" + rows(1e6, between=";"), encoding))
    np.testing.assert_allclose(time, TIME, rtol=1e-11, atol=1e-17)


def three(heading, units=""):
    """Time, a channel that is no force, and the force."""
    lines = [f"{t:g},{99 - i},{f:g}" for i, (t, f) in enumerate(zip(TIME, FORCE, strict=True))]
    return "\n".join([each for each in (heading, units) if each] + lines)


@pytest.mark.parametrize(
    ("text", "chosen"),
    [
        (three("TIME,CH1,CH2"), {"force_column": "CH2"}),
        (three("TIME,CH1,CH2"), {"force_column": "3"}),
        (three(""), {"time_column": "1", "force_column": "3"}),
        (three("Time,Channel A,Channel B", "(s),(V),(N)"), {}),
        (three("time,trigger,force"), {}),
        (three("t (s),acceleration (m/s2),load (N)"), {}),
        (three("x-axis,1,2", "second,Volt,Newton"), {"force_column": "3"}),
        ("force;time\n" + "\n".join(f"{f:g};{t:g}" for t, f in zip(TIME, FORCE, strict=True)), {}),
    ],
)
def test_columns_are_chosen_by_heading_number_or_unit(tmp_path, text, chosen):
    time, force, _ = read_force_csv(written(tmp_path, text), **chosen)
    assert time.tolist() == TIME.tolist()
    assert force.tolist() == FORCE.tolist()


def test_a_voltage_needs_a_sensitivity(tmp_path):
    path = written(tmp_path, "Time,Channel A\n(ms),(mV)\n\n" + rows(1e3, 1e3 / -20.0))
    with pytest.raises(ValueError, match=r"points\.csv: column 2 \(Channel A\) in mV: force_per_volt must be given"):
        read_force_csv(path)
    np.testing.assert_allclose(read_force_csv(path, force_per_volt=-20.0).force, FORCE, rtol=1e-11, atol=1e-30)


def test_a_sensitivity_says_that_bare_numbers_are_volts(tmp_path):
    assert read_force_csv(written(tmp_path, rows()), force_per_volt=2.0).force.tolist() == (2.0 * FORCE).tolist()


def test_what_was_read_is_told(tmp_path):
    plain = read_force_csv(written(tmp_path, "TIME,CH1\n" + rows())).reading
    assert plain == "time from column 1 (TIME), no unit: taken as s; force from column 2 (CH1), no unit: taken as N"
    scaled = read_force_csv(written(tmp_path, "t (ms),CH1\n" + rows(1e3)), force_per_volt=2.0).reading
    assert scaled == "time from column 1 (t (ms)), ms; force from column 2 (CH1), no unit: taken as V"


def test_a_clock_rounded_to_fewer_digits_than_its_steps_is_even(tmp_path):
    """1 MHz written with five decimals: ten samples share a time."""
    count = 200
    text = "\n".join(f"{round(i * 1e-6, 5):.5f},{i}" for i in range(count))
    time, _, _ = read_force_csv(written(tmp_path, text))
    # Rounding takes half a tick off either end: 199 steps span 200 us to one tick of 10 us.
    np.testing.assert_allclose(np.diff(time), 1e-6, rtol=0.06)


@pytest.mark.parametrize(
    ("text", "settings", "message"),
    [
        ("", {}, "no line with two numbers"),
        ("time,force\n", {}, "no line with two numbers"),
        ("0,1\n1,2\n2,3\n", {}, "3 points; there must be at least 4"),
        ("time,force\n0,1\nx,2\n2,3\n3,4\n", {}, "line 3: 'x' in column 1: must be a finite number"),
        ("0,1\n1,nan\n2,3\n3,4\n", {}, "line 2: 'nan' in column 2"),
        ("0;1\n1;∞\n2;3\n3;4\n", {}, "line 2: '∞'"),
        ("0,1\n1,-inf\n2,3\n3,4\n", {}, "line 2: '-inf'"),
        ("0,1\n1,\n2,3\n3,4\n", {}, "line 2: '' in column 2"),
        ("0,1\n1\n2,3\n3,4\n", {}, "line 2: '' in column 2"),
        ("0,1\n1,2\n2,3\n3,4\nend of file\n", {}, "line 5: "),
        ("0,1\n2,2\n\n2,3\n3,4\n", {}, r"line 4: time = 2: must be more than the time before, 2 \(in s\)"),
        ("0,1\n2,2\n1,3\n3,4\n", {}, "line 3: time = 1"),
        (three("TIME,CH1,CH2"), {}, r"columns 2 \(CH1\), 3 \(CH2\): force_column must say which of them is the force"),
        (three(""), {}, "columns 2, 3: force_column must say"),
        (
            three("TIME,CH1,CH2"),
            {"force_column": "CH3"},
            r"force_column = 'CH3': must be the heading or number of one of",
        ),
        (three("TIME,CH1,CH2"), {"force_column": "1"}, "force_column = '1': must be"),
        (three("TIME,CH1,CH2"), {"time_column": "date", "force_column": "3"}, "time_column = 'date'"),
        # Decimal commas separated by commas: four columns of whole numbers under two headings.
        ("time,force\n0,001,0,5\n0,002,1,5\n0,003,2,5\n0,004,1,5\n", {}, "force_column must say"),
        ("time (s),pressure (bar)\n" + rows(), {}, r"in 'bar': a force must be in N, mN, kN, lbf or V, mV"),
        ("time (min),force (N)\n" + rows(), {}, "in 'min': a time must be in s, ms, us, ns"),
        (
            "X,CH1,\nSequence,Volt,\n0,0.1\n1,0.2\n2,0.3\n3,0.2\n",
            {"force_per_volt": 5.0},
            r"counts samples: there must be",
        ),
        ("Vertical Units,Pa\nTIME,CH1\n" + rows(), {}, "in 'Pa'"),
        ("time (s),force (N)\n" + rows(), {"force_per_volt": 2.0}, "force_per_volt must not be given"),
    ],
)
def test_what_is_not_clear_is_refused_in_one_line(tmp_path, text, settings, message):
    with pytest.raises(ValueError, match=message) as refusal:
        read_force_csv(written(tmp_path, text), **settings)
    assert "\n" not in str(refusal.value)
    assert "points.csv" in str(refusal.value)


def test_missing_and_binary_files_are_refused(tmp_path):
    with pytest.raises(ValueError, match=r"none\.csv: must be a readable file"):
        read_force_csv(tmp_path / "none.csv")
    with pytest.raises(ValueError, match="must be a readable file"):
        read_force_csv(tmp_path)
    binary = tmp_path / "binary.csv"
    for content, message in (
        (b"\x89PNG\x00\x01\x00", "must be a text file"),
        (b"\xff\xfe\x00\x80", "no line with two"),
    ):
        binary.write_bytes(content)
        with pytest.raises(ValueError, match=message):
            read_force_csv(binary)


@pytest.mark.parametrize(
    ("heading", "name", "unit"),
    [
        ("time (ms)", "time", "ms"),
        ("Force [kN]", "Force", "kN"),
        ("t/µs", "t", "us"),
        ("t / μs", "t", "us"),
        ("F in N", "F", "N"),
        ("force_mN", "force", "mN"),
        ("second", "", "s"),
        ("Volts", "", "V"),
        ("Zeit, s", "Zeit", "s"),
        ("CH1", "CH1", ""),
        ("Channel A", "Channel A", ""),
        ("load (bar)", "load", "bar"),
        ("", "", ""),
    ],
)
def test_units_in_headings(heading, name, unit):
    assert split_unit(heading) == (name, unit)
