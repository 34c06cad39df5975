"""One small study by every executor: this process's own workers, Snakemake on this machine, Snakemake and a real SLURM.

    python tests/cluster/check_cluster.py [--json FILE]      (make check-cluster; needs make slurm-up)

The tables must be the same bytes; each run must have been a job of SLURM's; done again, nothing may be computed.
"""

from __future__ import annotations

import os
import shutil
from pathlib import Path

from glue.checkrows import Rows
from glue.solvers import repo_root, run_module
from glue.study.sweep import cluster
from glue.study.sweep.records import JOURNAL

STUDY = Path(__file__).with_name("six.toml")
PLACE = repo_root() / "build" / "cluster"
SLURM = repo_root() / "build" / "slurm"
PROFILE = PLACE / "profile"  # the shipped one for a machine of few cores
RUNS = 6
WAYS = {
    "local": [],
    "snakemake": ["--executor", "snakemake"],
    "slurm": ["--executor", "snakemake", "--profile", PROFILE],
}


def main() -> None:
    rows = Rows("One study, three executors")
    os.environ |= {"SLURM_CONF": str(SLURM / "slurm.conf"), "PATH": f"{SLURM / 'bin'}:{os.environ['PATH']}"}
    shutil.copytree(cluster.SNAKEFILE.parent / "profiles" / "slurm", PROFILE, dirs_exist_ok=True)
    with open(PROFILE / "config.v8+.yaml", "a", encoding="utf-8") as file:
        file.write(f"max-threads: {os.cpu_count()}\n")
    tables = {}
    for way, options in WAYS.items():
        out = PLACE / way
        shutil.rmtree(out, ignore_errors=True)
        before = _submitted()
        ended = _sweep(out, options, PLACE / f"{way}.log")
        rows.true(f"{way}: every run done", ended.exit_code == 0, f"{ended.wall_s:.0f} s wall, exit code {ended.exit_code}")
        tables[way] = _read(out / "table.csv")
        if way != "local":
            rows.true(f"{way}: same table as local", bool(tables[way]) and tables[way] == tables["local"], f"{len(tables[way])} bytes")
        if way == "slurm":
            jobs = _submitted() - before
            rows.true("slurm: a job for each run and one for the dimples", jobs == RUNS + 1, f"{jobs} jobs submitted")
    journal = _read(PLACE / "snakemake" / JOURNAL)
    ended = _sweep(PLACE / "snakemake", WAYS["snakemake"], PLACE / "again.log")
    again = ended.exit_code == 0 and _read(PLACE / "snakemake" / JOURNAL) == journal
    rows.true("snakemake: done again, no stage starts", again, f"{ended.wall_s:.0f} s wall")
    rows.finish()


def _sweep(out: Path, options: list, log: Path):
    return run_module("glue", ["sweep", STUDY, "--out", out, *options], log=log)


def _read(file: Path) -> bytes:
    return file.read_bytes() if file.is_file() else b""


def _submitted() -> int:
    """Batch jobs that SLURM's controller has accepted so far."""
    return _read(SLURM / "slurmctld.log").count(b"_slurm_rpc_submit_batch_job: JobId=")


if __name__ == "__main__":
    main()
