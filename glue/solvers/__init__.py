"""Finds, runs and diagnoses YADE and FreeFem++: the only package that spawns processes."""

from glue.solvers.doctor import Row, doctor
from glue.solvers.find import find_freefem, find_yade, repo_root, versions
from glue.solvers.freefem import build_plugin, compile_freefem, plugin_dir, run_freefem
from glue.solvers.process import Finished, watch
from glue.solvers.python import run_module
from glue.solvers.yade import run_yade

__all__ = [
    "Finished", "Row", "build_plugin", "compile_freefem", "doctor", "find_freefem", "find_yade",
    "plugin_dir", "repo_root", "run_freefem", "run_module", "run_yade", "versions", "watch",
]  # fmt: skip
