"""What YADE's scripts import must run on Debian's Python with its numpy as well as here."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from glue.solvers import repo_root

# Imports every shared module, then uses the ones that compute or parse; prints what must agree.
PROGRAM = """
import sys
before = set(sys.modules)
import hashlib, importlib, pathlib, tempfile
import numpy as np
import glue.atomic, glue.errors
root = pathlib.Path(glue.__file__).parent if glue.__file__ else None
for folder in ("scene", "theory"):
    for file in sorted((root / folder).glob("*.py")):
        importlib.import_module(f"glue.{folder}.{file.stem}")
from glue.flow import arrivals, impacts, table
from glue.scene.reader import example_names, example_path, read_scene, resolved_dict
from glue.theory.avrami import coverage_rate_form
# numpy 1.24's random generators bring the two Cython ones.
allowed = {"glue", "numpy", "cython_runtime", "_cython_0_29_32"} | set(sys.stdlib_module_names)
strangers = {m.split(".")[0] for m in set(sys.modules) - before} - allowed
print("strangers", sorted(strangers))
for name in example_names():
    print(name, hashlib.sha256(repr(resolved_dict(read_scene(example_path(name), provisional=True))).encode()).hexdigest())
scene = read_scene(example_path("al2024-s390"))
shots = arrivals.draw_arrivals(scene)
print(len(shots), shots["time_s"][:5].tolist(), shots["x_m"][-1])
with tempfile.TemporaryDirectory() as folder:
    path = pathlib.Path(folder) / "impacts.csv"
    log = np.zeros(3, impacts.COLUMNS)
    log["vz_in_m_s"], log["nz"] = -1.0, 1.0
    log["x_m"] = [0.1, 1 / 3, -2e-300]
    impacts.write_impacts(path, log, {"scene_hash": "0", "model": "none"})
    print(impacts.read_impacts(path)[0]["x_m"].tolist())
print(float(coverage_rate_form(1e-8, 1e7, 2.0)))
"""


def _output(python: str) -> str:
    env = {**os.environ, "PYTHONPATH": str(repo_root()), "PYTHONDONTWRITEBYTECODE": "1"}
    done = subprocess.run([python, "-c", PROGRAM], env=env, capture_output=True, text=True, cwd="/")
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.solver
def test_debians_python_gives_the_same_numbers():
    assert Path("/usr/bin/python3").exists()
    assert _output("/usr/bin/python3") == _output(sys.executable)


def test_shared_modules_import_only_numpy_and_the_standard_library():
    assert _output(sys.executable).splitlines()[0] == "strangers []"
