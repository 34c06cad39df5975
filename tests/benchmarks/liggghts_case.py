"""The same shot stream for LIGGGHTS: its input script, its run, and what a step of it costs.

The arrivals of our own generator are placed in batches of half a millisecond, each shot upstream of the exit
where its straight flight has it, so that the stream is the same shot by shot; shots are lost when they leave
the box, ``BOX_JET_RADII`` wide (wider than where our own flows drop rising shots, so that as many are alive or
fewer; the mean number is printed).  Hertz-Mindlin with tangential history, true moduli, restitution and
friction per pair, wall at z = 0, one time step throughout: LIGGGHTS has no other.

Only loop times are counted (its "Loop time of"), not set-up, insertion or output.
"""

from __future__ import annotations

import math
import re
import shutil
import subprocess
from pathlib import Path
from typing import NamedTuple

import numpy as np

BATCH_S = 0.5e-3
BOX_JET_RADII = 3.0  # half the box's width over the jet's radius
_LOOP = re.compile(r"Loop time of (\S+) on \d+ procs for (\d+) steps with (\d+) atoms")


class Cost(NamedTuple):
    """What LIGGGHTS took in the part of the window that counts."""

    step_s: float  # wall time per step
    steps_per_s: float  # per peening second
    live_shots: float  # mean
    settings: str

    @property
    def per_peening_s(self) -> float:
        return self.step_s * self.steps_per_s


def available() -> str | None:
    """Path of the program, or None."""
    return shutil.which("liggghts")


def script(scene, arrivals: np.ndarray, *, dt_s: float, window_s: float, skin_m: float) -> str:
    """LIGGGHTS input for the shots of ``arrivals`` (``glue.flow.arrivals.COLUMNS``) before ``window_s``.

    One size of shots and one nozzle at rest at normal incidence (ValueError otherwise): it is a benchmark.
    """
    nozzle, shots, material = scene.nozzle, scene.shots, scene.target.material
    if (
        len(scene.nozzles) > 1
        or len(scene.media) > 1
        or shots.size != "mono"
        or nozzle.impact_angle_deg != 90.0
    ):
        raise ValueError("the LIGGGHTS benchmark has one straight nozzle and one size of shots")
    half = BOX_JET_RADII * 0.5 * nozzle.jet_diameter_m
    top = nozzle.stand_off_m + nozzle.speed_m_s * BATCH_S + 2.0 * shots.diameter_m
    on_shot, on_target = scene.restitution.shot_shot, scene.restitution.shot_target
    mu_shot, mu_target = scene.friction.shot_shot, scene.friction.shot_target
    lines = [
        "atom_style granular",
        "atom_modify map array sort 0 0.0",  # a hundred atoms: sorting costs more than it brings
        "boundary f f f",
        "newton off",
        "communicate single vel yes",
        "units si",
        "hard_particles yes",  # moduli of real steel
        f"region box block {-half:.9g} {half:.9g} {-half:.9g} {half:.9g} {-shots.diameter_m:.9g} {top:.9g} units box",
        "create_box 2 box",
        f"neighbor {skin_m:.9g} bin",
        "neigh_modify delay 0",
        f"fix m1 all property/global youngsModulus peratomtype {shots.E_Pa:.9g} {material.E_Pa:.9g}",
        f"fix m2 all property/global poissonsRatio peratomtype {shots.nu:.9g} {material.nu:.9g}",
        _per_pair("m3", "coefficientRestitution", on_shot, on_target),
        _per_pair("m4", "coefficientFriction", mu_shot, mu_target),
        "pair_style gran model hertz tangential history",
        "pair_coeff * *",
        "fix target all wall/gran model hertz tangential history primitive type 2 zplane 0.0",
        "fix motion all nve/sphere",
        f"timestep {dt_s:.9g}",
        "thermo 1000000000",
        "thermo_modify lost ignore norm no",
    ]
    steps, placed = round(BATCH_S / dt_s), 0
    for batch in range(math.ceil(window_s / BATCH_S)):
        begin = batch * steps * dt_s
        due = arrivals[(arrivals["time_s"] >= begin) & (arrivals["time_s"] < begin + steps * dt_s)]
        for shot in due:
            ahead = shot["time_s"] - begin
            at = [shot[f"{c}_m"] - ahead * shot[f"v{c}_m_s"] for c in "xyz"]
            lines.append("create_atoms 1 single {:.12g} {:.12g} {:.12g} units box".format(*at))
        if len(due):
            lines += [
                f"group new id <> {placed + 1} {placed + len(due)}",
                f"set group new diameter {shots.diameter_m:.9g} density {shots.density_kg_m3:.9g}",
                "velocity new set {:.12g} {:.12g} {:.12g} units box".format(
                    *(due[0][f"v{c}_m_s"] for c in "xyz")
                ),
                "group new delete",
            ]
            placed += len(due)
        lines.append(f"run {steps}")
    return "\n".join(lines) + "\n"


def run(folder: Path, text: str, *, dt_s: float, skip: int, processes: int = 1, settings: str = "") -> Cost:
    """Run the input ``text`` in ``folder``; the first ``skip`` batches, in which the cloud builds up, do not count.

    Raises RuntimeError with the program's last lines when it fails.
    """
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "in.liggghts").write_text(text)
    command = [available(), "-in", "in.liggghts", "-log", "none", "-nocite"]
    if processes > 1:
        command = ["mpirun", "--allow-run-as-root", "--oversubscribe", "-np", str(processes), *command]
    done = subprocess.run(
        command, check=False, cwd=folder, capture_output=True, text=True, stdin=subprocess.DEVNULL
    )
    (folder / "liggghts.log").write_text(done.stdout + done.stderr)
    loops = [(float(s), int(n), int(atoms)) for s, n, atoms in _LOOP.findall(done.stdout)]
    if done.returncode or len(loops) != text.count("\nrun "):
        tail = "\n".join((done.stdout + done.stderr).splitlines()[-8:])
        raise RuntimeError(f"LIGGGHTS failed ({folder / 'liggghts.log'}):\n{tail}")
    counted = loops[skip:]
    seconds, steps = sum(s for s, _, _ in counted), sum(n for _, n, _ in counted)
    live = sum(n * atoms for _, n, atoms in counted) / steps
    return Cost(seconds / steps, 1.0 / dt_s, live, settings)


def _per_pair(name: str, what: str, shot_shot: float, shot_target: float) -> str:
    return f"fix {name} all property/global {what} peratomtypepair 2 {shot_shot:.9g} {shot_target:.9g} {shot_target:.9g} {shot_target:.9g}"
