"""A closed-form stand-in of a run: dimples, Avrami coverage, roughness and stress of a setting."""

from __future__ import annotations

import math

from glue.study.design.axes import read_axes
from glue.study.design.evaluate import Evaluation
from glue.study.design.goals import Reading, read_goals

TARGETS = ("coverage>=0.98", "max_compressive<=-250MPa")
VARY = ("nozzle.speed_m_s=20:100", "nozzle.mass_flow_kg_s=0.005:0.05:log", "exposure_time_s=0.5:10:log")
GOALS, AXES = read_goals(TARGETS, ["Sa"]), read_axes(VARY)
HALF = (0.005, 10e6, 0.5e-6)


def readings(values, strength=290e6):
    """Radius as speed^.47, hits by mass flow and time, stress saturating with them, Sa with the dimple's depth."""
    v, flow, t = (values[axis.key] for axis in AXES)
    radius = 0.227e-3 * (v / 60.0) ** 0.47
    hits = math.pi * radius**2 * flow * t / (7800.0 * math.pi / 6.0 * 1e-9) / (math.pi * 0.01**2)
    found = -math.expm1(-hits), strength * math.expm1(-1.2 * hits), 23e-6 * (v / 60.0) ** 0.94 * (hits / 5.0) ** 0.15
    return {q.path: Reading(x, half, 2 * half) for q, x, half in zip(GOALS.quantities, found, HALF, strict=True)}


def evaluation(number, values, **more):
    return Evaluation(number, values, "done", readings(values, **more), 1.0)


def at(number, coverage, stress_MPa, sa_um):
    """An evaluation with these readings."""
    found = (coverage, 1e6 * stress_MPa, 1e-6 * sa_um)
    values = {AXES[0].key: 20.0 + number, AXES[1].key: 0.01, AXES[2].key: 1.0}
    read = {q.path: Reading(x, half, 2 * half) for q, x, half in zip(GOALS.quantities, found, HALF, strict=True)}
    return Evaluation(number, values, "done", read, 1.0)


def refused(number, cause="too dense"):
    return Evaluation(number, {AXES[0].key: 20.0 + number, AXES[1].key: 0.05, AXES[2].key: 9.0}, "refused", cause=cause)
