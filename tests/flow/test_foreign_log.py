"""Impact tables from elsewhere: units, axes and signs come out right, and whatever is wrong is told at once."""

from __future__ import annotations

import numpy as np
import pytest

from glue.errors import InputError
from glue.flow.column_map import read_map
from glue.flow.foreign_log import read_foreign, write_plain
from glue.flow.impacts import COLUMNS

# Two shots in mm and ms, y up, of a code that counts a fall as positive; the second one is logged first.
TABLE = """made by another code
Time,Pos X,Pos Y,Pos Z,Vel X,Fall,Vel Z,Diameter
4.0,1.5,10.0,-2.0,100,50000,200,0.8
2.0,-1.0,10.0,0.5,0,60000,0,1.0
"""
MAP = """schema = 1
skip_lines = 1
origin_m = [0, 0.010, 0]
axes = {x = "x", y = "-z", z = "y"}
[columns]
time_s = {column = "Time", unit = "ms"}
x_m = {column = "Pos X", unit = "mm"}
y_m = {column = "Pos Y", unit = "mm"}
z_m = {column = "Pos Z", unit = "mm"}
vx_in_m_s = {column = "Vel X", unit = "mm/s"}
vy_in_m_s = {column = "Fall", unit = "mm/s", factor = -1}
vz_in_m_s = {column = "Vel Z", unit = "mm/s"}
diameter_m = {column = "Diameter", unit = "mm"}
[constants]
density_kg_m3 = 7800
restitution = 0.5
"""


@pytest.fixture
def files(tmp_path):
    def write(table=TABLE, column_map=MAP):
        (tmp_path / "table.csv").write_text(table)
        (tmp_path / "map.toml").write_text(column_map)
        return tmp_path / "table.csv", tmp_path / "map.toml"

    return write


def read(table, column_map):
    return read_foreign(table, read_map(column_map))


def problems(table, column_map):
    with pytest.raises(InputError) as caught:
        read(table, column_map)
    return caught.value.problems


def test_units_axes_and_order_of_time(files):
    impacts, header = read(*files())
    assert impacts["time_s"].tolist() == pytest.approx([2e-3, 4e-3])
    assert impacts["shot_id"].tolist() == [1, 0] and impacts["impact_id"].tolist() == [0, 1]
    first, second = impacts
    # our y is its -z, our z its y less the 10 mm of the origin
    assert [first[n] for n in ("x_m", "y_m", "z_m")] == pytest.approx([-1e-3, -0.5e-3, 0.0])
    assert [second[n] for n in ("vx_in_m_s", "vy_in_m_s", "vz_in_m_s")] == pytest.approx([0.1, -0.2, -50.0])
    # restitution .5 of the normal speed, the tangential one kept
    assert [second[n] for n in ("vx_out_m_s", "vy_out_m_s", "vz_out_m_s")] == pytest.approx([0.1, -0.2, 25.0])
    assert first["diameter_m"] == pytest.approx(1e-3) and first["nz"] == 1.0 and np.isnan(first["peak_force_N"])
    assert header["model"] == "imported" and header["source"] == "table.csv" and len(header["source_sha256"]) == 64


def test_centres_are_put_down_to_where_they_touch(files):
    raised = MAP.replace("[columns]", 'position = "centre"\n[columns]')
    impacts, _ = read(*files(column_map=raised))
    assert impacts["z_m"] == pytest.approx([-0.5e-3, -0.4e-3])


def test_all_that_is_wrong_with_a_map_is_told_at_once(files):
    bad = MAP.replace("schema = 1", "schema = 2\nunits = 3").replace('unit = "ms"', 'unit = "mm"')
    bad = bad.replace("restitution = 0.5", "restitution = 2")
    bad = bad.replace("diameter_m = ", "diametre_m = ").replace('y = "-z"', 'y = "z"')
    told = "\n".join(problems(*files(column_map=bad)))
    for words in (
        "units: unknown key", "schema: 2", "columns.time_s: unit 'mm' is none of a time", "columns.diametre_m: no column",
        "columns.diameter_m: missing", "constants.restitution: 2", "axes: mirror the table",
    ):  # fmt: skip
        assert words in told, words


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        (TABLE.replace("Fall", "Drop"), "has no column 'Fall'; it has Time, Pos X"),
        (TABLE.replace("60000", "fast"), "a row cannot be read"),
        (TABLE.replace("60000", "-60000"), "1 of 2 impacts move out of the target"),
        (TABLE.replace(",0.8", ",-0.8"), "diameter_m: not positive in 1 rows"),
        (TABLE.replace("1.5,", "nan,"), "x_m: not finite"),
        (TABLE.replace(",1.0", ",1000"), "diameter_m: 1.0 is 1000 mm; this key is in metres (1.0 mm is written 0.001)"),
        (TABLE.replace("0000,", "0000000,"), "v?_in_m_s: the middle speed 5500"),
        ("one\n" + TABLE.split("\n")[1] + "\n", "holds no impact"),
    ],
)
def test_what_is_wrong_with_a_table_is_told(files, wrong, words):
    assert words in "\n".join(problems(*files(table=wrong)))


EUROPEAN = """Export vom 3. Mai
Probe 7; zweite Serie

Time;Kommentar;"Pos X";Pos Y;Pos Z;Vel X;Fall;Vel Z;Diameter
4,0;"Rand; oben";1,5;10,0;-2,0;100;50000;200;0,8
2,0;Mitte;-1,0;10,0;0,5;0;60000;0;1,0
"""
EUROPEAN_HEAD = 'skip_lines = 3\nseparator = ";"\ndecimal = ","'


def test_semicolons_decimal_commas_titles_and_texts(files):
    own = MAP.replace("skip_lines = 1", EUROPEAN_HEAD)
    impacts, _ = read(*files(EUROPEAN, own))
    expected, _ = read(*files())
    for name in COLUMNS.names:
        assert np.array_equal(impacts[name], expected[name], equal_nan=True), name


@pytest.mark.parametrize(
    ("head", "table", "words"),
    [
        ("", EUROPEAN, 'line 4 has them all; in the map: skip_lines = 3, separator = ";"'),
        ('separator = ";"\nskip_lines = 3', EUROPEAN, "table.csv:5: a row cannot be read: '4,0' in column 'Time'"),
        ('separator = ";"\nskip_lines = 3', EUROPEAN, 'is decimal = "," in the map missing?'),
        (EUROPEAN_HEAD, EUROPEAN.replace("60000", "fast"), "csv:6: a row cannot be read: 'fast' in column 'Fall'"),
        (EUROPEAN_HEAD, EUROPEAN.replace("Mitte;", ""), "table.csv:6: has 8 columns, the line of names has 9"),
        ('decimal = ","', EUROPEAN, "decimal: is the separator too"),
        ('decimal = "c"', EUROPEAN, "decimal: 'c'; allowed"),
        ('separator = "1"', EUROPEAN, "separator: '1'; allowed"),
        ("skip_lines = 1", TABLE.replace("1.5,", "nan,"), "x_m: not finite (first: line 3)"),
        ("skip_lines = 1", "one\n\n#" + TABLE.replace("60000", "-60000"), "first: line 6"),
        ("", "a,b\n1,2\n", "it has a, b; are separator and skip_lines"),
    ],
)
def test_what_is_wrong_with_a_common_table_is_told_with_its_line(files, head, table, words):
    assert words in "\n".join(problems(*files(table, MAP.replace("skip_lines = 1", head))))


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("[constants]", 'vz_out_m_s = "Vel X"\n[constants]', "constants.restitution: beside vz_out_m_s"),
        ("[constants]", "[constants]\nvx_out_m_s = 0", "constants.restitution: beside vx_out_m_s"),
        ("schema = 1", "schema = 1\nsame_impact_s = 1e-5", "same_impact_s: tells rows of one shot apart"),
        ("skip_lines = 1", "skip_lines = 1.5", "skip_lines: 1.5; allowed: a whole number"),
    ],
)
def test_a_map_that_would_be_half_read_is_refused(files, old, new, words):
    (told,) = problems(*files(column_map=MAP.replace(old, new)))
    assert words in told


def test_density_and_speeds_have_the_scene_readers_limits(files):
    """In a map whose units were left out: density in g/cm3, mm/s and mm taken for SI."""
    bare = MAP.replace(', unit = "mm/s"', "").replace(', unit = "mm"', "").replace("7800", "7.8")
    told = problems(*files(column_map=bare))
    assert len(told) == 3
    for words in ("(0.8 mm is written 0.0008)", "(7.8 g/cm3 is written 7800)", "allowed 0.5..300 m/s"):
        assert words in "\n".join(told)


def test_a_dump_of_contacts_becomes_impacts(files):
    """Shot 7 is in contact in two snapshots and comes again later; shot 8 once."""
    box = "ITEM: BOX BOUNDS ff ff ff\n0 1\n0 1\n0 1\n"
    snapshot = "ITEM: TIMESTEP\n{}\nITEM: NUMBER OF ENTRIES\n1\n" + box + "ITEM: ENTRIES id x y z vx vy vz\n{}\n"
    rows = ((100, "7 .001 0 0 0 0 -60"), (110, "7 .001 0 0 0 0 -20"), (110, "8 .002 0 0 0 0 -61"), (500, "7 .003 0 0 0 0 -30"))
    column_map = """schema = 1
format = "dump"
timestep_s = 1e-6
same_impact_s = 2e-5
[columns]
shot_id = "id"
x_m = "x"
y_m = "y"
z_m = "z"
vx_in_m_s = "vx"
vy_in_m_s = "vy"
vz_in_m_s = "vz"
[constants]
diameter_m = 1e-3
density_kg_m3 = 7800
restitution = 0.4
"""
    impacts, _ = read(*files("".join(snapshot.format(*row) for row in rows), column_map))
    assert impacts["shot_id"].tolist() == [7, 8, 7]
    assert impacts["time_s"].tolist() == pytest.approx([100e-6, 110e-6, 500e-6])
    assert impacts["vz_in_m_s"].tolist() == [-60.0, -61.0, -30.0]


@pytest.mark.parametrize("units", [{}, {"length": "mm", "speed": "mm/s", "time": "us", "density": "g/cm3", "spin": "rpm"}])
def test_our_own_log_comes_back(tmp_path, units):
    rng = np.random.default_rng(3)
    impacts = np.zeros(50, COLUMNS)
    for name in COLUMNS.names:
        impacts[name] = rng.uniform(0.1, 1.0, 50) if COLUMNS[name].kind == "f" else rng.integers(0, 3, 50)
    impacts["diameter_m"], impacts["density_kg_m3"] = rng.uniform(1e-3, 2e-3, 50), rng.uniform(7000.0, 8000.0, 50)
    impacts["time_s"], impacts["impact_id"] = np.sort(impacts["time_s"]), np.arange(50)
    impacts["nx"], impacts["ny"], impacts["nz"], impacts["vz_in_m_s"] = 0.0, 0.6, 0.8, -60.0
    write_plain(tmp_path / "a.csv", impacts, units, tmp_path / "a.toml")
    found, _ = read(tmp_path / "a.csv", tmp_path / "a.toml")
    for name in COLUMNS.names:
        if units:
            assert found[name] == pytest.approx(impacts[name], rel=1e-14), name
        else:
            assert np.array_equal(found[name], impacts[name]), name
