"""After an event-driven run: its numbers, and whether they can be believed."""

from __future__ import annotations

import numpy as np

from glue.errors import NotConverged
from glue.flow.event_state import World

ROUNDING = 1e-9  # relative; measured 1e-13 and below
DROPS = ("exit", "beside", "far", "past", "inlet", "settled")


def run_numbers(world: World) -> dict:
    """What the clock has counted, for flow.json; SI."""
    clock = world.clock[0]
    contacts = int(clock["collisions"] + clock["struck"])
    return {
        "arrived": int(clock["fed"]),
        "mass_fed_kg": float(clock["mass_fed"]),
        "dropped": {name: int(clock[name]) for name in DROPS},
        "in_flight": int(clock["live"]),
        "would_still_strike": int(
            np.count_nonzero((world.shots["place"] >= 0) & (world.shots["t_surface"] < np.inf))
        ),
        "shot_shot_collisions": int(clock["collisions"]),
        "collapse_guard_hits": int(clock["guard_hits"]),
        "collapse_guard_share": int(clock["guard_hits"]) / max(contacts, 1),
        "shots_that_never_struck": int(clock["never_struck"])
        + int(np.count_nonzero((world.shots["place"] >= 0) & (world.shots["impacts"] == 0))),
        "peak_live_shots": int(clock["peak"]),
        "energy_left_over_fed": _energy_left(world),
        "top_speed_m_s": float(clock["top_speed"]),
        "simulated_s": float(clock["now"]),
        "events": int(clock["events"]),
        "cell_crossings": int(clock["crossings"]),
        "kicks": int(clock["kicks"]),
        "void_predictions": int(clock["void"]),
        "worst": {name: float(clock[f"worst_{name}"]) for name in ("gain", "momentum", "overlap")},
    }


def _energy_left(world: World) -> float:
    """Energy of the shots when they were dropped, or now, over what they were fed with."""
    live = world.shots[world.shots["place"] >= 0]
    return float((world.clock["energy_out"][0] + energy_J(live)) / world.clock["energy_in"][0])


def energy_J(shots: np.ndarray) -> float:
    """Kinetic energy [J] of flight and spin of the records ``shots`` (``event_state.SHOT``)."""
    v2 = sum(shots[name] ** 2 for name in ("vx", "vy", "vz"))
    w2 = sum(shots[name] ** 2 for name in ("wx", "wy", "wz"))
    return float((0.5 * shots["mass"] * (v2 + 0.4 * shots["radius"] ** 2 * w2)).sum())


def check_run(world: World, arrivals: int, *, conserves: bool) -> None:
    """Raise NotConverged with every check that fails.

    ``conserves``: nothing but contacts changes the energy of the shots (no gravity, no gas).
    """
    clock, live = world.clock[0], world.shots[world.shots["place"] >= 0]
    dropped = sum(int(clock[name]) for name in DROPS)
    left = _energy_left(world)
    rows = [
        ("shots fed, of all arrivals", clock["fed"], arrivals, clock["fed"] == arrivals),
        ("shots unaccounted for", clock["fed"] - dropped - len(live), 0, clock["fed"] == dropped + len(live)),
        ("gain of energy in a contact", clock["worst_gain"], ROUNDING, clock["worst_gain"] <= ROUNDING),
        ("change of momentum in a collision", clock["worst_momentum"], ROUNDING, clock["worst_momentum"] <= ROUNDING),
        ("overlap of shots, of their radii", clock["worst_overlap"], ROUNDING, clock["worst_overlap"] <= ROUNDING),
        ("lowest shot over the target, of its radius", clock["lowest"], 1.0 - ROUNDING, clock["lowest"] >= 1.0 - ROUNDING),
        ("energy left over fed", left, 1.0 + ROUNDING, left <= 1.0 + ROUNDING or not conserves),
    ]  # fmt: skip
    failed = [
        f"{name}: {float(value):.6g}, limit {limit:.6g}" for name, value, limit, passed in rows if not passed
    ]
    if failed:
        raise NotConverged(
            "the event-driven flow's own checks failed",
            cause="; ".join(failed),
            advice='models.flow = "dem", which resolves every contact',
        )
