"""The kernels that OpenBLAS is told to take follow the processor's instructions, and the user's word goes before."""

import pytest

from glue.solvers.blas import blas_environment


@pytest.mark.parametrize(
    ("flags", "kernels"),
    [("sse2 avx avx2 fma avx512f avx512cd avx512bw avx512dq avx512vl", "SkylakeX"), ("avx avx2 fma avx512f", "Haswell"), ("avx", "Sandybridge")],
)
def test_best_kernels_for_the_instructions(flags, kernels, tmp_path, monkeypatch):
    monkeypatch.delenv("OPENBLAS_CORETYPE", raising=False)
    (tmp_path / "cpuinfo").write_text(f"processor\t: 0\nflags\t\t: fpu {flags}\n")
    assert blas_environment(tmp_path / "cpuinfo") == {"OPENBLAS_CORETYPE": kernels}


def test_nothing_is_said_of_what_is_not_known_or_chosen(tmp_path, monkeypatch):
    monkeypatch.delenv("OPENBLAS_CORETYPE", raising=False)
    (tmp_path / "cpuinfo").write_text("Features\t: asimd\n")
    assert blas_environment(tmp_path / "cpuinfo") == blas_environment(tmp_path / "none") == {}
    monkeypatch.setenv("OPENBLAS_CORETYPE", "Zen")
    (tmp_path / "cpuinfo").write_text("flags\t\t: avx avx2 fma\n")
    assert blas_environment(tmp_path / "cpuinfo") == {}
