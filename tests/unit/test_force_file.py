"""Files of measured force: separators, decimal signs, units in headings, columns, and refusals; numbers known."""

from pathlib import Path

import numpy as np
import pytest

from bristle_sim.force_file import read_force_csv

TIME = np.array([-2e-5, -1e-5, 0.0, 1e-5, 2e-5, 3e-5])
FORCE = np.array([0.0, 0.25, 12.5, 40.0, 12.5, -0.5])


def rows(scale_time=1.0, scale_force=1.0, between=",", decimal=".", before="", after=""):
    """The points written out; twelve digits, so that reading them back is exact to 1e-12."""
    lines = []
    for t, f in zip(TIME * scale_time, FORCE * scale_force, strict=True):
        cells = [f"{value:.12g}".replace(".", decimal) for value in (t, f)]
        lines.append(f"{before}{between.join(cells)}{after}")
    return "\n".join(lines) + "\n"


FILES = {
    "two columns": rows(),
    "semicolons and decimal commas": "Zeit (ms);Kraft (N)\n" + rows(1e3, between=";", decimal=","),
    "tabs and decimal commas": "t [s]\tF [kN]\n" + rows(1, 1e-3, between="\t", decimal=","),
    "blanks and decimal commas": "t[us]   F[N]\n" + rows(1e6, between="  ", decimal=","),
    "quotes": '"time / ms","force / N"\n' + rows(1e3, between='","', before='"', after='"'),
    "byte order mark, remarks": "\ufeff# Yu et al.\n# sampled at 100 kHz\n\ntime (µs),force (mN)\n"
    + rows(1e6, 1e3),
    "force first": "force (N);t / μs\n"
    + "".join(f"{f:g};{1e6 * t:g}\n" for t, f in zip(TIME, FORCE, strict=True)),
}


def written(folder: Path, text: str) -> Path:
    path = folder / "points.csv"
    path.write_bytes(text.encode())
    return path


@pytest.mark.parametrize("ends", ["\n", "\r\n"])
@pytest.mark.parametrize("name", FILES)
def test_separators_decimal_signs_and_units(tmp_path, name, ends):
    time, force, _ = read_force_csv(written(tmp_path, FILES[name].replace("\n", ends)))
    # Twelve digits are written.
    np.testing.assert_allclose(time, TIME, rtol=1e-11, atol=1e-17)
    np.testing.assert_allclose(force, FORCE, rtol=1e-11)


def three(heading):
    """Time, a channel that is no force, and the force."""
    lines = [f"{t:g},{99 - i},{f:g}" for i, (t, f) in enumerate(zip(TIME, FORCE, strict=True))]
    return "\n".join([each for each in (heading,) if each] + lines)


@pytest.mark.parametrize(
    ("text", "chosen"),
    [
        (three("TIME,CH1,CH2"), {"force_column": "CH2"}),
        (three("TIME,CH1,CH2"), {"force_column": "3"}),
        (three(""), {"time_column": "1", "force_column": "3"}),
        (three("t (s),acceleration (m/s2),load (N)"), {}),
    ],
)
def test_columns_are_chosen_by_heading_number_or_unit(tmp_path, text, chosen):
    time, force, _ = read_force_csv(written(tmp_path, text), **chosen)
    assert time.tolist() == TIME.tolist()
    assert force.tolist() == FORCE.tolist()


def test_a_voltage_needs_a_sensitivity(tmp_path):
    path = written(tmp_path, "Time (ms),Channel A (mV)\n" + rows(1e3, 1e3 / -20.0))
    with pytest.raises(
        ValueError,
        match=r"points\.csv: column 2 \(Channel A\) in 'mV': a force must be in N, .* force_per_volt must be given",
    ):
        read_force_csv(path)
    np.testing.assert_allclose(
        read_force_csv(path, force_per_volt=-20.0).force, FORCE, rtol=1e-11, atol=1e-30
    )
    assert (
        read_force_csv(written(tmp_path, rows()), force_per_volt=2.0).force.tolist()
        == (2.0 * FORCE).tolist()
    )


@pytest.mark.parametrize(
    ("text", "settings", "message"),
    [
        ("", {}, "must have columns of time and force"),
        ("time,force\n", {}, "must have at least 4 points, not 0"),
        ("0,1\n1,2\n2,3\n", {}, "must have at least 4 points, not 3"),
        (
            "time,force\n0,1\nx,2\n2,3\n3,4\n",
            {},
            "line 3: 'x' in column 1: must be a finite number",
        ),
        ("0,1\n1,nan\n2,3\n3,4\n", {}, "line 2: 'nan' in column 2"),
        ("0,1\n1,-inf\n2,3\n3,4\n", {}, "line 2: '-inf'"),
        ("0,1\n1,\n2,3\n3,4\n", {}, "line 2: '' in column 2"),
        ("0,1\n1\n2,3\n3,4\n", {}, "line 2: '' in column 2"),
        ("0,1\n1,2\n2,3\n3,4\nend,of file\n", {}, "line 5: 'end' in column 1"),
        ("0,1\n2,2\n\n2,3\n3,4\n", {}, "line 4: time = 2: must be more than the time before, 2"),
        (
            three("TIME,CH1,CH2"),
            {},
            r"columns 2 \(CH1\), 3 \(CH2\): force_column must say which of them is the force",
        ),
        (
            three("TIME,CH1,CH2"),
            {"force_column": "CH3"},
            r"force_column = 'CH3': must be the heading or number of one",
        ),
        (three("TIME,CH1,CH2"), {"force_column": "1"}, "force_column = '1': must be"),
        # Decimal commas separated by commas: four columns of whole numbers under two headings.
        (
            "time (s),pressure (bar)\n" + rows(),
            {},
            r"in 'bar': a force must be in N, mN, kN, lbf or V, mV",
        ),
        ("time (min),force (N)\n" + rows(), {}, "in 'min': a time must be in s, ms, us, ns"),
        (
            "s (s),F (kN)\n0,1\n1,1e307\n2,3\n3,4\n",
            {},
            r"line 3: '1e307' in column 2: must be a finite number of at most 1e\+100",
        ),
        (
            "s (s),F (kN)\n0,1\n1,2\n2,3\n1e300,4\n",
            {},
            r"line 5: '1e300' in column 1: must be a finite number of at most 1e\+100",
        ),
        (
            "time (s),force (N)\n" + rows(),
            {"force_per_volt": 2.0},
            "in 'N': a force must be in V, mV, or force_per_volt must not be given",
        ),
        (
            "time,force\n" + "1" * 200_000 + ",2\n",
            {},
            r"line 2: must be columns of numbers \(field larger",
        ),
        (
            "time;force\n" + "1" * 100_000 + ";2\n1;2\n2;3\n3;4\n",
            {},
            r"line 2: '1+\.\.\.' in column 1: must be",
        ),
    ],
)
def test_an_unclear_file_is_refused_in_one_line(tmp_path, text, settings, message):
    with pytest.raises(ValueError, match=message) as refusal:
        read_force_csv(written(tmp_path, text), **settings)
    assert "\n" not in str(refusal.value)
    assert "points.csv" in str(refusal.value)


def test_missing_and_binary_files_are_refused(tmp_path):
    for name in (tmp_path / "none.csv", tmp_path, "\0"):
        with pytest.raises(ValueError, match="must be a readable file"):
            read_force_csv(name)
    binary = tmp_path / "binary.csv"
    binary.write_bytes(b"\x89PNG\x00\x01\x00")
    with pytest.raises(ValueError, match="must be a text file"):
        read_force_csv(binary)
