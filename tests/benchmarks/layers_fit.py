"""The layer model's constants, fitted to periodic cells again and judged on cases and exposures kept out of the fit.

    python tests/benchmarks/layers_fit.py [--json FILE]       (make fit-layers)

Training, held-out cases and exposures stand in layers_held_out.toml; layers_cases.py runs the cells (a minute each,
once).  Model and truth are means over the cell's element layers.  The rows say: are the constants in
glue/target/layers.py those of this fit, how large is the rms error between .17 and 1.3 dimple radii of depth as a share
of the profile's largest stress, how long does one evaluation take.  Notes behind a row, all but the last over the same largest
stress: mean error in the judged depths (+: too little compression), error of the topmost layer, rms below the judged
depths; relative error of the plastic strain.
"""

from __future__ import annotations

import time

import numpy as np
from layers_cases import PLAN, Case, Profile, all_cases
from scipy.optimize import least_squares

from glue.checkrows import Rows
from glue.target.layers import CALIBRATED, CONSTANTS, Constants, LayerShape, LayersResult, layer_profile, layer_shape
from glue.target.strength import full_strength_Pa

START = (0.8, 0.3, 0.15, 0.2, 1.0, 2.0, 190.0, 5.0)  # near what was known before; not where the fit ends
LOWER, UPPER = (0.2, 0.0, 0.02, 0.02, 0.5, 0.0, 0.0, 0.0), (1.5, 1.0, 1.0, 2.0, 10.0, 10.0, 1e3, 1e3)
_PER_LAYER = 8  # depths whose mean stands for an element layer's
TIME_LIMIT_S = 0.010
CONSTANT_BAND = 0.02  # relative: what a constant may have moved before layers.py is out of date


class Judged:
    """A case and the shape of its impact, or of another speed's: what the model needs and what it is held against."""

    def __init__(self, case: Case, other: Judged | None = None):
        self.case, self.scaled = case, other is not None
        self.shape = other.shape if other else layer_shape(case.impact, case.material.combined)
        solved, shots = (other or self).case.dimple, case.shots
        energy = shots.diameter_m**3 * shots.speed_m_s**2 / (solved.diameter_m**3 * solved.speed_m_s**2)  # one density
        self.work_ratio = energy * (solved.radius_m / shots.radius_m) ** 3
        edges, inner = case.bounds, (np.arange(_PER_LAYER) + 0.5) / _PER_LAYER
        self.depths_m = (edges[:-1, None] + np.diff(edges)[:, None] * inner).ravel() * case.dimple.radius_m
        middle, (low, high) = 0.5 * (edges[:-1] + edges[1:]), PLAN["depths_in_radii"]
        self.band, self.below = (middle >= low) & (middle <= high), middle > high

    def label(self, profile: Profile) -> str:
        """Which set a profile belongs to."""
        if self.scaled:
            return "other speed's shape"
        if not self.case.training:
            return "held-out case"
        return "fit" if profile.wanted in PLAN["fit_exposures"] else "held-out exposure"

    def model(self, profile: Profile, constants: Constants) -> LayersResult:
        """The model under the impacts of ``profile``, ``_PER_LAYER`` depths in each element layer."""
        n, case = profile.impacts, self.case
        return layer_profile(self.shape, case.material, case.shots.radius_m[:n], case.side_m**2, self.depths_m,
                             work_ratio=self.work_ratio[:n], constants=constants, check=False)  # fmt: skip

    def errors(self, profile: Profile, constants: Constants) -> np.ndarray:
        """Model minus truth over the truth's largest stress, (layers,); above 0: too little compression."""
        return (means(self.model(profile, constants).sigma_xx_Pa) - profile.sigma_Pa) / np.abs(profile.sigma_Pa).max()

    def strain_error(self, profile: Profile, constants: Constants) -> float:
        """Plastic strain summed over the judged layers, relative to the truth's."""
        return float(means(self.model(profile, constants).peeq)[self.band].sum() / profile.peeq[self.band].sum() - 1.0)


def means(values: np.ndarray) -> np.ndarray:
    """Of the depths inside each element layer, (layers,)."""
    return values.reshape(-1, _PER_LAYER).mean(axis=1)


def fit(training: list[Judged]) -> Constants:
    """Least squares over every layer of the training cases at the exposures of the fit."""

    def residuals(x):
        constants = Constants(*x)
        return np.concatenate([
            judged.errors(p, constants)
            for judged in training for p in judged.case.profiles if p.wanted in PLAN["fit_exposures"]
        ])  # fmt: skip

    found = least_squares(residuals, START, bounds=(LOWER, UPPER), x_scale=START)
    return Constants(*found.x.tolist())


def rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def judge(rows: Rows, cases: list[Judged], constants: Constants) -> None:
    """One row for each profile, then one for each set."""
    sets: dict[str, list[float]] = {}
    for judged in cases:
        for p in judged.case.profiles:
            label = judged.label(p)
            off = judged.errors(p, constants)
            sets.setdefault(label, []).append(rms(off[judged.band]))
            note = f"mean {np.mean(off[judged.band]):+.1%}, top layer {off[0]:+.1%}, below {rms(off[judged.below]):.1%}"
            note += f", strain {judged.strain_error(p, constants):+.0%}"
            rows.below(f"{label}: {judged.case.name}, exposure {p.exposure:.2f}", sets[label][-1], PLAN["rms_limit"], note)
    for label, values in sets.items():
        rows.below(f"{label}: rms of {len(values)} profiles", rms(np.array(values)), PLAN["rms_limit"],
                   f"worst {max(values):.1%}")  # fmt: skip


def spans(cases: list[Judged]) -> dict[str, tuple[float, float]]:
    """What these cases span of the numbers in ``CALIBRATED``."""
    found = []
    for judged in cases:
        metal, full = judged.case.material, full_strength_Pa(judged.case.material.combined, CONSTANTS.g0, CONSTANTS.g1)
        ends = full / metal.E_Pa, full / metal.combined.R0_Pa, judged.shape.radius_R
        found += [(p.exposure, *ends) for p in judged.case.profiles]
    return {name: (min(v), max(v)) for name, v in zip(CALIBRATED, zip(*found, strict=True), strict=True)}


def seconds(shape: LayerShape, case: Case, radii_m: np.ndarray) -> float:
    """Best of twenty evaluations at exposure 4."""
    area, best = float(np.pi * (radii_m**2).sum() / 4.0), np.inf
    for _ in range(20):
        begun = time.perf_counter()
        layer_profile(shape, case.material, radii_m, area, check=False)
        best = min(best, time.perf_counter() - begun)
    return best


def main() -> None:
    rows = Rows("Layer model against periodic cells")
    cases = [Judged(case) for case in all_cases()]
    constants = fit([judged for judged in cases if judged.case.training])
    for name, value in constants._asdict().items():
        rows.near(f"constant {name}: fitted, expected that of layers.py", value, getattr(CONSTANTS, name), CONSTANT_BAND)
    for name, (low, high) in spans(cases).items():
        known = CALIBRATED[name]
        inside = known.low <= low * 1.01 and high <= known.high * 1.01
        covered = known.low >= low * 0.99 and known.high <= high * 1.01
        told = f"cases {low:.4g} to {high:.4g}, layers.py {known.low:g} to {known.high:g}"
        rows.true(f"calibrated range of {name}", inside and covered, told)
    first = cases[0]
    # A log of many speeds has the shape of one of them: 2024's at 60 m/s, stretched to the dimples of its other cases.
    metal, speed = first.case.material, first.case.dimple.speed_m_s
    others = [j.case for j in cases if j.case.material == metal and j.case.dimple.speed_m_s != speed]
    scaled = [Judged(case, first) for case in others]
    judge(rows, cases + scaled, constants)
    radius = first.case.dimple.radius_m
    mixed = radius * np.random.default_rng(1).lognormal(0.0, 0.2, 10_000)
    for name, radii in (("400 equal impacts", np.full(400, radius)), ("10000 impacts of all sizes", mixed)):
        rows.below(f"seconds of one evaluation, {name}", seconds(first.shape, first.case, radii), TIME_LIMIT_S)
    rows.finish()


if __name__ == "__main__":
    main()
