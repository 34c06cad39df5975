"""Initial stress for other codes: what is written, and that CalculiX reads it as it is meant."""

from __future__ import annotations

import os
import re
import shutil
import subprocess

import numpy as np
import pytest

from glue.errors import InputError
from glue.inp_mesh import read_inp
from glue.report.initial_stress import held_profile, write_initial_stress
from glue.scene.reader import example_path, read_scene
from glue.theory.plate import released_stress

HELD = {
    "depth_m": np.array([0.0, 1e-4, 2e-4, 5e-4]),
    "sigma_xx_Pa": np.array([-200e6, -300e6, -100e6, 0.0]),
    "sigma_yy_Pa": np.array([-100e6, -250e6, -50e6, 0.0]),
}
# A brick 1 x 1 mm and 0.4 mm high, its corners in Abaqus's order, and the middles of its edges after them.
_AROUND = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
_EDGES = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
_TET_EDGES = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]
_SIZE = np.array([1.0, 1.0, 0.4])

needs_calculix = pytest.mark.skipif(
    shutil.which("ccx") is None and os.environ.get("PEEN_REQUIRE_TOOLS") != "1",
    reason="CalculiX is not installed (apt-get install calculix-ccx)",
)


def nodes_of(kind):
    """Nodes [mm] of one element of that kind in the brick."""
    corners = np.array(_AROUND, float) if "8" in kind or "20" in kind else np.array([_AROUND[k] for k in (0, 1, 3, 4)], float)
    edges = {"C3D20": _EDGES, "C3D20R": _EDGES, "C3D10": _TET_EDGES}.get(kind, [])
    return _SIZE * np.array([*corners, *(0.5 * (corners[a] + corners[b]) for a, b in edges)])


def write_mesh(path, kind, scale=1.0):
    """One element, number 7, whose nodes start at 11; returns the nodes' numbers."""
    nodes = nodes_of(kind) * scale
    numbers = range(11, 11 + len(nodes))
    lines = ["** a part", "*Node, nset=all"]
    lines += [f"{n}, {x:.9g}, {y:.9g}, {z:.9g}" for n, (x, y, z) in zip(numbers, nodes)]
    words = [str(v) for v in (7, *numbers)]
    lines += [f"*ELEMENT, ELSET=part, TYPE={kind}", *(", ".join(words[k : k + 10]) + "," for k in range(0, len(words), 10))]
    path.write_text("\n".join(lines) + "\n")
    return numbers


def rows_of(path):
    return [[float(v) for v in line.split(",")] for line in path.read_text().splitlines() if not line.startswith("*")]


def test_stress_is_that_of_each_points_depth(tmp_path):
    write_mesh(tmp_path / "part.inp", "C3D8")
    told = write_initial_stress(tmp_path / "s.inp", tmp_path / "part.inp", HELD, unit="mm")
    assert told == {"elements": 1, "elements_stressed": 1, "points": 8}
    rows = np.array(rows_of(tmp_path / "s.inp"))
    assert rows[:, 0].tolist() == [7] * 8 and rows[:, 1].tolist() == list(range(1, 9))
    # Gauss points at .2 -+ .2/sqrt 3 mm of height: 0.31547 and 0.08453 mm deep
    deep, shallow = 0.2 + 0.2 / np.sqrt(3), 0.2 - 0.2 / np.sqrt(3)
    assert rows[:4, 2] == pytest.approx(-100 * (0.5 - deep) / 0.3)
    assert rows[4:, 2] == pytest.approx(-200 - 100 * shallow / 0.1)
    assert rows[4:, 3] == pytest.approx(-100 - 150 * shallow / 0.1)
    assert not rows[:, 4:].any()


@pytest.mark.parametrize(("surface", "columns"), [("x-max", (3, 4)), ("y-min", (2, 4)), ("z-min", (2, 3))])
def test_another_surface_turns_depth_and_axes(tmp_path, surface, columns):
    write_mesh(tmp_path / "part.inp", "C3D8R", scale=1e-3)
    held = HELD | {"depth_m": np.array([0.0, 1e-4, 2e-4, 2e-3])}
    write_initial_stress(tmp_path / "s.inp", tmp_path / "part.inp", held, surface=surface)
    (row,) = rows_of(tmp_path / "s.inp")
    assert [k for k in range(2, 8) if row[k]] == list(columns)
    depth = 0.2e-3 if surface == "z-min" else 0.5e-3
    assert row[columns[0]] == pytest.approx(np.interp(depth, held["depth_m"], held["sigma_xx_Pa"]))
    assert row[columns[1]] == pytest.approx(np.interp(depth, held["depth_m"], held["sigma_yy_Pa"]))


def test_abaqus_gets_a_line_an_element(tmp_path):
    write_mesh(tmp_path / "part.inp", "C3D20R")
    write_initial_stress(tmp_path / "s.inp", tmp_path / "part.inp", HELD, unit="mm", code="abaqus")
    (row,) = rows_of(tmp_path / "s.inp")
    write_initial_stress(tmp_path / "c.inp", tmp_path / "part.inp", HELD, unit="mm")
    assert row[1:] == pytest.approx(np.array(rows_of(tmp_path / "c.inp"))[:, 2:].mean(axis=0))


def test_a_mesh_in_mm_read_as_m_is_told(tmp_path):
    write_mesh(tmp_path / "part.inp", "C3D8")
    with pytest.raises(InputError, match="--unit mm"):
        write_initial_stress(tmp_path / "s.inp", tmp_path / "part.inp", HELD)
    assert not (tmp_path / "s.inp").exists()


def test_all_that_is_wrong_with_a_mesh_is_told_at_once(tmp_path):
    write_mesh(tmp_path / "part.inp", "C3D8")
    text = (tmp_path / "part.inp").read_text().replace("18, 0, 1, 0.4\n", "")
    (tmp_path / "part.inp").write_text(text + "*INCLUDE, INPUT=more.inp\n*ELEMENT, TYPE=C3D15\n1, 2\n")
    with pytest.raises(InputError) as caught:
        read_inp(tmp_path / "part.inp")
    assert [re.search(r"INCLUDE|C3D15|first: 18", p).group() for p in caught.value.problems] == ["INCLUDE", "C3D15", "first: 18"]


def test_the_held_stress_is_what_the_plate_had_before_it_was_let_go():
    scene = read_scene(example_path("al2024-s390"))  # a plate of 10 mm
    depth = np.r_[np.linspace(0.0, 1e-3, 30), np.linspace(1.2e-3, 10e-3, 8)]
    before = np.where(depth < 1e-3, -300e6 * np.cos(depth / 1e-3 * np.pi / 2), 0.0)
    free = {"depth_m": depth} | {name: released_stress(depth, before, 10e-3) for name in ("sigma_xx_Pa", "sigma_yy_Pa")}
    assert np.abs(free["sigma_xx_Pa"] - before).max() > 10e6
    assert held_profile(free, scene)["sigma_xx_Pa"] == pytest.approx(before, abs=1e-6 * 300e6)


def test_rounding_below_the_layer_is_no_stress(tmp_path):
    """Held stress of a plate of 10 mm peened 1 mm deep: an element from 0 to 0.4 mm has it, one 5 mm down has none."""
    scene = read_scene(example_path("al2024-s390"))
    depth = np.r_[np.linspace(0.0, 1e-3, 30), np.linspace(1.2e-3, 10e-3, 8)]
    before = np.where(depth < 1e-3, -300e6 * np.cos(depth / 1e-3 * np.pi / 2), 0.0)
    released = released_stress(depth, before, 10e-3)
    free = {"depth_m": depth, "sigma_xx_Pa": released, "sigma_yy_Pa": released}
    held = held_profile(free, scene)
    assert not held["sigma_xx_Pa"][depth > 1e-3].any()
    write_mesh(tmp_path / "part.inp", "C3D8")
    text = (tmp_path / "part.inp").read_text()
    nodes = [line for line in text.splitlines() if line[:1].isdigit() and line.count(",") == 3]
    lower = [f"{int(n) + 10}, {x}, {y}, {float(z) - 5.0:g}" for n, x, y, z in (line.split(",") for line in nodes)]
    element = ", ".join(map(str, (8, *range(21, 29))))
    (tmp_path / "two.inp").write_text(text + "*NODE\n" + "\n".join(lower) + f"\n*ELEMENT, TYPE=C3D8\n{element}\n")
    told = write_initial_stress(tmp_path / "s.inp", tmp_path / "two.inp", held, unit="mm")
    assert told == {"elements": 2, "elements_stressed": 1, "points": 16}
    with pytest.raises(InputError, match="no element lies within 0.001 m"):  # mm read as m
        write_initial_stress(tmp_path / "s.inp", tmp_path / "two.inp", held)


def test_a_plate_that_ends_in_the_peened_layer_is_refused():
    scene = read_scene(example_path("al2024-s390"))
    depth = np.linspace(0.0, 10e-3, 40)
    curved = -300e6 * np.cos(depth * 100.0)
    with pytest.raises(InputError, match="thicker than the peened layer"):
        held_profile({"depth_m": depth, "sigma_xx_Pa": curved, "sigma_yy_Pa": curved}, scene)


@needs_calculix
@pytest.mark.parametrize("kind", ["C3D4", "C3D10", "C3D8", "C3D8R", "C3D20", "C3D20R"])
def test_calculix_prints_the_stress_of_every_integration_point(tmp_path, kind):
    """All displacements held, nothing may change: stress as given, at points where CalculiX itself says they are."""
    numbers = write_mesh(tmp_path / "part.inp", kind)
    write_initial_stress(tmp_path / "initial_stress.inp", tmp_path / "part.inp", HELD, unit="mm")
    (tmp_path / "job.inp").write_text(
        "*INCLUDE, INPUT=part.inp\n*MATERIAL, NAME=alu\n*ELASTIC\n73000., .33\n*SOLID SECTION, ELSET=part, MATERIAL=alu\n"
        "*INCLUDE, INPUT=initial_stress.inp\n*STEP\n*STATIC\n*BOUNDARY\n"
        f"{numbers[0]}, 1, 3\n" + "".join(f"{n}, 1, 3\n" for n in numbers[1:]) + "*EL PRINT, ELSET=part\nS, COORD\n*END STEP\n"
    )
    done = subprocess.run(["ccx", "-i", "job"], cwd=tmp_path, capture_output=True, text=True, timeout=60)
    printed = (tmp_path / "job.dat").read_text()
    assert printed.strip(), done.stdout[-500:]
    stress, places = (np.array([[float(v) for v in line.split()] for line in part.splitlines() if re.match(r"\s+7\s", line)])
                      for part in printed.split("\n stresses")[-1].split("coordinates"))  # fmt: skip
    given = np.array(rows_of(tmp_path / "initial_stress.inp"))
    assert stress[:, :2].tolist() == given[:, :2].tolist()
    assert stress[:, 2:] == pytest.approx(given[:, 2:], rel=2e-6, abs=1e-4)  # seven digits are printed
    depth = 1e-3 * (0.4 - places[:, 4])
    assert stress[:, 2] == pytest.approx(1e-6 * np.interp(depth, HELD["depth_m"], HELD["sigma_xx_Pa"]), rel=1e-5, abs=1e-3)


def write_column(path, heights):
    """A column of C3D20R 1 mm wide from z = 0 up through ``heights`` [mm]; {(2x, 2y, level in halves): node}."""
    levels = np.r_[0.0, heights]
    z = np.interp(np.arange(2 * len(levels) - 1) / 2, np.arange(len(levels)), levels)
    node, elements = {}, []
    for k in range(len(levels) - 1):
        corners = [(2 * x, 2 * y, 2 * (k + up)) for x, y, up in _AROUND]
        middles = [tuple((p + q) // 2 for p, q in zip(corners[a], corners[b])) for a, b in _EDGES]
        for at in (*corners, *middles):
            node.setdefault(at, len(node) + 1)
        elements.append([node[at] for at in (*corners, *middles)])
    lines = ["*NODE, NSET=all", *(f"{n}, {a / 2}, {b / 2}, {z[c]:.12g}" for (a, b, c), n in node.items())]
    lines.append("*ELEMENT, TYPE=C3D20R, ELSET=part")
    for number, row in enumerate(elements, 1):
        lines += [", ".join(map(str, [number, *row[:12]])) + ",", ", ".join(map(str, row[12:]))]
    path.write_text("\n".join(lines) + "\n")
    return node, z


@needs_calculix
def test_calculix_lets_the_plate_go_to_the_runs_own_free_stress(tmp_path):
    """A column through a plate whose sides stay plane, but may move and turn: after a step without load its stress is
    what plate theory made of the same held stress.  The mesh samples a profile with kinks: 1 % of the largest stress."""
    h, layer = 10.0, 0.6
    depth = np.r_[np.linspace(0.0, 1e-3, 41), np.linspace(1.2e-3, 1e-2, 8)]
    before = np.where(depth < 1e-3 * layer, -300e6 * np.cos(0.5 * np.pi * depth / (1e-3 * layer)), 0.0)
    held = {"depth_m": depth, "sigma_xx_Pa": before, "sigma_yy_Pa": before}
    fine = np.linspace(0.0, 1.2 * layer, 37)[1:]
    node, z = write_column(tmp_path / "part.inp", np.r_[np.linspace(0.0, h - 1.2 * layer, 12)[1:], h - 1.2 * layer + fine])
    write_initial_stress(tmp_path / "initial_stress.inp", tmp_path / "part.inp", held, unit="mm")
    top = max(c for _, _, c in node)
    fixed, ties = [f"{node[0, 0, 0]}, 3"], []
    for axis in (0, 1):
        low, high = (tuple(2 if k == axis else 0 for k in (0, 1)) + (c,) for c in (0, top))
        for at, n in node.items():
            if at[axis] == 0:
                fixed.append(f"{n}, {axis + 1}")
            elif at[axis] == 2 and at not in (low, high):
                share = z[at[2]] / h
                terms = ((n, 1.0), (node[low], share - 1.0), (node[high], -share))
                ties += ["*EQUATION", "3", ", ".join(f"{who}, {axis + 1}, {factor:.12g}" for who, factor in terms)]
    (tmp_path / "job.inp").write_text("\n".join([
        "*INCLUDE, INPUT=part.inp", "*MATERIAL, NAME=alu", "*ELASTIC", "73000., .33", "*SOLID SECTION, ELSET=part, MATERIAL=alu",
        *ties, "*BOUNDARY", *fixed, "*INCLUDE, INPUT=initial_stress.inp", "*STEP", "*STATIC", "*EL PRINT, ELSET=part", "S, COORD",
        "*END STEP", "",
    ]))  # fmt: skip
    done = subprocess.run(["ccx", "-i", "job"], cwd=tmp_path, capture_output=True, text=True, timeout=120)
    printed = (tmp_path / "job.dat").read_text()
    assert printed.strip(), done.stdout[-500:]
    stress, places = (np.array([[float(v) for v in line.split()] for line in part.splitlines() if re.match(r"\s+\d+\s+\d", line)])
                      for part in printed.split("\n stresses")[-1].split("coordinates"))  # fmt: skip
    free = np.interp(1e-3 * (h - places[:, 4]), depth, released_stress(depth, before, 1e-2)) * 1e-6
    largest = np.abs(free).max()
    assert np.abs(free - np.interp(1e-3 * (h - places[:, 4]), depth, before) * 1e-6).max() > 0.05 * largest  # it does give way
    assert stress[:, 2] == pytest.approx(free, abs=0.01 * largest)
    assert stress[:, 3] == pytest.approx(free, abs=0.01 * largest)
