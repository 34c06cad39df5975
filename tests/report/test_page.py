"""The report page: complete, self-contained, and safe against what a scene may be called."""

from __future__ import annotations

import base64
import json
import re
from dataclasses import MISSING, fields
from html.parser import HTMLParser

import numpy as np
import pytest

from glue.errors import InputError
from glue.flow.impacts import COLUMNS, write_impacts
from glue.flow.arrivals import scene_hash
from glue.report.page import page, write_report
from glue.report.scene_rows import scene_rows
from glue.scene.reader import example_path, read_scene
from glue.study.pieces import Piece
from glue.target.dimple import Dimple

PNG = b"\x89PNG\r\n\x1a\nnot a real picture"
METRICS = {
    "schema": 1,
    "coverage": {"final": 0.9912, "time_98_s": None, "time_98_s_reason": "ends at <.98"},
    "residual_stress": {"surface_Pa": -233.4e6, "max_compressive_depth_m": 1.07e-4},
    "roughness": {"Sa_m": 1.234e-6, "levelling": "plane", "filter": "none"},
}
MANIFEST = {
    "scene": "<b>bold</b> & co",
    "seed": 7,
    "choices": {"flow": {"model": "dem", "why": "collision number 0.3 > 0.01"}},
    "defaults_used": ["friction.shot_target = 0.2 (source)"],
    "stages": {"flow": {"state": "complete", "wall_s": 12.34, "peak_memory_bytes": 2e8}},
}


class Balance(HTMLParser):
    """Checks that tags close in order; collects text and addresses."""

    def __init__(self):
        super().__init__()
        self.open, self.text, self.links = [], [], []

    def handle_starttag(self, tag, attrs):
        self.links += [value for key, value in attrs if key == "src"]
        if tag not in ("meta", "img", "link", "input", "rect", "path", "circle", "ellipse"):
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        pass

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text.append(data)


def read(html):
    parser = Balance()
    parser.feed(html)
    assert parser.open == []
    return parser, " ".join(parser.text)


def test_numbers_units_reasons_and_choices_are_on_the_page():
    parser, text = read(page([("Speed", "60 m/s")], MANIFEST, METRICS, [("One dimple", "its section", PNG)]))
    for words in (
        "99.12 %", "not determined: ends at <.98", "−233", "107", "1.23 µm", "plane", "60 m/s",
        "seed 7", "collision number 0.3 > 0.01", "friction.shot_target = 0.2 (source)", "12.3 s", "200 MB",
        "its section",
    ):  # fmt: skip
        assert words in text, words
    assert "<b>bold</b> & co" in text  # as text, not as markup


def test_page_needs_nothing_from_outside_and_may_ask_for_nothing():
    html = page([], MANIFEST, METRICS, [("t", "c", PNG)])
    parser, _ = read(html)
    assert parser.links == ["data:image/png;base64," + base64.b64encode(PNG).decode()]
    assert "http:" not in html and "https:" not in html
    assert "default-src 'none'" in html


def test_an_interval_is_shown_with_its_causes_in_the_printed_unit():
    found = {"value": -233.4e6, "half_width_95": 50e6, "mostly": "numerical", "by_cause": {
        "statistical": 3e6, "numerical": 49.91e6, "material_law": 0.0, "restitution_friction": None}}  # fmt: skip
    html = page([], MANIFEST, METRICS | {"uncertainty": {"residual_stress.surface_Pa": found}}, [])
    start = html.index("at the surface")
    row = html[start : html.index("</tr>", start)]
    assert re.findall(r">([^<]+)</td>", row) == ["−233", "50", "MPa", "3", "50", "0", "unknown"]
    assert 'data-raw="-233.4"' in row  # what the copy button takes


def test_physics_left_out_although_it_matters_is_marked():
    left_out = Piece("drag", "change of a shot's energy", 0.3, 0.01, "make thresholds", "off", "no such block", "nothing")
    _, text = read(page([], MANIFEST, METRICS, [], pieces=[left_out]))
    assert "off (!)" in text and "0.3" in text


def test_page_of_a_run_that_has_just_begun():
    _, text = read(page([], {}, {"schema": 1}, []))
    assert "No stage has finished" in text


def test_scene_rows_of_the_default_scene():
    rows = dict(scene_rows(read_scene(example_path("al2024-s390"))))
    assert rows["Speed"] == "60 m/s"
    assert rows["Window"] == "4 × 4 mm"
    assert rows["Impact angle"].startswith("90°")


@pytest.fixture
def run(tmp_path):
    """A run directory as the stages leave it, with few numbers in it."""
    r = np.linspace(0.0, 2e-3, 60)
    arrays = {
        "profile_r_m": r,
        "profile_z_m": -5e-5 * np.exp(-((r / 0.2e-3) ** 2)),
        "layer_depth_m": np.zeros(2),
        "layer_stress_Pa": np.zeros(2),
        "points_m": np.array([[0.0, 0.0], [2e-3, 0.0], [0.0, -2e-3]]),
        "triangles": np.array([[0, 1, 2]]),
        "peeq": np.array([0.1]),
        "sigma_rr_Pa": np.zeros(1),
    }
    numbers = {
        "radius_m": 0.2e-3,
        "diameter_m": 1e-3,
        "speed_m_s": 60.0,
        "contact_time_s": 2e-6,
        "speed_exponent": 0.5,
        "restitution_exponent": 0.25,
        "density_kg_m3": 7800.0,
    }
    values = {f.name: arrays.get(f.name, numbers.get(f.name, 1.0)) for f in fields(Dimple) if f.default_factory is MISSING and f.default is MISSING}  # fmt: skip
    Dimple(**values).save(tmp_path / "dimple" / "dimple.npz")
    impacts = np.zeros(9, dtype=COLUMNS)
    impacts["x_m"], impacts["time_s"] = np.linspace(-2e-3, 2e-3, 9), np.arange(9) / 3
    impacts["diameter_m"], impacts["vz_in_m_s"] = 1e-3, -60.0
    impacts["density_kg_m3"], impacts["nz"] = 7800.0, 1.0
    (tmp_path / "flow").mkdir(exist_ok=True)
    write_impacts(tmp_path / "flow" / "impacts.csv", impacts, {"scene_hash": scene_hash(read_scene(example_path("al2024-s390")))})
    (tmp_path / "coverage.csv").write_text("time_s,coverage,avrami\n0,0,0\n1.5,0.4,0.5\n3,0.99,0.98\n")
    (tmp_path / "stress_profile.csv").write_text(
        "depth_m,sigma_xx_Pa,sigma_yy_Pa,peeq,sigma_xx_std_Pa,sigma_yy_std_Pa\n"
        "0.00002,-2e8,-2e8,0.2,1e7,1e7\n0.0003,1e7,1e7,0,1e6,1e6\n"
    )
    grid = np.arange(5) * 1e-4
    np.savez(
        tmp_path / "surface.npz", x_m=grid, y_m=grid, z_m=1e-6 * np.random.default_rng(0).normal(size=(5, 5))
    )
    (tmp_path / "metrics.json").write_text(json.dumps(METRICS | {"roughness": {"Sa_m": 1e-6, "Sz_m": 5e-6}}))
    (tmp_path / "manifest.json").write_text(json.dumps(MANIFEST))
    return tmp_path


ALL = {
    "figures/impact_map.png": {"dimple", "flow"},
    "figures/coverage.png": {"dimple", "coverage"},
    "figures/residual_stress.png": {"target"},
    "figures/height_map.png": {"surface"},
    "figures/dimple.png": {"dimple"},
}


@pytest.mark.parametrize(
    "complete", [{"dimple", "flow", "coverage", "target", "surface"}, {"flow", "target"}, set()]
)
def test_report_of_what_there_is(run, complete):
    scene = read_scene(example_path("al2024-s390"))
    written = write_report(run, scene, frozenset(complete))
    expected = {name for name, needs in ALL.items() if needs <= complete}
    assert set(written) == expected | {"report.html"}
    assert all((run / name).stat().st_size > 1000 for name in written)
    parser, _ = read((run / "report.html").read_text(encoding="utf-8"))
    assert len(parser.links) == len(expected)


def test_a_damaged_file_is_named(run):
    (run / "dimple" / "dimple.npz").write_bytes(b"nonsense")
    with pytest.raises(InputError, match="dimple.npz"):
        write_report(run, read_scene(example_path("al2024-s390")), frozenset({"dimple"}))
