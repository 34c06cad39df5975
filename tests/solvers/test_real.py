"""The two codes really run, and the traps that the runner is built around are still there."""

from __future__ import annotations

import time

import pytest

from glue.errors import SolverFailed
from glue.solvers import build_plugin, compile_freefem, doctor, plugin_dir, run_freefem, run_yade, versions
from glue.solvers.process import watch

pytestmark = pytest.mark.solver

DONE = '{ ofstream status("status"); status << "ok" << endl; }\n'


def freefem(folder, text):
    (folder / "job.edp").write_text(text)
    return run_freefem(folder / "job.edp", cwd=folder, log=folder / "log", status=folder / "status")


def test_doctor_finds_nothing_wrong():
    assert [row for row in doctor() if not row.ok] == []


def test_versions_tell_binary_and_package():
    found = versions()
    for code in ("yade", "freefem"):
        assert found[code]["binary"] and found[code]["package"]


def test_include_and_plugin_paths_are_set(tmp_path):
    freefem(tmp_path, 'load "msh3"\nload "peen_kernels"\ninclude "getARGV.idp"\n' + DONE)


def test_singular_matrix_is_refused_although_freefem_ends_with_0(tmp_path):
    with pytest.raises(SolverFailed, match="singular matrix"):
        freefem(tmp_path, 'load "UMFPACK64"\n' "matrix B = [[0, 0], [0, 1]]; set(B, solver = UMFPACK);\n"
                          "real[int] r(2), q(2); r = 1; q = B^-1*r; cout << q << endl;\n" + DONE)  # fmt: skip


def test_lines_come_as_they_are_printed(tmp_path):
    """FreeFem++ alone gives a pipe all its output at the end: then no progress could be shown."""
    (tmp_path / "job.edp").write_text(
        'cout << "first" << endl;\nexec("sleep 0.5");\ncout << "second" << endl;\n' + DONE
    )
    when = {}
    run_freefem(tmp_path / "job.edp", cwd=tmp_path, log=tmp_path / "log", status=tmp_path / "status",
                on_line=lambda line: when.setdefault(line, time.monotonic()))  # fmt: skip
    assert when["second"] - when["first"] > 0.4


@pytest.mark.parametrize(
    ("text", "cause"),
    [
        ("real[int] a(2);\na[5] = 1;\n", "array index out of bounds at line 2"),
        ("assert(1 == 0);\n", "assertion of the script failed at line 1"),
        ('load "nonesuch"\n', "plugin nonesuch was not found"),
        ('include "nonesuch.idp"\n', "include file nonesuch.idp was not found"),
        ('ofstream f("/nonesuch/x"); f << 1;\n', "cannot open the file /nonesuch/x"),
        ('mesh T("nonesuch.msh");\n', "cannot open the mesh file nonesuch.msh"),
        ("real x = 1\nreal y = 2;\n", "does not compile"),
        ("exit(7);\n", "exit code 7"),
    ],
)
def test_failures_are_recognised(tmp_path, text, cause):
    with pytest.raises(SolverFailed) as caught:
        freefem(tmp_path, text)
    assert cause in caught.value.cause


def test_compile_only(tmp_path):
    (tmp_path / "good.edp").write_text("real x = 1; exit(3);\n")  # compiled, not run
    compile_freefem(tmp_path / "good.edp")
    (tmp_path / "bad.edp").write_text("real x = nonesuch;\n")
    with pytest.raises(SolverFailed, match="bad.edp does not compile"):
        compile_freefem(tmp_path / "bad.edp")


def test_kernel_is_built_once_and_its_errors_are_shown(tmp_path):
    good = tmp_path / "twice.cpp"
    good.write_text('#include "ff++.hpp"\n// ff-c++: -lm\ndouble twice(double x) { return 2 * x; }\n'
                    "static void load() {"
                    ' Global.Add("twice", "(", new OneOperator1<double, double>(twice)); }\n'
                    "LOADFUNC(load)\n")  # fmt: skip
    folder = build_plugin(sources=tmp_path)
    try:
        assert [p.name for p in folder.iterdir()] == ["twice.so"]
        with watch() as ended:
            assert build_plugin(sources=tmp_path) == folder
        assert ended == []  # nothing compiled the second time
        good.write_text(good.read_text() + "int x = ;\n")
        assert plugin_dir(tmp_path) != folder
        with pytest.raises(SolverFailed, match="twice.cpp:6:9: expected primary-expression"):
            build_plugin(sources=tmp_path)
        assert not plugin_dir(tmp_path).exists()
    finally:
        (folder / "twice.so").unlink()
        folder.rmdir()


def test_yade_ends_with_the_scripts_failure(tmp_path):
    script = tmp_path / "job.py"
    script.write_text("raise ValueError('no such shot')\n")
    with pytest.raises(SolverFailed, match="ValueError: no such shot"):
        run_yade(script, [], cwd=tmp_path, log=tmp_path / "log", timeout_s=60)
