"""Checkpoint of a run, and how to go on from one.

Taken at a moment without contact, when no body is in YADE: then the free states of the live shots, what was
foreseen of them, and some counters are all there is, and a continued run makes the same bits as one that was
never stopped.  The impact log is cut to what it held at that moment.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from flight import Flying
from glue.atomic import atomic_path
from glue.errors import InputError
from glue.flow.impacts import read_impacts

_LOGGER = ("step", "executed", "collisions", "top_speed", "worst_gain", "worst_momentum")
_STREAM = ("next", "dropped", "never_struck", "energy_in_J", "energy_out_J", "mass_in_kg", "peak_live")


def quiet(mover) -> bool:
    """Is this a moment at which ``save`` works?"""
    return not mover.logger.open and not mover.bodies.shot_of


def save(path: Path, identity: dict, stream, kicks, writer, wall_s: float) -> None:
    """Write the checkpoint of a run that is ``quiet``; ``identity`` says which run it is."""
    mover = stream.mover
    logger, shots = mover.logger, mover.fleet.shots
    logger.flush()
    counters = {
        "identity": identity,
        "logger": {name: getattr(logger, name) for name in _LOGGER},
        "stream": {name: getattr(stream, name) for name in _STREAM},
        "work_J": kicks.work_J,
        "log": writer.mark(),
        "wall_s": wall_s,
    }
    states = [
        (s.t, *s.pos, *s.vel, *s.spin, s.true_at, s.start_speed, s.shot_id, s.collisions, s.impacts)
        for s in shots
    ]
    with atomic_path(path) as part, open(part, "wb") as f:
        np.savez(
            f,
            counters=json.dumps(counters),
            states=np.array(states).reshape(len(states), 15),
            foreseen=np.array(mover.forecast.state()).reshape(-1, 3),
        )


def load(path: Path, identity: dict) -> dict | None:
    """What ``save`` wrote, None when there is nothing. Raises InputError when it is of another run."""
    if not path.exists():
        return None
    try:
        with np.load(path, allow_pickle=False) as data:
            saved = {name: data[name] for name in ("counters", "states", "foreseen")}
        saved.update(json.loads(str(saved["counters"])))
        found = saved["identity"]
    except (OSError, ValueError, KeyError, EOFError) as e:
        raise InputError(f"{path}: cannot be read as a checkpoint ({e}); remove it to begin anew") from None
    identity = json.loads(json.dumps(identity))  # as the saved one went: tuples are lists now
    other = sorted(key for key in {*found, *identity} if found.get(key) != identity.get(key))
    if other:
        raise InputError(f"{path}: is of a run with another {', '.join(other)}; remove it to begin anew")
    return saved


def restore(saved: dict, stream, kicks, spots, log_part: Path) -> None:
    """Bring a freshly built run to where ``saved`` was."""
    mover = stream.mover
    for name, value in saved["logger"].items():
        setattr(mover.logger, name, value)
    for name, value in saved["stream"].items():
        setattr(stream, name, value)
    kicks.work_J = saved["work_J"]
    row_of = {int(shot_id): row for row, shot_id in enumerate(stream.arrivals["shot_id"])}
    shots = {}
    for values in saved["states"].tolist():
        shot = Flying(stream.arrivals[row_of[int(values[12])]].item())
        shot.t, shot.pos, shot.vel, shot.spin = values[0], *(tuple(values[i : i + 3]) for i in (1, 4, 7))
        shot.true_at, shot.start_speed = values[10:12]
        shot.collisions, shot.impacts = int(values[13]), int(values[14])
        mover.fleet.add(shot)
        shots[shot.shot_id] = shot
    mover.forecast.restore(saved["foreseen"].tolist(), shots)
    if spots:
        struck = read_impacts(log_part, allow_truncated=True)[0]
        for point in zip(*(struck[c].tolist() for c in ("x_m", "y_m", "z_m"))):
            spots.add(point)
