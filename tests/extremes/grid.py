"""The cells of the stability map: data only.  Each panel crosses two axes far past normal use.

A cell's ``family`` names the function that solves and judges it (``run.FAMILIES``), ``values`` are its inputs.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from itertools import product


@dataclass(frozen=True)
class Cell:
    family: str
    panel: str
    row: str
    column: str
    values: dict = field(hash=False)

    @property
    def name(self) -> str:
        return f"{self.panel}: {self.row}, {self.column}"

    @property
    def ordinary(self) -> bool:
        """Whether nothing about it is past normal use, so that a refusal would be wrong."""
        return all(_inside(key, self.values[key]) for key in self.values)


# Inside these nothing may be refused; a value that stands in no cell is the ordinary one.
ORDINARY = {
    "diameter_m": (0.1e-3, 5e-3), "speed_m_s": (5.0, 120.0), "angle_deg": (30.0, 90.0), "e": (0.2, 0.94),
    "flow_kg_min": (1e-4, 100.0), "dt_over_P": (0.0, 1.0), "stiffness": (1.0, 1.0), "elements": (3, 12), "exposure": (0.136, 8.05),
    "nu": (0.0, 0.45), "ratio": (1.0, 20.0), "yield_Pa": (200e6, 1e9), "density_kg_m3": (2000.0, 16000.0),
}  # fmt: skip
_EXTREME = ("none", "no impact", "ten coincident")


def _inside(key: str, value) -> bool:
    if key in ORDINARY:
        low, high = ORDINARY[key]
        return low <= value <= high
    return key != "accuracy" and value not in _EXTREME  # numbers that no preset has are past normal use


def _cross(family: str, panel: str, rows: dict[str, dict], columns: dict[str, dict], **common) -> Iterator[Cell]:
    for (row, a), (column, b) in product(rows.items(), columns.items()):
        yield Cell(family, panel, row, column, {**common, **a, **b})


def _axis(key: str, values: Iterable, unit: str, factor: float = 1.0) -> dict[str, dict]:
    return {f"{value * factor:g} {unit}".strip(): {key: value} for value in values}


SIZES = _axis("diameter_m", (2e-5, 1e-4, 3e-4, 1e-3, 3e-3, 5e-3, 8e-3), "mm", 1e3)
SPEEDS = _axis("speed_m_s", (1.0, 5.0, 20.0, 60.0, 120.0, 300.0), "m/s")
FLOWS = _axis("flow_kg_min", (1e-4, 1e-3, 0.01, 0.1, 1.0, 10.0, 100.0), "kg/min")
ANGLES = _axis("angle_deg", (5.0, 10.0, 20.0, 30.0, 45.0, 60.0, 90.0), "deg")
RESTITUTIONS = _axis("e", (0.05, 0.2, 0.5, 0.8, 0.94, 1.0), "e")
RATIOS = _axis("ratio", (2.0, 5.0, 10.0, 20.0, 50.0, 100.0), ": 1")
STEPS = _axis("dt_over_P", (0.01, 0.03, 0.1, 0.3, 1.0, 1.5, 2.0, 4.0, 12.0), "P")
STIFFNESSES = _axis("stiffness", (1e-4, 1e-3, 5e-3, 0.01, 0.03, 0.1, 0.3, 1.0), "E")
YIELDS = {"50 MPa": {"yield_Pa": 50e6}, "200 MPa": {"yield_Pa": 200e6}, "1 GPa": {"yield_Pa": 1e9}, "3 GPa": {"yield_Pa": 3e9}}
POISSON = _axis("nu", (0.0, 0.2, 0.4, 0.45, 0.49), "nu")
HARDENINGS = {"none": {"hardening": "none"}, "as 2024": {"hardening": "2024"}, "2 GPa linear": {"hardening": "linear"},
              "10 GPa sqrt(p)": {"hardening": "steep"}}  # fmt: skip
ALLOYS = ("al2024-t351", "al7075-t6", "ti6al4v", "in718", "steel4340", "ss316l")
AIRS = {
    "gravity": {"extra": "[gravity]\n"}, "100 g": {"extra": "[gravity]\nacceleration_m_s2 = 981.0\n"},
    "air": {"extra": "[air_drag]\n"}, "water-like gas": {"extra": "[air_drag]\ngas_density_kg_m3 = 100.0\ngas_viscosity_Pa_s = 1e-3\n"},
}  # fmt: skip


def _stream() -> Iterator[Cell]:
    yield from _cross("stream", "shot stream: size and speed", SIZES, SPEEDS)
    yield from _cross("stream", "shot stream: mass flow and speed", FLOWS, SPEEDS, shots=200)
    yield from _cross("stream", "shot stream: angle and restitution", ANGLES, RESTITUTIONS)
    yield from _cross("stream", "shot stream: size ratio and flow", RATIOS, _axis("flow_kg_min", (0.1, 1.0, 10.0), "kg/min"),
                      diameter_m=2e-3, shots=1000)  # fmt: skip
    yield from _cross("collisions", "collisions rise with the flow", _axis("angle_deg", (10.0, 45.0, 90.0), "deg"),
                      _axis("e", (0.2, 0.6, 0.94), "e"), flows_kg_min=[1e-3, 0.1, 1.0, 10.0, 100.0], shots=1500)  # fmt: skip
    yield from _cross("flight", "flight in gravity and gas", AIRS,
                      {"1 m/s, 20 µm": {"speed_m_s": 1.0, "diameter_m": 2e-5}, "5 m/s, .1 mm": {"speed_m_s": 5.0, "diameter_m": 1e-4},
                       "60 m/s, 1 mm": {"speed_m_s": 60.0}, "300 m/s, 5 mm": {"speed_m_s": 300.0, "diameter_m": 5e-3}},
                      shots=10, density_kg_m3=2500.0)  # fmt: skip


def _contact() -> Iterator[Cell]:
    yield from _cross("contact", "YADE contact: time step and restitution", STEPS, RESTITUTIONS)
    yield from _cross("contact", "YADE contact: stiffness and speed", STIFFNESSES, _axis("speed_m_s", (1.0, 20.0, 60.0, 300.0), "m/s"), e=1.0)
    yield from _cross("contact", "YADE contact: size and speed", SIZES, _axis("speed_m_s", (1.0, 5.0, 60.0, 120.0, 300.0), "m/s"))


def _dent() -> Iterator[Cell]:
    yield from _cross("dent", "one impact: yield stress and speed", YIELDS, SPEEDS)
    yield from _cross("dent", "one impact: hardening and Poisson's ratio", HARDENINGS, POISSON, speed_m_s=60.0, twin="density")
    yield from _cross("dent", "one impact: size and rate", _axis("diameter_m", (2e-5, 1e-3, 8e-3), "mm", 1e3),
                      {"C = .015": {"C": 0.015}, "C = .1": {"C": 0.1}}, speed_m_s=60.0, physics=["rate"])  # fmt: skip
    yield from _cross("effect", "one impact: more physics", {p: {"physics": [p]} for p in ("inertia", "friction", "elastic_shot", "thermal")},
                      _axis("speed_m_s", (5.0, 60.0, 300.0), "m/s"), material="al2024-t351")  # fmt: skip
    yield from _cross("mesh", "one impact: coarse and anisotropic meshes", _axis("elements", (1, 2, 3, 4), "per radius"),
                      {"as always": {"growth": 0.3}, "coarse at once": {"growth": 1.0}}, speed_m_s=60.0)  # fmt: skip
    for key, ends in (("speed_m_s", [1.0, 5.0, 20.0, 60.0, 120.0, 300.0]), ("yield_Pa", [200e6, 1e9, 3e9])):
        falls = key == "yield_Pa"
        for label, law in (("50 MPa", {"yield_Pa": 50e6}), ("1 GPa", {"yield_Pa": 1e9}), ("60 m/s", {}), ("120 m/s", {})):
            if falls == label.endswith("m/s"):
                speed = float(label.split()[0]) if falls else 60.0
                stop = ends if label != "50 MPa" else ends[:4]
                yield Cell("order", "one impact: monotone", "over yield stress" if falls else "over speed", label,
                           {"axis": key, "values": stop, "radius": "falls" if falls else "rises", "speed_m_s": speed, **law})  # fmt: skip
    yield from _cross("hits", "ten coincident impacts", {"2024, unbounded law": {"bounded": False}, "2024, bounded law": {"bounded": True}},
                      _axis("speed_m_s", (60.0,), "m/s"), hits=10)  # fmt: skip
    yield from _cross("no_dimple", "no dimple below first yield", {"3 GPa": {"yield_Pa": 3e9}}, _axis("speed_m_s", (1.0, 2.0), "m/s"))


def _surface() -> Iterator[Cell]:
    radii = _axis("radius", (0.005, 0.02, 0.1, 0.3), "of the window")
    for case in ("none", "one", "on the edge", "in the corner", "just outside", "ten coincident", "two apart",
                 "two by half a radius", "ellipse"):  # fmt: skip
        for label, radius in radii.items():
            if label == "0.3 of the window" and case in ("two apart", "ellipse"):  # still inside
                radius = {"radius": 0.24 if case == "two apart" else 0.15}
            yield Cell("coverage", "coverage of few impacts", case, label, {"case": case, "points": 20, **radius})
    yield from _cross("coverage", "coverage of random impacts", _axis("exposure", (1e-3, 0.1, 1.0, 4.0, 20.0), "dimple areas"),
                      {"alike": {"ratio": 1.0}, "10 : 1": {"ratio": 10.0}, "100 : 1": {"ratio": 100.0}}, case="random", radius=0.03, points=200)  # fmt: skip
    yield from _cross("stamp", "height map of few impacts", {c: {"case": c} for c in
                      ("none", "one", "ten coincident", "on the edge", "in the corner", "far outside")},
                      {"coarse": {"points": 8}, "fine": {"points": 40}, "steep hardening": {"points": 16, "hardening": 1e11},
                       "1 : 100 in size": {"points": 16, "size": 0.01}})  # fmt: skip
    yield from _cross("layers", "stress layers: exposure and alloy", _axis("exposure", (0.0, 1e-3, 0.2, 1.0, 8.0, 24.0, 100.0), "dimple areas"),
                      {key: {"material": key} for key in ALLOYS}, speed_m_s=60.0)  # fmt: skip
    yield from _cross("layers", "stress layers: speed and alloy", _axis("speed_m_s", (1.0, 5.0, 120.0, 300.0), "m/s"),
                      {key: {"material": key} for key in ("al2024-t351", "steel4340")}, exposure=1.0)  # fmt: skip
    yield from _cross("plate", "plate let go: thickness and profile", _axis("thickness_m", (1e-4, 1e-3, 0.1), "mm", 1e3),
                      {c: {"shape": c} for c in ("uniform", "step", "ramp", "wave")}, layer_m=5e-5, points=400)  # fmt: skip
    yield from _cross("laws", "bounded hardening to any strain", _axis("strain", (0.01, 1.0, 100.0), "strain"),
                      {"b .1": {"b": 0.1, "Q_Pa": 1e9}, "b 12": {"b": 12.0, "Q_Pa": 80e6}, "b 1000": {"b": 1e3, "Q_Pa": 3e9}})  # fmt: skip


def _target_cell() -> Iterator[Cell]:
    panel = "periodic cell in FreeFEM"
    for case in ("no impact", "one", "shifted over the edge", "ten coincident"):
        yield Cell("target_cell", panel, case, "preset fast", {"case": case})
    for label, mesh in (("4 elements a side", {"cell_elements_per_side": 4}), ("wide flat elements", {"cell_side_in_radii": 6.4}),
                        ("slender elements", {"cell_side_in_radii": 2.6})):  # fmt: skip
        yield Cell("target_cell", panel, "one", label, {"case": "one", "accuracy": mesh})
    yield Cell("target_cell", panel, "one", "nu .49", {"case": "one", "nu": 0.49})


def cells(short: bool = False) -> list[Cell]:
    """All cells; ``short``: a sample of every family for seconds, the corners of each cheap panel."""
    everything = [*_stream(), *_contact(), *_surface(), *_dent(), *_target_cell()]
    if not short:
        return everything
    dear = {"stream": 6, "collisions": 2, "flight": 4, "dent": 2, "effect": 1, "mesh": 1, "layers": 2, "no_dimple": 1}
    left_out = {"order", "hits", "target_cell"}
    taken: list[Cell] = []
    for family in dict.fromkeys(c.family for c in everything):
        own = [c for c in everything if c.family == family]
        if family in left_out:
            continue
        count = dear.get(family, 8)
        step = max(len(own) // count, 1)
        taken += own[step // 2 :: step][:count]
    return taken
