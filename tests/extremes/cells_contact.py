"""Cells of YADE's contact: time step, stiffness, restitution, size and speed, all measured in one YADE process."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np
from cells_stream import scene_text
from judges import WRONG, Finding, Verdict, at_most, near, refusal, verdict

from glue.solvers import run_yade

RIG = Path(__file__).with_name("contact_rig.py")
SHOT_SHOT = 0.8
RESTITUTION = 0.005  # of the wanted mean rebound: the limit of yade_scripts/checks/restitution.py
PHASES = 7


def job(key: str, values: dict) -> dict:
    """What the rig gets of one cell; contacts are YADE's, so the reader looks at them too."""
    scene = scene_text({**values, "flow_model": "dem", "shots": 20})
    return {"id": key, "scene": scene, "e": values.get("e", 0.6), "dt_over_P": values.get("dt_over_P", 1.0), "phases": PHASES}


def run(cells: Iterable[tuple[str, dict]], folder: Path, on_cell: Callable[[str, Verdict], None]) -> None:
    """Measure ``cells`` (key, values); ``on_cell`` gets each as it is done."""
    folder.mkdir(parents=True, exist_ok=True)
    wanted = dict(cells)
    jobs = folder / "jobs.json"
    jobs.write_text(json.dumps([job(key, values) for key, values in wanted.items()]))

    def on_line(line: str) -> None:
        if line.startswith("cell "):
            answer = json.loads(line[5:])
            on_cell(answer["id"], judge_answer(answer, wanted[answer["id"]]))

    run_yade(RIG, [str(jobs)], cwd=folder, log=folder / "contact.log", on_line=on_line)


def judge_answer(answer: dict, values: dict) -> Verdict:
    """The verdict on one line of the rig."""
    if "refused" in answer:
        return refusal(answer["refused"])
    if "error" in answer:
        return Verdict(WRONG, " ".join(answer["error"].split()), [])
    return verdict(contact(answer["found"], values.get("e", 0.6)))


def contact(found: dict, e: float) -> list[Finding]:
    """Mean rebound as asked; an elastic contact is Hertz's.

    A central-difference step of 1/n of the contact's time makes it (pi/n)^2/24 too short (and lets the energy of a single
    contact end so far off); the largest of the forces seen at the steps is on the mean another (pi/n)^2/24 below the peak.
    """
    judged = []
    for pair, wanted in (("target", e), ("shot", SHOT_SHOT)):
        got = found[pair]
        step = (math.pi * found["dt_s"] / got["hertz_duration_s"]) ** 2 / 24.0
        judged.append(near(f"mean rebound as asked, shot on {pair}", np.mean(got["e"]), wanted, RESTITUTION))
        judged.append(at_most(f"energy never rises, shot on {pair}", max(got["e"]), 1.0 + step))
        if wanted == 1.0:
            step = 1e-3 + 2.0 * step
            judged.append(near(f"Hertz's peak force, shot on {pair}", np.mean(got["force_N"]), got["hertz_force_N"], step))
            judged.append(near(f"Hertz's contact time, shot on {pair}", np.mean(got["duration_s"]), got["hertz_duration_s"], step))
    return judged
