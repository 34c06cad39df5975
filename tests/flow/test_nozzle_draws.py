"""What leaves a nozzle: sizes, media, mass, speeds, directions and rhythm follow the scene."""

import dataclasses
import math
from itertools import pairwise

import numpy as np
import pytest
from scipy.stats import chi2, kstest, truncnorm

from glue.flow import arrivals
from glue.flow.nozzle_draws import PLACE, places_m, stream
from glue.scene import model

SIEVE = ((0.5e-3, 0.0), (0.6e-3, 0.1), (0.71e-3, 0.4), (0.85e-3, 0.9), (1.0e-3, 1.0))
SIEVED = {"size": "sieve", "sieve": SIEVE}
SPREAD = {"size": "distribution", "size_cv": 0.09}


def medium(scene, **changes):
    return dataclasses.replace(scene.shots, **changes)


def two_media(make_scene, **changes):
    """60 % of the mass 1 mm steel with spread, 40 % 0.6 mm ceramic."""
    scene = make_scene(**changes)
    media = (
        medium(scene, mass_fraction=0.6, **SPREAD),
        medium(scene, mass_fraction=0.4, diameter_m=0.6e-3, density_kg_m3=3800.0),
    )
    return dataclasses.replace(scene, media=media)


def mass_kg(shots):
    return shots["density_kg_m3"] * math.pi / 6.0 * shots["diameter_m"] ** 3


def sieved_share(d):
    """Number of shots finer than ``d``: between two openings shots per diameter fall as d^-3."""
    count = np.zeros(np.shape(d))
    whole = 0.0
    for (a, finer), (b, up_to) in pairwise(SIEVE):
        per_m = (up_to - finer) / (b - a)
        x = np.clip(d, a, b)
        count += per_m * 0.5 * (a**-2 - x**-2)
        whole += per_m * 0.5 * (a**-2 - b**-2)
    return count / whole


def test_sizes(make_scene):
    def drawn(**sizes):
        return arrivals.draw_arrivals(make_scene(exposure_time_s=0.5, **sizes))["diameter_m"]

    assert set(drawn()) == {1e-3}
    assert kstest(drawn(**SPREAD), truncnorm(-2.5, 2.5, 1e-3, 0.09e-3).cdf).pvalue > 0.01
    assert kstest(drawn(**SIEVED), sieved_share).pvalue > 0.01


def test_sieve_shares_by_mass(make_scene):
    shots = arrivals.draw_arrivals(make_scene(exposure_time_s=1.0, **SIEVED))
    mass = mass_kg(shots)
    for opening, finer in SIEVE[1:-1]:
        sd = math.sqrt(finer * (1 - finer) * (mass**2).sum()) / mass.sum()
        assert mass[shots["diameter_m"] < opening].sum() / mass.sum() == pytest.approx(finer, abs=3 * sd)


def test_media_share_the_mass(make_scene):
    scene = two_media(make_scene, exposure_time_s=0.5)
    shots = arrivals.draw_arrivals(scene)
    mass = mass_kg(shots)
    for k, share in ((0, 0.6), (1, 0.4)):
        of_k = shots["medium"] == k
        expected = share * 5.0 / 60.0 * 0.5
        assert mass[of_k].sum() == pytest.approx(expected, abs=3 * math.sqrt((mass[of_k] ** 2).sum()))
        assert set(shots["density_kg_m3"][of_k]) == {scene.media[k].density_kg_m3}
    assert mass_kg(shots[shots["medium"] == 1]).max() == pytest.approx(3800.0 * math.pi / 6 * 0.6e-3**3)


@pytest.mark.parametrize("pulse", [None, model.Pulse("pulsed", 7.0, duty=0.4)])
@pytest.mark.parametrize("sizes", [SPREAD, SIEVED])
def test_exact_mass_is_right_to_one_shot(make_scene, pulse, sizes):
    scene = two_media(make_scene, exposure_time_s=2.0, arrivals="exact_mass", pulse=pulse)
    scene = dataclasses.replace(scene, media=(medium(scene, mass_fraction=0.6, **sizes), scene.media[1]))
    flows = (0.02, 0.05)
    scene = dataclasses.replace(
        scene, nozzles=tuple(dataclasses.replace(scene.nozzle, mass_flow_kg_s=f) for f in flows)
    )
    shots = arrivals.draw_arrivals(scene)
    for number, flow_kg_s in enumerate(flows):
        for k, share in enumerate((0.6, 0.4)):
            mass = mass_kg(shots[(shots["nozzle_id"] == number) & (shots["medium"] == k)])
            assert abs(mass.sum() - share * flow_kg_s * 2.0) < 0.51 * mass.max()
    if pulse is None:
        assert kstest(shots["time_s"] / 2.0, "uniform").pvalue > 0.01
    else:
        assert (shots["time_s"] * 7.0 % 1.0).max() < 0.4
    # media come mixed, not one after the other
    first, second = (shots["time_s"][shots["medium"] == k] for k in (0, 1))
    assert abs(np.median(first) - np.median(second)) < 0.1


def test_poisson_counts_of_every_nozzle_and_medium(make_scene):
    scene = two_media(
        make_scene, exposure_time_s=0.003, pulse=model.Pulse("sinusoidal", 400.0, amplitude=0.8)
    )
    scene = dataclasses.replace(scene, nozzles=(scene.nozzle, dataclasses.replace(scene.nozzle, pulse=None)))
    seeds, counts = 1000, []
    for seed in range(seeds):
        shots = arrivals.draw_arrivals(dataclasses.replace(scene, seed=seed))
        counts.append(np.bincount(2 * shots["nozzle_id"] + shots["medium"], minlength=4))
    counts = np.array(counts)
    dispersion = (counts.var(axis=0, ddof=1) / counts.mean(axis=0)) * (seeds - 1)
    low, high = chi2.ppf([0.005 / 4, 1 - 0.005 / 4], seeds - 1)  # 1 % for the four together
    assert np.all((low < dispersion) & (dispersion < high))
    assert np.abs(np.corrcoef(counts.T) - np.eye(4)).max() < 3.5 / math.sqrt(
        seeds
    )  # independent of each other
    # steady nozzle: 0.6 of 5 kg/min in 1 mm shots of cv 0.09 for 3 ms, its cube's mean 1 + 3 x 0.9113 x 0.0081
    expected = 0.6 * 5 / 60 * 0.003 / (7800 * math.pi / 6 * 1e-9 * (1 + 3 * 0.9113 * 0.0081))
    assert counts[:, 2].mean() == pytest.approx(expected, abs=3 * math.sqrt(expected / seeds))


def exit_radius(shots, nozzle):
    """(distance from the axis at the exit, unit vectors outwards) of shots of a nozzle aimed at the origin."""
    p = np.stack([shots[f"{c}_m"] for c in "xyz"], axis=1) + nozzle.stand_off_m * np.array(nozzle.direction)
    r = np.linalg.norm(p, axis=1)
    return r, p / r[:, None]


def test_gaussian_profile(make_scene):
    scene = make_scene(profile="gaussian", exposure_time_s=1.0, impact_angle_deg=50.0, azimuth_deg=110.0)
    r, _ = exit_radius(arrivals.draw_arrivals(scene), scene.nozzle)
    # sd 5 mm in each direction, cut at the 10 mm edge
    assert kstest(r, lambda x: -np.expm1(-0.5 * (x / 0.005) ** 2) / -math.expm1(-2.0)).pvalue > 0.01


def test_gaussian_places_have_no_preferred_direction(make_scene):
    """P-values of many streams are themselves even: one stream alone would see only a gross lean."""
    nozzle = make_scene(profile="gaussian").nozzle
    places = (places_m(stream(seed, PLACE), nozzle, 5000) for seed in range(1, 201))
    even = [kstest(np.arctan2(b, a), "uniform", args=(-math.pi, 2 * math.pi)).pvalue for a, b in places]
    assert kstest(even, "uniform").pvalue > 0.01


def test_divergence_tilts_outwards_with_the_radius(make_scene):
    scene = make_scene(divergence_half_angle_deg=10.0, impact_angle_deg=45.0, azimuth_deg=30.0)
    shots = arrivals.draw_arrivals(scene)
    r, outwards = exit_radius(shots, scene.nozzle)
    v = np.stack([shots[f"v{c}_m_s"] for c in "xyz"], axis=1)
    assert np.abs(np.linalg.norm(v, axis=1) - 60.0).max() < 1e-12
    axial = v @ np.array(scene.nozzle.direction)
    assert (v * outwards).sum(axis=1) / axial == pytest.approx(math.tan(math.radians(10.0)) * r / 0.010)


def test_speed_spread(make_scene):
    plain = arrivals.draw_arrivals(make_scene(exposure_time_s=0.5))
    shots = arrivals.draw_arrivals(make_scene(exposure_time_s=0.5, speed_cv=0.08))
    assert kstest(-shots["vz_m_s"], truncnorm(-2.5, 2.5, 60.0, 4.8).cdf).pvalue > 0.01
    for name in ("time_s", "diameter_m"):  # other purposes keep their draws
        assert shots[name].tobytes() == plain[name].tobytes()


@pytest.mark.parametrize(
    "pulse", [model.Pulse("pulsed", 50.0, duty=0.35), model.Pulse("sinusoidal", 50.0, amplitude=0.9)]
)
def test_times_follow_the_pulse(make_scene, pulse):
    shots = arrivals.draw_arrivals(make_scene(exposure_time_s=1.0, pulse=pulse))
    phase = shots["time_s"] * 50.0 % 1.0
    edges = np.linspace(0.0, 1.0, 41)
    if pulse.pattern == "pulsed":
        share = np.clip(edges, 0.0, 0.35) / 0.35
    else:
        share = edges + 0.9 * (1.0 - np.cos(2 * np.pi * edges)) / (2 * np.pi)
    expected = 20_404.5 * np.diff(share)
    counts = np.histogram(phase, edges)[0]
    assert counts[expected < 1e-9].sum() == 0
    counts, expected = counts[expected > 1e-9], expected[expected > 1e-9]
    assert chi2.sf(((counts - expected) ** 2 / expected).sum(), len(counts)) > 0.01


def test_feed_carries_the_exit_along_its_path(make_scene):
    feed = model.Feed(speed_m_s=0.02, stroke_m=0.01, passes=2, pitch_m=0.003, dwell_s=0.1)
    scene = make_scene(exposure_time_s=1.2, feed=feed, mass_flow_kg_s=0.02)
    shots = arrivals.draw_arrivals(scene)
    t = shots["time_s"]
    assert set(shots["pass_id"][t < 0.6]) == {0} and set(shots["pass_id"][t > 0.6]) == {1}
    for time, x, y in (
        (0.0, -5e-3, -1.5e-3),
        (0.25, 0.0, -1.5e-3),
        (0.85, 0.0, 1.5e-3),
        (1.1, -5e-3, 1.5e-3),
    ):
        near = np.abs(t - time - 0.025) < 0.025  # 1 mm of path
        middle = np.array([x, y]) + [(0.0005 if time < 0.6 else -0.0005) * (time < 1.1), 0.0]
        mean = np.array([shots["x_m"][near].mean(), shots["y_m"][near].mean()])
        # R/2 is the sd of one coordinate in an even disc
        assert np.abs(mean - middle).max() < 3.5 * 0.005 / math.sqrt(near.sum())


def test_one_nozzle_more_leaves_the_first_one_alone(make_scene):
    scene = make_scene()
    beside = dataclasses.replace(scene.nozzle, aim_m=(0.1, 0.0), mass_flow_kg_s=0.01)
    alone = arrivals.draw_arrivals(scene)
    both = arrivals.draw_arrivals(dataclasses.replace(scene, nozzles=(scene.nozzle, beside)))
    first = both[both["nozzle_id"] == 0]
    first["shot_id"] = np.arange(len(first))
    assert first.tobytes() == alone.tobytes() and len(both) > len(alone)
    assert np.all(np.diff(both["time_s"]) >= 0.0) and np.all(both["shot_id"] == np.arange(len(both)))
