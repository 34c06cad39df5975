"""Which of its kernels Debian's OpenBLAS should take.

It chooses by the processor's model number, and a release older than the processor falls back to its oldest kernels (SSE3).
Measured with OpenBLAS 0.3.21 on a Xeon of 2023, where it took "Prescott": a contact block of 95 thousand unknowns was
set up in 44 s and solved an impact in 9-11 s; with the kernels for the processor's instructions 18 s and 6-7 s.  To see
it: OPENBLAS_CORETYPE=Prescott before a command.
"""

from __future__ import annotations

import os
from pathlib import Path

# OpenBLAS's name for kernels, and the instructions (Linux's names) that they use; best first.
_KERNELS = (
    ("SkylakeX", {"avx512f", "avx512cd", "avx512bw", "avx512dq", "avx512vl"}),
    ("Haswell", {"avx2", "fma"}),
    ("Sandybridge", {"avx"}),
)


def blas_environment(cpuinfo: Path = Path("/proc/cpuinfo")) -> dict[str, str]:
    """{"OPENBLAS_CORETYPE": …} by the processor's instructions; {} where they are not told or the user has chosen."""
    if "OPENBLAS_CORETYPE" in os.environ:
        return {}
    try:
        lines = cpuinfo.read_text(errors="replace").splitlines()
    except OSError:
        return {}
    has = next((set(line.partition(":")[2].split()) for line in lines if line.startswith("flags")), set())
    return next(({"OPENBLAS_CORETYPE": name} for name, needed in _KERNELS if needed <= has), {})
