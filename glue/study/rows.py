"""How metrics are shown to people: sections in reading order, labels and units; for the summary and the page."""

from __future__ import annotations

import math

CAUSES = {
    "statistical": "statistical", "numerical": "numerical", "material_law": "material law",
    "restitution_friction": "restitution and friction",
}  # fmt: skip
# section of metrics.json: (title, ((key, label, factor to the printed unit, unit, digits), ...))
ROWS = {
    "coverage": ("Coverage", (
        ("final", "at the end", 100, "%", 2),
        ("time_98_s", "time to 98 %", 1, "s", 2),
        ("percent", "as the trade counts (98 % is full)", 1, "%", 0),
        ("avrami_final", "Avrami, at the end", 100, "%", 2),
        ("avrami_time_98_s", "Avrami, time to 98 %", 1, "s", 2),
        ("avrami_mass_flow_final", "Avrami by mass flow, at the end", 100, "%", 2),
        ("avrami_mass_flow_time_98_s", "Avrami by mass flow, time to 98 %", 1, "s", 2),
        ("avrami_undisturbed_time_98_s", "undisturbed shots, time to 98 %", 1, "s", 2),
        ("peeq_final", "by plastic strain, at the end", 100, "%", 2),
        ("impacts_in_window", "impacts centred in the window", 1, "", 0),
        ("beyond_table_share", "of them slower or faster than any solved", 100, "%", 2),
        ("beyond_table_area_share", "their share of the dimples' area", 100, "%", 3),
    )),
    "residual_stress": ("Residual stress", (
        ("surface_Pa", "at the surface", 1e-6, "MPa", 0),
        ("surface_xray_Pa", "at the surface, as X-rays weigh it", 1e-6, "MPa", 0),
        ("max_compressive_Pa", "largest compressive", 1e-6, "MPa", 0),
        ("max_compressive_depth_m", "at depth", 1e6, "µm", 0),
        ("tenth_depth_m", "down to a tenth of it at depth", 1e6, "µm", 0),
        ("compressive_depth_m", "turns to tension at depth", 1e6, "µm", 0),
        ("force_balance_relative", "force balance, ∫σdz / ∫|σ|dz", 1, "", 3),
        ("scatter_patches", "scatter over patches, largest mean", 100, "%", 1),
        ("max_compressive_std_patches_Pa", "scatter of the largest compressive", 1e-6, "MPa", 0),
        ("arc_height_m", "arc height, were it an Almen strip", 1e6, "µm", 1),
        ("moment_balance_relative", "moment balance, ∫σzdz / max|σ|h²", 1, "", 4),
        ("over_measured_mean_Pa", "less the measured, mean", 1e-6, "MPa", 0),
        ("over_measured_rms_Pa", "less the measured, rms", 1e-6, "MPa", 0),
        ("over_measured_largest_Pa", "less the measured, largest", 1e-6, "MPa", 0),
        ("warning", "warning", None, "", 0),
    )),
    "roughness": ("Roughness", (
        ("Sa_m", "Sa", 1e6, "µm", 2),
        ("Sq_m", "Sq", 1e6, "µm", 2),
        ("Sz_m", "Sz", 1e6, "µm", 1),
        ("Ssk", "Ssk", 1, "", 2),
        ("Sku", "Sku", 1, "", 2),
        ("Ra_m", "Ra, mean over lines", 1e6, "µm", 2),
        ("Rz_m", "Rz, mean over lines", 1e6, "µm", 1),
        ("over_measured_Ra", "Ra over the measured, less one", 100, "%", 0),
        ("over_measured_Rz", "Rz over the measured, less one", 100, "%", 0),
        ("levelling", "levelling", None, "", 0),
        ("filter", "filter", None, "", 0),
        ("warning", "warning", None, "", 0),
    )),
    "dimple": ("One dimple", (
        ("radius_m", "radius at zero height", 1e6, "µm", 1),
        ("depth_m", "depth", 1e6, "µm", 1),
        ("restitution", "restitution", 1, "", 3),
        ("peak_force_N", "peak force", 1, "N", 0),
        ("contact_time_s", "contact time", 1e6, "µs", 2),
        ("table_from_m_s", "solved from", 1, "m/s", 2),
        ("table_to_m_s", "solved up to", 1, "m/s", 1),
        ("warning", "warning", None, "", 0),
    )),
    "flow": ("Shot stream", (
        ("impacts", "impacts on the target", 1, "", 0),
        ("mean_normal_speed_m_s", "mean normal speed", 1, "m/s", 1),
        ("collided_fraction", "met another shot first", 100, "%", 1),
        ("mean_normal_energy_fraction", "mean normal energy over the nozzle's", 100, "%", 1),
        ("collision_number", "collision number", 1, "", 3),
        ("warning", "warning", None, "", 0),
    )),
    "intensity": ("Almen intensity, confirmed by cells of strip steel", (
        ("asked_m", "asked for", 1e3, "mm", 4),
        ("layers_m", "by layers, at the speed found", 1e3, "mm", 4),
        ("cells_m", "by cells", 1e3, "mm", 4),
        ("cells_standard_error_relative", "standard error of their mean", 100, "%", 1),
        ("over_asked", "cells over what was asked for, less one", 100, "%", 1),
        ("confirmed", "confirmed", None, "", 0),
        ("warning", "warning", None, "", 0),
    )),
    "target": ("Target model", (
        ("model", "model", None, "", 0),
        ("impacts", "impacts solved", 1, "", 0),
        ("exposure", "dimple areas over cell area", 1, "", 2),
        ("window_exposure", "the same in the window", 1, "", 2),
        ("neglected_energy_share", "energy of impacts too faint to solve", 100, "%", 2),
        ("nominal_depth_error", "single dimple on this mesh, depth error", 100, "%", 1),
        ("nominal_force_error", "single dimple on this mesh, force error", 100, "%", 1),
        ("unresolved_energy_share", "energy of dimples finer than the mesh", 100, "%", 2),
        ("Sa_m", "Sa of the model's own surface", 1e6, "µm", 1),
        ("Sq_m", "Sq", 1e6, "µm", 1),
        ("Sz_m", "Sz", 1e6, "µm", 0),
        ("Ssk", "Ssk", 1, "", 2),
        ("surface_side_m", "side of the square it was taken from", 1e3, "mm", 2),
        ("patches", "patches of the window solved", 1, "", 0),
        ("restitution_mean", "restitution, mean of the impacts solved", 1, "", 3),
        ("restitution_flow_mean", "the same in the shot stream", 1, "", 3),
        ("restitution_fresh", "restitution on fresh spots", 1, "", 3),
        ("restitution_flow_fresh", "the same in the shot stream", 1, "", 3),
        ("strain", "strain", None, "", 0),
        ("dofs", "unknowns", 1, "", 0),
        ("warning", "warning", None, "", 0),
    )),
}  # fmt: skip


def shown(values: dict, key: str, factor: float | None, unit: str, digits: int) -> str:
    """``values[key]`` in its printed unit; for null its reason; ``factor`` None prints it as it is."""
    value = values[key]
    if value is None:
        return f"not determined: {values.get(f'{key}_reason', 'no reason given')}"
    if factor is None:
        return str(value)
    return f"{round(value * factor, digits) + 0.0:.{digits}f} {unit}".strip()  # + 0.0: no "-0.000"


def interval(metrics: dict, section: str, key: str, factor: float | None, unit: str, digits: int) -> str:
    """" ± 0.61 %, mostly statistical": the metric's 95 % interval in its printed unit; empty where there is none."""
    found = metrics.get("uncertainty", {}).get(f"{section}.{key}")
    if not found or factor is None or found["mostly"] is None:
        return ""
    half = found["half_width_95"] * factor
    digits = max(digits, 0 if half == 0.0 else 1 - math.floor(math.log10(half)) - 1)  # one digit of it at least
    return f" ± {half:.{digits}f} {unit}".rstrip() + f", mostly {CAUSES[found['mostly']]}"
