"""The scene file's keys: range, unit, default and source of each, and the keys that later versions will know.

Ranges are those in which the models of this project have been tried, or wide physical bounds that catch
a wrong unit.  Grades of sources: D derived, A read, B quoted, C from memory or unverified.
"""

from __future__ import annotations

from glue.scene.fields import Flag, Integer, Number, Text, Vector, Word
from glue.scene.peening_fields import Almen, Ratio
from glue.scene.presets import DEFAULT_PRESET, PRESETS

SCHEMA = 1
MAX_SHOTS = 2_000_000  # an impact log of a gigabyte
MAX_RASTER_POINTS = 100_000_000  # 0.8 GB for one raster of the window
MAX_VOLUME_FRACTION = 0.15  # 2000 shots, jets 5 and 20 shots wide: 11 of 12 seeds can be drawn, at .18 only 5


TOP = {
    "schema": Integer(SCHEMA, SCHEMA),
    "name": Text(
        r"[A-Za-z0-9][A-Za-z0-9._-]{0,63}",
        "allowed: 1 to 64 letters, digits, dots, dashes and underscores, the first a letter or digit",
    ),
    "seed": Integer(0, 2**32 - 1),
    "exposure_time_s": Number(1e-6, 3600.0, "s"),
    "arrivals": Word(
        ("poisson", "exact_mass"), "poisson", "shots leave independently of each other; choice of this project"
    ),
}
TABLES = (
    *("shots", "nozzle", "target", "restitution", "friction", "gravity", "air_drag", "strain_rate", "target_inertia"),
    *("elastic_shot", "models", "accuracy", "machine", "measured"),
)

SHOTS = {
    "grade": Text(r".+", "allowed: a grade of the catalogue, for example S390"),
    "diameter_m": Number(2e-5, 6e-3, "m"),
    "density_kg_m3": Number(1000.0, 20000.0, "kg/m3"),
    "E_Pa": Number(1e9, 1.2e12, "Pa", 210e9, "steel; grade C"),
    "nu": Number(0.0, 0.49, "", 0.3, "steel; grade C"),
    "size": Word(
        ("mono", "distribution", "sieve"), "mono", "every shot of the same size; choice of this project"
    ),
    "size_cv": Number(0.001, 0.3, "share", 0.09, "cast steel shot, CV 8-10 %; grade C"),
    "mass_fraction": Number(
        1e-6, 1.0, "share", reason="a medium feeds mass, never takes it away, and all of them feed 1"
    ),
}
SIEVE = {"opening_m": Number(2e-5, 6e-3, "m"), "finer": Number(0.0, 1.0, "share")}
MAX_SIEVES, MAX_MEDIA, MAX_NOZZLES = 20, 10, 16

NOZZLE = {
    "speed_m_s": Number(0.5, 300.0, "m/s"),
    "mass_flow_kg_s": Number(1e-6, 2.0, "kg/s"),
    "jet_diameter_m": Number(1e-4, 0.5, "m"),
    "stand_off_m": Number(1e-3, 2.0, "m"),
    "impact_angle_deg": Number(
        10.0, 90.0, "deg", reason="measured from the surface; a flatter jet grazes it and rolls along"
    ),
}
# In place of the speed: what a drawing says, or what the machine is set to.
SPECIFIED = {"intensity": Almen()}
SETTINGS = {"air_pressure_Pa": Number(1e4, 2e6, "Pa"), "wheel_speed_m_s": Number(1.0, 200.0, "m/s")}
COVERAGE_PERCENT = Number(1.0, 2000.0, "%")
MACHINE_ROW = {"speed_m_s": NOZZLE["speed_m_s"]}
MACHINE_LAW = {
    "speed_m_s": NOZZLE["speed_m_s"],
    "exponent": Number(0.1, 2.0),
    "relative_sd": Number(0.0, 0.5, "share", 0.1, "what such a law is off by, a guess; grade C"),
    "factor": Number(1.01, 10.0, "", 2.0, "half to twice the reference setting; choice of this project"),
}
MACHINE_CURVE = {
    "file": Text(r"[^\0]{1,1000}", "allowed: the name of a saturation curve (CSV), from the scene file's folder"),
    "strip": Text(r".{1,3}", "allowed N, A, C", "A", "the usual strip"),
}
MAX_MACHINE_ROWS = 50
_HERE = "choice of this project"
JET = {
    "azimuth_deg": Number(-180.0, 180.0, "deg", 0.0, f"shots fly towards +x; {_HERE}"),
    "aim_m": Vector("xy", Number(-1.0, 1.0, "m"), (0.0, 0.0), f"the middle of the window; {_HERE}"),
    "profile": Word(("uniform", "gaussian"), "uniform", f"evenly over the exit; {_HERE}"),
    "divergence_half_angle_deg": Number(0.0, 30.0, "deg", 0.0, f"a parallel jet; {_HERE}"),
    "speed_cv": Number(0.0, 0.2, "share", 0.0, f"every shot at the same speed; {_HERE}"),
}
FEED = {
    "feed_speed_m_s": Number(0.0, 2.0, "m/s", 0.0, f"a nozzle at rest; {_HERE}"),
    "stroke_m": Number(1e-4, 10.0, "m"),
    "passes": Integer(1, 1000, 1, f"one stroke; {_HERE}"),
    "pitch_m": Number(0.0, 0.5, "m", 0.0, f"every pass on the same line; {_HERE}"),
    "dwell_s": Number(0.0, 60.0, "s", 0.0, f"turns at once; {_HERE}"),
    "feed_direction_deg": Number(-180.0, 180.0, "deg", 0.0, f"the first stroke goes towards +x; {_HERE}"),
}
PULSE = {
    "mass_flow_pattern": Word(("steady", "pulsed", "sinusoidal"), "steady", f"an even flow; {_HERE}"),
    "pulse_frequency_Hz": Number(1e-3, 1e5, "Hz"),
    "pulse_duty": Number(0.01, 1.0, "share"),
    "pulse_amplitude": Number(0.0, 1.0, "share", reason="a flow never runs backwards"),
}
PULSE_KEYS = {"steady": (), "pulsed": ("pulse_duty",), "sinusoidal": ("pulse_amplitude",)}

TARGET = {"window_m": Vector("xy", Number(2e-5, 0.2, "m")), "thickness_m": Number(1e-4, 1.0, "m")}
INITIAL_STRESS = {"depth_m": Number(0.0, 0.1, "m"), "stress_Pa": Number(-3e9, 3e9, "Pa")}
INITIAL_ROUGHNESS = {"Sa_m": Number(1e-9, 1e-4, "m"), "wavelength_m": Number(1e-6, 1e-2, "m")}
MEASURED = {
    "stress_file": Text(r"[^\0]{1,1000}", "allowed: the name of a CSV file, from the scene file's folder"),
    "Ra_m": Number(1e-9, 1e-3, "m"),
    "Rz_m": Number(1e-9, 1e-2, "m"),
    "xray_depth_m": Number(1e-7, 1e-3, "m"),
}
SURFACE = {
    "kind": Word(("plane", "cylinder", "stl")),
    "radius_m": Number(1e-4, 100.0, "m"),
    "axis": Word(("x", "y"), "y", f"curved in x; {_HERE}"),
    "file": Text(r"[^\0]{1,1000}", "allowed: the name of an STL file, from the scene file's folder"),
}
SURFACE_KEYS = {"plane": (), "cylinder": ("radius_m", "axis"), "stl": ("file",)}

MATERIAL = {
    "name": Text(
        r".{1,80}", "allowed: 1 to 80 characters", "own material", "name of a material given in the scene"
    ),
    "source": Text(r".{1,200}", "allowed: 1 to 200 characters", "given in the scene", "no source named"),
    "E_Pa": Number(1e9, 1e12, "Pa"),
    "nu": Number(0.0, 0.49, reason="towards 0.5 the elements lock and the surface stress is wrong"),
    "density_kg_m3": Number(500.0, 25000.0, "kg/m3"),
}
JOHNSON_COOK = {
    "A_Pa": Number(1e6, 5e9, "Pa"),
    "B_Pa": Number(0.0, 1e10, "Pa"),
    "n": Number(0.01, 2.0),
    "C": Number(0.0, 0.5, "", 0.0, "no rate dependence given"),
    "rate_ref_1_s": Number(1e-6, 1e4, "1/s", 1.0, "the usual reference rate"),
    "m": Number(0.0, 5.0, "", 0.0, "no thermal softening given"),
    "reference_K": Number(50.0, 2000.0, "K", 293.0, "room temperature"),
    "taylor_quinney": Number(0.0, 1.0, "share", 0.9, "the usual share of plastic work that becomes heat; grade C"),
}
JOHNSON_COOK_OPTIONAL = {  # no default: what they are for is not modelled without them
    "melting_K": Number(100.0, 5000.0, "K"),
    "specific_heat_J_kg_K": Number(50.0, 5000.0, "J/kg/K"),
    "saturation_Pa": Number(1e6, 1e10, "Pa"),
}
CURVES = ("johnson_cook", "voce", "table")  # a material has one of them
TABLE_STRAIN, TABLE_STRESS, MAX_TABLE = Number(0.0, 10.0), Number(1e5, 1e10, "Pa"), 50
COMBINED = {
    "R0_Pa": Number(1e5, 5e9, "Pa"),
    "Q_Pa": Number(0.0, 1e10, "Pa"),
    "b": Number(0.01, 1e4),
}
BACKSTRESS = {"X_Pa": Number(0.0, 5e9, "Pa"), "gamma": Number(0.01, 1e5)}

RESTITUTION = {
    "shot_target": Ratio(
        "from_dimple", "from_dimple", "computed by the single impact of this scene; grade D"
    ),
    "shot_shot": Ratio("", 0.8, "steel on steel, .6-.9; grade C"),
}
SPOT_HARDENING = {
    # ten impacts at one spot of 2024, combined law, 60 m/s: .336 .417 .464 .536 (5th) .627 (10th), fitted within .011
    "saturated": Ratio(
        "", 0.65, "twice the first rebound, computed for ten centred impacts on 2024; elsewhere grade C"
    ),
    "hits": Number(0.1, 1e3, "", 4.0, "computed for ten centred impacts on 2024, an upper bound; elsewhere grade C"),
}
GRAVITY = {
    "acceleration_m_s2": Number(1e-3, 1e3, "m/s2", 9.81, "standard gravity; grade D"),
    "direction": Vector(
        "xyz", Number(-1e6, 1e6), (0.0, 0.0, -1.0), "the target lies level, surface up; choice of this project"
    ),
}
AIR_DRAG = {
    "gas_density_kg_m3": Number(1e-3, 1e3, "kg/m3", 1.204, "air at 20 °C and 1013 hPa; grade C"),
    "gas_viscosity_Pa_s": Number(1e-7, 1e-1, "Pa s", 1.81e-5, "air at 20 °C; grade C"),
    "gas_speed_m_s": Number(0.0, 500.0, "m/s", 0.0, "still gas; choice of this project"),
}
FRICTION = {
    "shot_target": Number(0.0, 1.0, "share", 0.2, "used in an open peening chain; grade A"),
    "shot_shot": Number(0.0, 1.0, "share", 0.2, "steel on steel, .1-.3; grade C"),
    "in_dimple": Flag(False, "the dimple is pressed without friction; choice of this project"),
}
STRAIN_RATE = {"thermal": Flag(False, "isothermal; choice of this project")}

_AUTO = "the models that this version has"
MODELS = {
    "flow": Word(("auto", "ballistic", "event", "dem"), "auto", "the cheapest that is accurate enough"),
    "dimple": Word(("auto", "axisymmetric", "small_strain"), "auto", _AUTO),
    "target": Word(
        ("auto", "layers", "cell", "contact"),
        "auto",
        "the layer model at preset fast, else the periodic cell",
    ),
}
# The preset's numbers are the defaults of the rest: "peen check" prints them expanded.
ACCURACY = {
    "preset": Word(tuple(PRESETS), DEFAULT_PRESET, "choice of this project"),
    "target_patches": Integer(1, 64, 1, "one patch of the window stands for all; choice of this project"),
    "flow_tolerance": Number(1e-5, 0.5, "share"),
    "flow_dt_over_P": Number(0.01, 12.0),
    "flow_stiffness_scale": Number(1e-4, 1.0, "share"),
    "dimple_elements_per_radius": Integer(2, 32),
    "dimple_steps_per_contact": Number(20.0, 1000.0),
    "dimple_speeds": Integer(2, 33),
    "dimple_speed_ratio": Number(1.005, 2.0),
    "cell_side_in_radii": Number(3.0, 16.0),
    "cell_elements_per_side": Integer(4, 24),
    "cell_load_steps": Integer(1, 40),
    "cell_force_tolerance": Number(1e-5, 0.1, "share"),
    "coverage_points_per_radius": Number(2.0, 200.0),
    "stamp_points_per_radius": Number(2.0, 100.0),
}

# Where a key belongs when it stands in the wrong table; keys found in several tables have no single home.
_HOMES = {
    "the top of the file": TOP | {"coverage_percent": None},
    "[shots]": {key: SHOTS[key] for key in ("grade", "diameter_m", "size", "size_cv", "mass_fraction")},
    "[nozzle]": NOZZLE | SPECIFIED | {"air_pressure_Pa": None} | JET | FEED | PULSE,
    "[target]": {"material": None, "window_m": None, "thickness_m": None, "initial_stress": None},
    "[gravity]": {"acceleration_m_s2": None},
    "[air_drag]": AIR_DRAG,
    "[strain_rate]": STRAIN_RATE,
    "[friction]": {"in_dimple": None},
    "[restitution.hardening]": SPOT_HARDENING,
    "[accuracy]": ACCURACY,
    "[measured]": MEASURED,
}
BELONGS_IN = {key: home for home, keys in _HOMES.items() for key in keys if key != "name"}
