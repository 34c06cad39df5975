"""Cells of the shot stream: a scene as a file, read, drawn and flown event by event, beside the same without collisions."""

from __future__ import annotations

import math
import tempfile
from pathlib import Path

import numpy as np
from judges import Finding, at_most, equal, near, rising, true

from glue.flow.arrivals import check_stream, draw_arrivals
from glue.flow.ballistic import run_ballistic
from glue.flow.event_driven import run_event
from glue.flow.impacts import normal_speed_m_s, tangential_velocity_m_s
from glue.flow.log_checks import log_problems
from glue.flow.regime import choose_flow, collision_number, expected_errors
from glue.flow.restitution import RestitutionLaw
from glue.flow.surface import from_scene
from glue.scene.reader import read_scene

SHOTS = 400  # expected in a stream; the exposure follows
FRICTION = 0.2
ROUNDING = 1e-9  # of a double after a thousand operations
GUARDED = 0.01  # no more contacts than that may be made elastic: it changes energies by less than the preset's tolerance
_DEFAULTS = {
    "diameter_m": 1e-3, "density_kg_m3": 7800.0, "speed_m_s": 60.0, "flow_kg_min": 1.0, "angle_deg": 90.0, "e": 0.6,
    "ratio": 1.0, "shots": SHOTS, "stiffness": 1.0, "flow_model": "event", "preset": "balanced", "extra": "",
}  # fmt: skip

_SCENE = """
schema = 1
name = "extreme"
seed = 1
exposure_time_s = {exposure_s!r}
{media}
[nozzle]
speed_m_s = {speed_m_s!r}
mass_flow_kg_s = {flow_kg_s!r}
jet_diameter_m = {jet_m!r}
stand_off_m = {stand_off_m!r}
impact_angle_deg = {angle_deg!r}
[target]
material = "al2024-t351"
window_m = [{window_m!r}, {window_m!r}]
[restitution]
shot_target = {e!r}
shot_shot = 0.8
[friction]
shot_target = 0.2
shot_shot = 0.2
[models]
flow = "{flow_model}"
[accuracy]
preset = "{preset}"
{extra}
"""
_MEDIUM = "[{brackets}]\ndiameter_m = {d!r}\ndensity_kg_m3 = {rho!r}\nE_Pa = {E!r}\nnu = 0.3\n{share}"


def scene_text(values: dict) -> str:
    """The scene file of a cell: jet, stand-off and window follow the largest shot, the exposure the number of shots."""
    v = _DEFAULTS | values
    d, ratio = v["diameter_m"], v["ratio"]
    small = d / ratio
    # nine in ten are small ones, so that both are there
    share = 1.0 if ratio == 1.0 else 9.0 / (9.0 + ratio**3)
    mass = v["density_kg_m3"] * math.pi / 6.0 * (d**3 if ratio == 1.0 else 0.1 * d**3 + 0.9 * small**3)
    media = [(small, share), (d, 1.0 - share)] if ratio != 1.0 else [(d, 1.0)]
    text = "\n".join(
        _MEDIUM.format(
            brackets="[shots]" if ratio != 1.0 else "shots", d=size, rho=v["density_kg_m3"], E=210e9 * v["stiffness"],
            share=f"mass_fraction = {part!r}\n" if ratio != 1.0 else "",
        )
        for size, part in media
    )  # fmt: skip
    flow, jet = v["flow_kg_min"] / 60.0, max(0.02, 12.0 * d)
    return _SCENE.format(
        exposure_s=max(v["shots"] * mass / flow, 1e-6), media=text, flow_kg_s=flow, jet_m=jet, stand_off_m=max(0.1, 8.0 * jet),
        window_m=3.0 * d, **{k: v[k] for k in ("speed_m_s", "angle_deg", "e", "flow_model", "preset", "extra")},
    )  # fmt: skip


def read(values: dict):
    """The cell's scene, through the reader that refuses."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "scene.toml"
        path.write_text(scene_text(values))
        return read_scene(path)


def stream(values: dict) -> list[Finding]:
    """One stream by both quick models; the limits are those of rounding but for the count of arrivals (5 sigma)."""
    scene = read(values)
    check_stream(scene)
    e = scene.restitution.shot_target
    law, shape, arrivals = RestitutionLaw(e), from_scene(scene), draw_arrivals(scene)
    alone, missed = run_ballistic(scene, arrivals, law, shape)
    impacts, info = run_event(scene, arrivals, law, shape)
    expected = scene.expected_shots
    found = [
        at_most("as many arrivals as Poisson's law allows (5 sigma)", abs(len(arrivals) - expected), 5.0 * math.sqrt(expected) + 1.0),
        equal("all shots accounted for", info["arrived"], sum(info["dropped"].values()) + info["in_flight"]),
        equal("all shots accounted for, none colliding", len(alone) + missed["dropped"]["missed"], len(arrivals)),
        true("the log holds what can be", not log_problems(scene, arrivals, impacts, shape)),
        *rebound(alone, e, "none colliding"),
        *rebound(impacts, e, "event-driven", info["collapse_guard_hits"]),
        at_most("share of contacts that the guard against endless bouncing made elastic", info["collapse_guard_share"], GUARDED),
        *flights(arrivals, alone, "none colliding"),
        *flights(arrivals, _first(impacts), "event-driven"),
        *_regime(scene, e),
    ]  # fmt: skip
    if scene.gravity is None and scene.air_drag is None:
        found.append(at_most("energy left over fed", info["energy_left_over_fed"], 1.0 + ROUNDING))
        found.append(at_most("momentum of a collision", info["worst"]["momentum"], ROUNDING))
    return found


def _first(impacts: np.ndarray) -> np.ndarray:
    """First impact of each shot that met no other."""
    first = impacts[np.unique(impacts["shot_id"], return_index=True)[1]]
    return first[first["collisions_before"] == 0]


def rebound(impacts: np.ndarray, e: float, who: str, guarded: int = 0) -> list[Finding]:
    """Restitution as asked, energy never rising, sideways impulse within Coulomb's.

    ``guarded``: so many contacts, of shots as well, the flow counts as made elastic by its guard against endless bouncing.
    """
    out = np.stack([impacts[f"v{a}_out_m_s"] for a in "xyz"], axis=-1)
    into = np.stack([impacts[f"v{a}_in_m_s"] for a in "xyz"], axis=-1)
    normal = np.stack([impacts[f"n{a}"] for a in "xyz"], axis=-1)
    speed = normal_speed_m_s(impacts)
    push = (out * normal).sum(axis=-1) + speed  # per mass
    slide = np.linalg.norm((out - into) - push[:, None] * normal, axis=-1)
    energy = _energy(impacts, "out") / _energy(impacts, "in")
    ratio = (out * normal).sum(axis=-1) / speed
    asked = np.abs(ratio / e - 1.0) <= ROUNDING
    elastic = np.abs(ratio - 1.0) <= ROUNDING
    return [
        equal(f"impacts whose restitution is neither the one asked nor the guard's, {who}", np.count_nonzero(~asked & ~elastic), 0),
        at_most(f"impacts that the guard made elastic, over those it counted, {who}", np.count_nonzero(~asked), guarded),
        at_most(f"energy never rises in an impact, {who}", np.max(energy, initial=0.0), 1.0 + ROUNDING),
        at_most(f"Coulomb's limit of the sideways impulse, {who}", np.max(slide / push, initial=0.0), FRICTION * (1.0 + ROUNDING)),
    ]


def _energy(impacts: np.ndarray, when: str) -> np.ndarray:
    """Twice the kinetic energy per mass, spin of a solid sphere included."""
    spin2 = sum(impacts[f"w{a}_{when}_rad_s"] ** 2 for a in "xyz")
    return sum(impacts[f"v{a}_{when}_m_s"] ** 2 for a in "xyz") + 0.1 * impacts["diameter_m"] ** 2 * spin2


def flights(arrivals: np.ndarray, impacts: np.ndarray, who: str) -> list[Finding]:
    """Shots that met no other: straight flight from the exit to the touch, in closed form (no gas, no gravity)."""
    came = arrivals[impacts["shot_id"]]
    drop = came["z_m"] - 0.5 * came["diameter_m"]
    flight = drop / -came["vz_m_s"]
    off = np.hypot(*(impacts[f"{a}_m"] - came[f"{a}_m"] - came[f"v{a}_m_s"] * flight for a in "xy"))
    along = tangential_velocity_m_s(impacts)
    return [
        near(f"time of a free flight, {who}", impacts["time_s"], came["time_s"] + flight, 1e-12),
        at_most(f"place of a free flight over the height, {who}", np.max(off / drop, initial=0.0), 1e-12),
        equal(f"speed of a free flight, {who}", normal_speed_m_s(impacts), -came["vz_m_s"], 0.0),
        equal(f"sideways speed of a free flight, {who}", along[:, 0], came["vx_m_s"], 0.0),
    ]


def _regime(scene, e: float) -> list[Finding]:
    """The numbers that choose a model exist, and the choice gets no cheaper as the tolerance gets tighter."""
    numbers = collision_number(scene, e)
    errors = expected_errors(scene, e)
    return [
        true("regime numbers finite and not negative", all(math.isfinite(x) and x >= 0.0 for x in (*numbers.values(), *errors.values()))),
        true("a flow model is chosen", choose_flow(scene, e).model in ("ballistic", "event", "dem")),
    ]  # fmt: skip


def collisions(values: dict) -> list[Finding]:
    """Thin to dense: the share that met others grows with the flow, and is that of the collision number where it is small.

    Below pi_eff = .01 the expected number of collisions is pi_eff N; Poisson's 5 sigma.
    """
    found, shares = [], []
    for flow in values["flows_kg_min"]:
        scene = read({"flow_kg_min": flow, **{k: v for k, v in values.items() if k != "flows_kg_min"}})
        arrivals = draw_arrivals(scene)
        impacts, info = run_event(scene, arrivals, RestitutionLaw(scene.restitution.shot_target), from_scene(scene))
        number = collision_number(scene, scene.restitution.shot_target)["pi_eff"]
        if number < 0.01:
            most = number * len(arrivals)
            found.append(at_most("collisions of a thin stream over its number (5 sigma)", info["shot_shot_collisions"],
                                 most + 5.0 * math.sqrt(most) + 1.0))  # fmt: skip
        first = impacts[np.unique(impacts["shot_id"], return_index=True)[1]]
        shares.append(float((first["collisions_before"] > 0).mean()))
    # 5 sigma of a share of so many shots, at most
    found.append(rising("share that met others grows with the flow", 1.0 + np.array(shares), 2.5 / math.sqrt(len(first))))
    return found


def single_flights(values: dict) -> list[Finding]:
    """Gravity and gas at extremes, one shot after another, against a direct integration of the equation of motion."""
    from scipy.integrate import solve_ivp

    from glue.flow.drag import acceleration, surroundings

    scene = read(values)
    check_stream(scene)
    arrivals = draw_arrivals(scene)[:5]
    impacts, _ = run_ballistic(scene, arrivals, RestitutionLaw(scene.restitution.shot_target), from_scene(scene))
    around = surroundings(scene)
    found = [true("every shot lands or is missed", len(impacts) <= len(arrivals))]
    for row in impacts:
        came = arrivals[row["shot_id"]]
        d, rho = float(came["diameter_m"]), float(came["density_kg_m3"])

        def rate(t, y, d=d, rho=rho):
            return [*y[3:], *acceleration(*y[3:], d, rho, around)]

        def touch(t, y, d=d):
            return y[2] - 0.5 * d

        touch.terminal, touch.direction = True, -1
        start = [float(came[n]) for n in ("x_m", "y_m", "z_m", "vx_m_s", "vy_m_s", "vz_m_s")]
        way = solve_ivp(rate, (0.0, 2.0 * float(row["time_s"] - came["time_s"])), start, events=touch, rtol=1e-10, atol=1e-12,
                        method="DOP853")  # fmt: skip
        end = way.y_events[0][0]
        # the way is right to fourth order in stretches of 2 % of speed: 1e-6 of it
        found.append(near("flight time against direct integration", row["time_s"] - came["time_s"], way.t_events[0][0], 1e-5))
        found.append(near("speed against direct integration", -row["vz_in_m_s"], -end[5], 1e-5))
        found.append(at_most("place against direct integration, over the height", math.hypot(row["x_m"] - end[0], row["y_m"] - end[1]) / start[2], 1e-5))
    return found
