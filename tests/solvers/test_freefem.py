"""Every way in which FreeFem++ may fail, played by stubs."""

from __future__ import annotations

import pytest

from glue.errors import NotConverged, SolverFailed
from glue.solvers import run_freefem

OK = "Path('status').write_text('ok\\nresidual 1e-12\\n')"


@pytest.fixture
def run(tmp_path, stub):
    """run(stub's code) as the driver ``job.edp`` in ``tmp_path``."""

    def go(code: str, **options):
        stub("PEEN_FREEFEM", code)
        (tmp_path / "job.edp").write_text("")
        return run_freefem(
            tmp_path / "job.edp",
            cwd=tmp_path,
            log=tmp_path / "job.log",
            status=tmp_path / "status",
            **options,
        )

    return go


def test_a_good_run_tells_its_cost_and_its_lines(run, tmp_path):
    lines = []
    done = run(f"print('one'); print('two', end=''); {OK}", on_line=lines.append)
    assert (done.exit_code, lines) == (0, ["one", "two"])
    assert done.log == tmp_path / "job.log"
    assert done.wall_s > 0
    assert done.peak_memory_bytes > 4e6  # a Python interpreter cannot be smaller


def test_arguments_and_environment(run, tmp_path):
    run(
        f"print(sys.argv[1:]); print(os.environ['FF_LOADPATH'], os.environ['OMP_NUM_THREADS']); {OK}",
        defines=["-n", "3"],
    )
    typed, argv, variables = (tmp_path / "job.log").read_text().splitlines()
    assert typed.startswith("$ cd ") and "job.edp -n 3" in typed
    assert argv == str(["-nw", "-ne", "-v", "0", str(tmp_path / "job.edp"), "-n", "3"])
    assert variables.endswith(";/usr/lib/freefem++ 1")


@pytest.mark.parametrize(
    ("code", "cause", "advice"),
    [
        ("print('current line'); sys.exit(8)", "exit code 8 (assertion", "log"),
        (
            "print('Load error : msh3\\n\\tline number :1, msh3'); sys.exit(2)",
            "plugin msh3 was not found",
            "make setup",
        ),
        (
            "print('Load error : peen_kernels'); sys.exit(2)",
            "kernel peen_kernels was not found",
            "make plugin",
        ),
        (
            "print('lex: Error input opening file \\n\\tline number :3, a.idp'); sys.exit(1)",
            "include file a.idp",
            "freefem/lib",
        ),
        ("print('  current line = 41\\nExec error : exec assert'); sys.exit(8)", "failed at line 41", "log"),
        (
            "print('  current line = 7\\nExec error : Out of bound in operator []'); sys.exit(8)",
            "out of bounds at line 7",
            "again",
        ),
        (
            "print('Erreur ouverture du fichier a.mesh'); sys.exit(8)",
            "cannot open the mesh file a.mesh",
            "complete",
        ),
        (
            "print(\"terminate called after 'std::bad_alloc'\"); os.kill(os.getpid(), signal.SIGABRT)",
            "out of memory",
            "stopped",
        ),
        ("os.kill(os.getpid(), signal.SIGKILL)", "killed by signal 9 (SIGKILL)", "memory"),
        ("os.kill(os.getpid(), signal.SIGSEGV)", "killed by signal 11 (SIGSEGV)", "doctor"),
        ("pass", "exit code 0, but it did not write status", "how far"),
        ("Path('status').write_text('')", "begins with ''", "disk full"),
        ("Path('status').write_text('okay')", "begins with 'okay'", "log"),
        ("Path('status').write_text('ok\\nforce nan\\n')", "not finite", "smaller step"),
        ("Path('status').write_text('ok\\nforce -inf\\n')", "not finite", "smaller step"),
        (
            f"print(' Error umpfack umfpack_di_numeric  status  1'); {OK}",
            "singular matrix (umfpack_di_numeric, status 1)",
            "boundary",
        ),
    ],
)
def test_failures_name_their_cause_and_what_to_try(run, tmp_path, code, cause, advice):
    with pytest.raises(SolverFailed) as caught:
        run(code)
    problem = caught.value
    assert type(problem) is SolverFailed and problem.exit_code == 3
    assert cause in problem.cause
    assert advice in problem.advice
    assert str(tmp_path / "job.log") in str(problem)


def test_words_with_nan_or_inf_in_them_are_no_numbers(run):
    run("Path('status').write_text('ok\\ninfo: nanometres, inform, x.inf.y\\n')")


@pytest.mark.parametrize("code", ["", "; sys.exit(5)"])
def test_a_driver_that_says_failed_did_not_converge(run, code):
    with pytest.raises(NotConverged) as caught:
        run(f"Path('status').write_text('failed: 40 step halvings at t = 3e-7\\n'){code}")
    assert caught.value.cause == "40 step halvings at t = 3e-7"
    assert caught.value.exit_code == 4


def test_an_older_status_does_not_speak_for_this_run(run, tmp_path):
    (tmp_path / "status").write_text("ok\n")
    with pytest.raises(SolverFailed, match="did not write status"):
        run("pass")


def test_last_lines_of_the_log_are_shown(run):
    with pytest.raises(SolverFailed) as caught:
        run("print('\\n'.join(f'line {i}' for i in range(100))); sys.exit(1)")
    assert caught.value.tail.splitlines() == [f"line {i}" for i in range(88, 100)]


def test_time_limit_kills_the_whole_group(run, tmp_path):
    # The stub's child would write its file 1 s later if it outlived its parent.
    child = "import time; time.sleep(1); open('alive', 'w')"
    with pytest.raises(SolverFailed, match="not finished after 0.3 s"):
        run(
            f"import subprocess; subprocess.Popen([sys.executable, '-c', {child!r}]); time.sleep(60)",
            timeout_s=0.3,
        )
    import time

    time.sleep(1.3)
    assert not (tmp_path / "alive").exists()


def test_a_failing_callback_stops_the_solver(run, tmp_path):
    def refuse(line):
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        run("print('x', flush=True); time.sleep(1); open('alive', 'w')", on_line=refuse)
    assert not (tmp_path / "alive").exists()


def test_missing_binary(tmp_path, monkeypatch):
    monkeypatch.setenv("PEEN_FREEFEM", str(tmp_path / "nothing"))
    with pytest.raises(SolverFailed, match="PEEN_FREEFEM=.* is not a program"):
        run_freefem(tmp_path / "a.edp", cwd=tmp_path, log=tmp_path / "log", status=tmp_path / "status")
    monkeypatch.delenv("PEEN_FREEFEM")
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(SolverFailed, match="make setup .Debian package freefem"):
        run_freefem(tmp_path / "a.edp", cwd=tmp_path, log=tmp_path / "log", status=tmp_path / "status")
