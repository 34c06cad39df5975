"""The patches of the window that a cell or block solves, one after another, and what they say together."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np

from glue.study.stage import Work
from glue.study.target_outputs import write_outputs
from glue.target.patch import Patch

# What one patch says about these is not the mean: the worst, or all of them.
_WORST, _SUM = ("balance_error",), ("impacts", "wall_s", "unresolved_impacts")
_MEAN = ("exposure", "window_exposure", "neglected_energy_share", "unresolved_energy_share")


def solve_patches(
    work: Work, patches: list[Patch], solve: Callable[[Patch, Path, Callable[[float, str], None]], object]
) -> tuple[list, dict, list[str]]:
    """(results, what metrics.json tells of them, names of files written): ``solve(patch, folder, progress)`` for each patch.

    One patch works in ``target/``, several in ``target/patch-1/`` and on; each writes its fields and its own surface.
    """
    results, files, surfaces = [], [], []
    for k, patch in enumerate(patches):
        name = "target" if len(patches) == 1 else f"target/patch-{k + 1}"

        def tell(share: float, text: str, k: int = k) -> None:
            count = "" if len(patches) == 1 else f"patch {k + 1} of {len(patches)}, "
            work.progress((k + share) / len(patches), count + text)

        result = solve(patch, work.path / name, tell)
        rough, written = write_outputs(work.path / name, result)
        results.append(result)
        surfaces.append(rough)
        files += [f"{name}/{file}" for file in ("driver.edp", *written)]
    target = {"patches": len(patches)}
    values = [_of_patch(result) for result in results]
    for key in values[0]:
        column = [value[key] for value in values]
        target[key] = max(column) if key in _WORST else sum(column) if key in _SUM else float(np.mean(column))
    target["dofs"] = results[0].dofs
    target |= _mean_surface(surfaces)
    faint = target["unresolved_impacts"]
    if faint:
        target["warning"] = (
            f"{faint} of {target['impacts']} impacts ({target['unresolved_energy_share']:.1%} of the energy) leave dimples finer"
            " than the mesh: their energy is spent over wider, shallower dents; a finer preset, or a scene with the small"
            " shots alone, shows them"
        )
    return results, target, files


def _of_patch(result) -> dict:
    found = {key: getattr(result, key) for key in (*_WORST, *_SUM, "unresolved_energy_share")}
    return found | {key: getattr(result.patch, key) for key in _MEAN[:3]}


def _mean_surface(surfaces: list[dict]) -> dict:
    """Means over the patches; a value that one of them does not have is none, with its reason."""
    found = dict(surfaces[0])
    for key in ("Sa_m", "Sq_m", "Sz_m", "Ssk"):
        missing = [s for s in surfaces if s[key] is None]
        found[key] = None if missing else float(np.mean([s[key] for s in surfaces]))
        if missing:
            found[f"{key}_reason"] = missing[0][f"{key}_reason"]
    return found


def means(results: list, *names: str) -> dict:
    """{name: mean over ``results``}."""
    return {name: float(np.mean([getattr(result, name) for result in results])) for name in names}


def mean_profile(profiles: list[dict[str, np.ndarray]]) -> tuple[dict[str, np.ndarray], dict]:
    """(columns of the stress profile, scatter for metrics.json) from those of each patch, all at the same depths.

    Stresses and strain are means; scatter over position is the root of the mean square.  Several patches add their standard
    deviation (n - 1) of every mean: sigma_xx_std_patches_Pa, sigma_yy_std_patches_Pa, peeq_std_patches.  A column that is
    nan throughout is left out: layers know no scatter.
    """
    columns = {}
    for name in profiles[0]:
        each = np.array([profile[name] for profile in profiles])
        if not np.isnan(each).all():
            columns[name] = np.sqrt((each**2).mean(axis=0)) if "_std" in name else each.mean(axis=0)
    if len(profiles) == 1:
        return columns, {}
    for name in ("sigma_xx_Pa", "sigma_yy_Pa", "peeq"):
        head, unit = (name[:-3], "_Pa") if name.endswith("_Pa") else (name, "")
        columns[f"{head}_std_patches{unit}"] = np.std([p[name] for p in profiles], axis=0, ddof=1)
    stress = np.array([0.5 * (p["sigma_xx_Pa"] + p["sigma_yy_Pa"]) for p in profiles])
    scatter = {
        "surface_std_patches_Pa": float(stress[:, 0].std(ddof=1)),
        "max_compressive_std_patches_Pa": float(stress.min(axis=1).std(ddof=1)),
        "scatter_patches": float(stress.std(axis=0, ddof=1).max() / max(abs(stress.mean(axis=0)).max(), math.ulp(0.0))),
    }
    return columns, scatter
