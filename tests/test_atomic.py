import os
import signal
import subprocess
import sys

import pytest

from glue.atomic import atomic_path, write_text_atomic


def test_writes_exactly_the_text(tmp_path):
    write_text_atomic(tmp_path / "new" / "a.txt", "µ\r\nline\n")
    assert (tmp_path / "new" / "a.txt").read_bytes() == "µ\r\nline\n".encode()
    assert os.listdir(tmp_path / "new") == ["a.txt"]


@pytest.mark.parametrize("problem", [ValueError, KeyboardInterrupt])
def test_a_failed_write_leaves_the_old_file_and_no_part(tmp_path, problem):
    final = tmp_path / "a.txt"
    final.write_text("old")
    with pytest.raises(problem), atomic_path(final) as part:
        part.write_text("half")
        raise problem
    assert final.read_text() == "old"
    assert os.listdir(tmp_path) == ["a.txt"]


def test_a_block_that_writes_nothing_is_an_error(tmp_path):
    with pytest.raises(FileNotFoundError), atomic_path(tmp_path / "a.txt"):
        pass
    assert os.listdir(tmp_path) == []


def test_a_kill_in_the_middle_leaves_nothing_under_the_final_name(tmp_path):
    code = (
        "import sys, time; from pathlib import Path; from glue.atomic import atomic_path\n"
        "with atomic_path(Path(sys.argv[1])) as part:\n"
        "    part.write_text('half'); print('written', flush=True); time.sleep(60)\n"
    )
    child = subprocess.Popen([sys.executable, "-c", code, tmp_path / "a.txt"], stdout=subprocess.PIPE)
    assert child.stdout.readline() == b"written\n"
    child.send_signal(signal.SIGKILL)
    child.wait()
    child.stdout.close()
    assert not (tmp_path / "a.txt").exists()
