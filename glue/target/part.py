"""From the clamped cell to the part: layer means over the whole depth, with stretch and bending let go."""

from __future__ import annotations

import numpy as np

from glue.errors import InputError
from glue.theory.plate import arc_height_m, curvature_1_m, released_stress

_BELOW = 8  # points between the peened layer's floor and the part's back
FADED = 0.02  # of the largest in-plane stress: what may be left at a thin part's back before it is let go


def part_profile(layers, thickness_m: float | None, initial_stress=(), material=None) -> dict[str, np.ndarray]:
    """Columns of the stress profile by name, each (rows,), depth rising.

    layers: what a target model found, with the fields of ``cell_result.CellResult`` down to peeq_std, and floor_m.
    No thickness: the layers as they are, a part too thick to stretch or bend.  With one: a plate peened
    on one side and free to do both; the profile then reaches from the surface (extrapolated) to the back, and its
    force and moment vanish.  The floor, where the stress has faded, is taken as stress-free before release; a part
    thinner than that is cut where it ends.  Raises InputError when it ends inside the peened layer.

    ``initial_stress``: (depth [m], stress [Pa]) in both directions before peening, in balance with the part, nought below the last.
    It rests where nothing flows.  Where the metal flows on in other directions, Prandtl and Reuss's equations
    ds = 2 G (de - 3/2 s/sigma_y dp) let the part of the deviator that was there decay as exp(-3 G p/sigma_y), p the
    layer's mean plastic strain; ``material`` gives G and sigma_y.  What is lost lets the part stretch and bend too.
    """
    if len(initial_stress):
        return _with_initial(layers, thickness_m, initial_stress, material)
    columns = {name: getattr(layers, name) for name in (
        "depth_m", "sigma_xx_Pa", "sigma_yy_Pa", "peeq", "sigma_xx_std_Pa", "sigma_yy_std_Pa", "peeq_std",
    )}  # fmt: skip
    if thickness_m is None:
        return columns
    result = {"depth_m": _depths(layers, thickness_m)}
    for name, values in list(columns.items())[1:]:
        result[name] = _to_the_back(layers, values, thickness_m, name.endswith("_Pa") and "std" not in name)
    for name in ("sigma_xx_Pa", "sigma_yy_Pa"):
        result[name] = released_stress(result["depth_m"], result[name], thickness_m)
    return result


def kept_share(peeq, material) -> np.ndarray:
    """Share of an initial stress that plastic strain ``peeq`` leaves: exp(-3 G p/sigma_y), sigma_y at that strain."""
    G = 0.5 * material.E_Pa / (1.0 + material.nu)
    yield_Pa = np.array([material.combined.flow_stress_Pa(float(p)) for p in np.atleast_1d(peeq)])
    return np.exp(-3.0 * G * np.asarray(peeq, dtype=float) / yield_Pa)


def _with_initial(layers, thickness_m, initial_stress, material) -> dict[str, np.ndarray]:
    at, stress = np.array(initial_stress, dtype=float).T

    def initial(depth):
        return np.interp(depth, at, stress, right=0.0)

    lost = initial(layers.depth_m) * (1.0 - kept_share(layers.peeq, material))
    changed = _Changed(layers, lost)
    profile = part_profile(changed, thickness_m)
    for name in ("sigma_xx_Pa", "sigma_yy_Pa"):
        profile[name] = profile[name] + initial(profile["depth_m"])
    return profile


class _Changed:
    """``layers`` whose stresses are what peening changed: its own less the initial stress that it wiped out."""

    def __init__(self, layers, lost):
        self._layers, self.sigma_xx_Pa, self.sigma_yy_Pa = layers, layers.sigma_xx_Pa - lost, layers.sigma_yy_Pa - lost

    def __getattr__(self, name):
        return getattr(self._layers, name)


def strip_arc_height_m(layers, thickness_m: float, E_Pa: float, nu: float) -> float:
    """Arc height [m] that an Almen gauge would read over a strip of this thickness; layers as for ``part_profile``.

    Both in-plane stresses count alike.  Raises InputError when the strip ends inside the peened layer.
    """
    depth = _depths(layers, thickness_m)
    both = [_to_the_back(layers, s, thickness_m, True) for s in (layers.sigma_xx_Pa, layers.sigma_yy_Pa)]
    return arc_height_m(curvature_1_m(depth, np.mean(both, axis=0), thickness_m, E_Pa, nu))


def _kept(layers, thickness_m: float) -> np.ndarray:
    """Which layers lie inside the part."""
    return layers.depth_m < min(thickness_m, layers.floor_m)


def _depths(layers, thickness_m: float) -> np.ndarray:
    inside = layers.depth_m[_kept(layers, thickness_m)]
    if thickness_m <= layers.floor_m:
        return np.r_[0.0, inside, thickness_m]
    return np.r_[0.0, inside, np.linspace(layers.floor_m, thickness_m, _BELOW)]


def _to_the_back(layers, values: np.ndarray, thickness_m: float, stress: bool) -> np.ndarray:
    """``values`` at ``_depths``: carried on to the surface (a stress linearly), 0 below the peened layer."""
    share = layers.depth_m[0] / (layers.depth_m[1] - layers.depth_m[0])
    surface = values[0] - share * (values[1] - values[0]) if stress else values[0]
    if stress and thickness_m <= layers.floor_m:
        left = abs(float(np.interp(thickness_m, layers.depth_m, values)))
        if left > FADED * np.abs(values).max():
            raise InputError(
                f"target.thickness_m: {thickness_m:g} m ends inside the peened layer ({left / np.abs(values).max():.0%} of its "
                f"largest stress is left there); allowed: parts in which the stress has faded to {FADED:.0%}, or no thickness"
            )
    below = 1 if thickness_m <= layers.floor_m else _BELOW
    return np.r_[surface, values[_kept(layers, thickness_m)], np.zeros(below)]
