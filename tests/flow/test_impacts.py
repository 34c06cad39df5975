"""The impact log survives a round trip bit for bit, and a log that is not whole is never taken for one."""

import numpy as np
import pytest

from glue.errors import InputError
from glue.flow import impacts

DESIGN = (
    "impact_id shot_id time_s duration_s x_m y_m"
    " vx_in_m_s vy_in_m_s vz_in_m_s wx_in_rad_s wy_in_rad_s wz_in_rad_s"
    " vx_out_m_s vy_out_m_s vz_out_m_s wx_out_rad_s wy_out_rad_s wz_out_rad_s"
    " diameter_m density_kg_m3 peak_force_N collisions_before z_m nx ny nz nozzle_id pass_id medium"
).split()


@pytest.fixture
def log():
    rng = np.random.default_rng(7)
    rows = np.zeros(50, impacts.COLUMNS)
    for name in rows.dtype.names:
        rows[name] = (
            rng.integers(0, 9, 50)
            if rows.dtype[name].kind == "i"
            else rng.normal(size=50) * 10.0 ** rng.integers(-9, 9)
        )
    rows["peak_force_N"][3] = np.nan  # models without forces
    for name in ("nx", "ny", "nz"):
        rows[name] = rng.normal(size=50)
    length = np.sqrt(sum(rows[name] ** 2 for name in ("nx", "ny", "nz")))
    for name in ("nx", "ny", "nz"):
        rows[name] /= length
    into = -np.sign(sum(rows[f"v{a}_in_m_s"] * rows[f"n{a}"] for a in "xyz"))
    for name in ("vx_in_m_s", "vy_in_m_s", "vz_in_m_s"):
        rows[name] *= into  # impacts move into the target
    return rows


def test_columns_are_those_of_the_format():
    assert list(impacts.COLUMNS.names) == DESIGN


def test_round_trip_is_exact(log, tmp_path):
    path = tmp_path / "impacts.csv"
    impacts.write_impacts(path, log, {"scene_hash": "ab", "model": "dem"})
    back, header = impacts.read_impacts(path)
    assert back.tobytes() == log.tobytes()
    assert header["scene_hash"] == "ab" and header["model"] == "dem"
    text = path.read_text()
    assert text.startswith("# impact log, schema 1\n") and text.endswith("\n# end n=50\n")
    assert list(tmp_path.iterdir()) == [path], "a .part is left"


def test_empty_log(tmp_path):
    impacts.write_impacts(tmp_path / "i.csv", np.empty(0, impacts.COLUMNS), {})
    assert len(impacts.read_impacts(tmp_path / "i.csv")[0]) == 0


@pytest.mark.parametrize("cut", [1, 40, 3000])
def test_truncated_is_refused_unless_asked(log, tmp_path, cut):
    path = tmp_path / "impacts.csv"
    impacts.write_impacts(path, log, {})
    text = path.read_text()[: -len("# end n=50\n")]
    path.write_text(text[:-cut])
    with pytest.raises(InputError, match="truncated"):
        impacts.read_impacts(path)
    rows, _ = impacts.read_impacts(path, allow_truncated=True)
    assert 0 < len(rows) < 50 and rows.tobytes() == log[: len(rows)].tobytes()


def test_damage_and_foreign_files_are_refused(log, tmp_path):
    path = tmp_path / "impacts.csv"
    impacts.write_impacts(path, log, {})
    good = path.read_text()
    lines = good.split("\n")
    for text, reason in [
        ("\n".join(lines[:10] + lines[11:]), "damaged.*n=50"),
        (good + "1,2,3", "damaged"),
        (good.replace("schema 1", "schema 2"), "no impact log of schema 1"),
        (good.replace("vz_in_m_s", "vz"), "columns are"),
        (good.replace("impact log", "shot arrivals"), "no impact log"),
        (good.replace(lines[6], "junk," + lines[6].split(",", 1)[1]), "cannot be read"),
        ("", "no impact log"),
    ]:
        path.write_text(text)
        with pytest.raises(InputError, match=reason):
            impacts.read_impacts(path)
    with pytest.raises(InputError, match="no such file"):
        impacts.read_impacts(tmp_path / "none.csv")


def test_unfinished_writer_leaves_only_a_part(log, tmp_path):
    path = tmp_path / "impacts.csv"
    impacts.write_impacts(path, log[:5], {})  # an older run's log must not survive a failed new one
    writer = impacts.impact_writer(path, {"model": "dem"})
    writer.write(log[:20].tolist())
    writer.abandon()
    assert not path.exists()
    rows, header = impacts.read_impacts(writer.part, allow_truncated=True)
    assert rows.tobytes() == log[:20].tobytes() and header["model"] == "dem"


def test_numbers_of_the_stream():
    rows = np.zeros(4, impacts.COLUMNS)
    rows["shot_id"] = [3, 5, 3, 7]  # shot 3 strikes twice: its second impact is no first one
    rows["collisions_before"] = [0, 2, 1, 0]
    rows["vz_in_m_s"], rows["nz"] = [-60.0, -30.0, -10.0, -60.0], 1.0
    got = impacts.stream_numbers(rows, 60.0)
    assert got["impacts"] == 4 and got["mean_normal_speed_m_s"] == 40.0
    assert got["collided_fraction"] == pytest.approx(1 / 3)
    assert got["mean_normal_energy_fraction"] == pytest.approx((1 + 0.25 + 1 / 36 + 1) / 4)
    assert impacts.stream_numbers(rows[:0], 60.0)["collided_fraction"] is None
    rows["nozzle_id"] = [0, 1, 0, 1]  # each against its own nozzle: 60, 30 m/s
    got = impacts.stream_numbers(rows, [60.0, 30.0])
    assert got["mean_normal_energy_fraction"] == pytest.approx((1 + 1 + 1 / 36 + 4) / 4)


def test_normal_and_tangential_parts_of_a_velocity():
    """(3, 0, -4) on a slope whose normal is (.6, 0, .8): 1.4 into it, the rest along (.8, 0, -.6)."""
    rows = np.zeros(1, impacts.COLUMNS)
    rows["vx_in_m_s"], rows["vz_in_m_s"], rows["nx"], rows["nz"] = 3.0, -4.0, 0.6, 0.8
    assert impacts.normal_speed_m_s(rows) == pytest.approx(1.4)
    assert impacts.tangential_velocity_m_s(rows)[0] == pytest.approx([4.8 * 0.8, 0.0, -4.8 * 0.6])


@pytest.mark.parametrize("speed", [0.0, 3.0, np.nan])
def test_an_impact_that_does_not_move_into_the_target_is_refused(log, tmp_path, speed):
    log["vx_in_m_s"][4] = log["vy_in_m_s"][4] = log["nx"][4] = log["ny"][4] = 0.0
    log["nz"][4], log["vz_in_m_s"][4] = 1.0, speed
    impacts.write_impacts(tmp_path / "i.csv", log, {})
    with pytest.raises(InputError, match="against its normal"):
        impacts.read_impacts(tmp_path / "i.csv")


@pytest.mark.parametrize("length", [0.0, 0.9, np.nan])
def test_a_normal_that_is_no_unit_vector_is_refused(log, tmp_path, length):
    for name in ("nx", "ny", "nz"):
        log[name][7] *= length
    impacts.write_impacts(tmp_path / "i.csv", log, {})
    with pytest.raises(InputError, match="impact .* has a normal of length"):
        impacts.read_impacts(tmp_path / "i.csv")
