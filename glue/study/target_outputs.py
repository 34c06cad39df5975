"""What a cell or block leaves in the run directory beside its profile: fields for ParaView, its own surface, its roughness."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from glue.atomic import atomic_path
from glue.surface.roughness import areal
from glue.target.cell_result import CellResult
from glue.target.contact_result import ContactResult
from glue.target.fields import read_fields
from glue.target.own_surface import own_surface

REMARK = (
    "heights and roughness here are of the model's own patch; section roughness and the run's surface.npz, the stamp,"
    " are of the whole window"
)
_KEPT = ("Sa_m", "Sq_m", "Sz_m", "Ssk", "Ssk_reason")


def write_outputs(folder: Path, result: CellResult | ContactResult) -> tuple[dict, list[str]]:
    """Write ``fields.vtu`` and ``surface.npz`` of the run in ``folder``; returns (metrics of its surface, names written).

    Both are in the window's coordinates.  Raises SolverFailed and NotConverged for tables that are not whole.
    """
    from glue.meshes import write_tetrahedra  # here: loads meshio

    centre = np.array(result.patch.centre_m)
    periodic = isinstance(result, CellResult)
    origin = centre - 0.5 * result.side_m if periodic else centre
    side = result.side_m if periodic else result.measured_side_m
    at, z = own_surface(folder, result.impacts, side, period_m=result.side_m if periodic else None)
    with atomic_path(folder / "surface.npz") as part, open(part, "wb") as f:
        np.savez_compressed(f, x_m=origin[0] + at, y_m=origin[1] + at, z_m=z)
    fields = read_fields(folder, result.impacts, tuple(origin))
    write_tetrahedra(
        folder / "fields.vtu", fields.points_m, fields.tetrahedra, {"displacement_m": fields.displacement_m},
        {"stress_Pa": fields.stress_Pa, "peeq": fields.peeq},
    )  # fmt: skip
    rough = areal(z, at[1] - at[0], at[1] - at[0])
    metrics = {key: value for key, value in rough.items() if key in _KEPT}
    return metrics | {"surface_side_m": side, "surface_remark": REMARK}, ["fields.vtu", "surface.npz"]
