"""The footprint: closed forms, its Jacobian ray by ray, conservation; and the drawn shots against it, 1 % each."""

import dataclasses
import math

import numpy as np
import pytest
from scipy.stats import chi2

from glue.errors import InputError
from glue.flow import arrivals
from glue.flow.footprint import expected_impacts, fluence_1_m2
from glue.flow.nozzle_draws import expected_shots
from glue.scene import model
from glue.scene.catalogue import shot

SEED = 20261122  # of every test here, set before the first was run
PLANE = (-math.inf, math.inf, -math.inf, math.inf)
RATE_1_S = 5.0 / 60.0 / (7800.0 * math.pi / 6.0 * 1e-9)  # of the bare scene: 20 405 shots of 1 mm
R = 0.010
TRAVERSE = model.Feed(speed_m_s=0.02, stroke_m=0.04, passes=3, pitch_m=0.008, dwell_s=0.3, direction_deg=25.0)
OBLIQUE_SPREAD = {
    "impact_angle_deg": 30.0,
    "divergence_half_angle_deg": 5.0,
    "azimuth_deg": 140.0,
    "aim_m": (0.004, -0.002),
}


def landings(shots):
    """Where and when each arrival meets z = 0 in straight flight: x, y."""
    flight = -shots["z_m"] / shots["vz_m_s"]
    assert np.all(flight > 0.0)
    return shots["x_m"] + shots["vx_m_s"] * flight, shots["y_m"] + shots["vy_m_s"] * flight


def test_steady_jets_in_closed_form(make_scene):
    per_m2 = RATE_1_S * 0.02 / (math.pi * R**2)
    assert fluence_1_m2(make_scene(), [0.0, 0.0099, 0.0101], 0.0) == pytest.approx([per_m2, per_m2, 0.0])
    # 30 degrees: half the density over twice the length
    lean = make_scene(impact_angle_deg=30.0, azimuth_deg=90.0)
    assert fluence_1_m2(lean, [0.0, 0.0, 0.0099, 0.0101], [0.0, 0.0199, 0.0, 0.0]) == pytest.approx(
        [per_m2 / 2, per_m2 / 2, per_m2 / 2, 0.0]
    )
    # a Gaussian of sd R/2 cut at R: on its axis 1 / (2 pi sd^2 (1 - e^-2))
    assert fluence_1_m2(make_scene(profile="gaussian"), 0.0, 0.0) == pytest.approx(
        per_m2 * 2.0 / (1.0 - math.exp(-2.0))
    )
    # tan 5 degrees over 100 mm widen the jet from 10 to 18.75 mm
    wide = R + 0.1 * math.tan(math.radians(5.0))
    cone = make_scene(divergence_half_angle_deg=5.0)
    assert fluence_1_m2(cone, [0.0, 0.99 * wide, 1.01 * wide], 0.0) == pytest.approx(
        np.array([1.0, 1.0, 0.0]) * per_m2 * (R / wide) ** 2
    )


def test_traverse_in_closed_form(make_scene):
    feed = model.Feed(speed_m_s=0.02, stroke_m=0.06)
    scene = make_scene(feed=feed, exposure_time_s=3.0)
    y = np.array([0.0, 0.006, 0.0099, 0.011])
    chord = 2.0 * np.sqrt(np.maximum(R**2 - y**2, 0.0))
    assert fluence_1_m2(scene, 0.0, y) == pytest.approx(RATE_1_S / (math.pi * R**2) * chord / 0.02)
    assert fluence_1_m2(scene, 0.0, y, t_end=1.5) == pytest.approx(
        0.5 * RATE_1_S / (math.pi * R**2) * chord / 0.02
    )
    # on for 0.1 s in 1 s from the start: the middle is passed from 1 to 2 s, so one burst on its whole width
    pulsed = dataclasses.replace(
        scene, nozzles=(dataclasses.replace(scene.nozzle, pulse=model.Pulse("pulsed", 1.0, duty=0.1)),)
    )
    assert fluence_1_m2(pulsed, 0.0, 0.0) == pytest.approx(RATE_1_S / (math.pi * R**2))


@pytest.mark.parametrize("profile", ["uniform", "gaussian"])
def test_density_is_that_of_a_narrow_bundle_of_rays(make_scene, profile):
    """Rays traced one by one from corners of a small square in the exit, its image measured on the plane."""
    scene = make_scene(profile=profile, **OBLIQUE_SPREAD)
    nozzle, h = scene.nozzle, 1e-6
    d, (up, level) = np.array(nozzle.direction), np.array(nozzle.exit_axes)
    exit_centre = np.array([*nozzle.aim_m, 0.0]) - nozzle.stand_off_m * d
    k = math.tan(math.radians(5.0)) / R

    def lands(a, b):
        off = a * up + b * level
        start, way = exit_centre + off, d + k * off
        return (start - way * start[2] / way[2])[:2]

    for a, b in ((0.0, 0.0), (0.007, 0.002), (-0.006, -0.005), (0.001, 0.0095)):
        image = lands(a + h, b) - lands(a - h, b), lands(a, b + h) - lands(a, b - h)
        area = abs(image[0][0] * image[1][1] - image[0][1] * image[1][0]) / (2 * h) ** 2
        leave = 1.0 / (math.pi * R**2)
        if profile == "gaussian":
            leave *= 2.0 * math.exp(-2.0 * (a * a + b * b) / R**2) / (1.0 - math.exp(-2.0))
        here = lands(a, b)
        assert fluence_1_m2(scene, *here) == pytest.approx(RATE_1_S * 0.02 * leave / area, rel=1e-6)


def rich_scene(make_scene, **changes):
    """Two nozzles, one travelling and pulsed, one at rest, both spreading."""
    scene = make_scene(exposure_time_s=7.0, seed=SEED, **OBLIQUE_SPREAD, **changes)
    pulse = model.Pulse("pulsed", 3.3, duty=0.4)
    moving = dataclasses.replace(scene.nozzle, feed=TRAVERSE, pulse=pulse, profile="gaussian")
    resting = dataclasses.replace(scene.nozzle, impact_angle_deg=75.0, azimuth_deg=10.0, mass_flow_kg_s=0.02)
    return dataclasses.replace(scene, nozzles=(moving, resting))


def test_every_shot_lands_somewhere(make_scene):
    scene = rich_scene(make_scene)
    assert expected_impacts(scene, *PLANE) == pytest.approx(expected_shots(scene), rel=1e-9)
    parts = [expected_impacts(scene, *PLANE, nozzle=0, pass_id=n) for n in range(3)]
    parts += [expected_impacts(scene, *PLANE, nozzle=1)]
    assert sum(parts) == pytest.approx(expected_shots(scene), rel=1e-9)
    assert (
        expected_impacts(scene, *PLANE, nozzle=0, pass_id=1, t_end=2.25) == 0.0
    )  # 2 s of stroke, 0.3 s of dwell
    halves = [expected_impacts(scene, *side, -0.02, 0.03) for side in ((-math.inf, 0.003), (0.003, math.inf))]
    assert sum(halves) == pytest.approx(expected_impacts(scene, -math.inf, math.inf, -0.02, 0.03), rel=3e-4)


def test_rectangles_hold_the_integral_of_the_fluence(make_scene):
    """Time summed over chords against area summed over points: two ways through the same integral."""
    scene = rich_scene(make_scene)
    for x0, x1, y0, y1 in ((-0.01, 0.005, -0.01, 0.01), (0.0, 0.004, 0.0, 0.004)):
        x, y = (np.linspace(a, b, 161)[:-1] + (b - a) / 320 for a, b in ((x0, x1), (y0, y1)))
        by_area = fluence_1_m2(scene, x[None, :], y[:, None]).mean() * (x1 - x0) * (y1 - y0)
        assert expected_impacts(scene, x0, x1, y0, y1) == pytest.approx(by_area, rel=1e-3)


def test_a_jet_that_spreads_above_the_horizon_is_refused(make_scene):
    with pytest.raises(InputError, match="above the horizon.*20"):
        fluence_1_m2(make_scene(impact_angle_deg=20.0, divergence_half_angle_deg=20.0), 0.0, 0.0)


def chi_square(scene, shots, box, cells, **select):
    """P-value of the impacts of ``shots`` in ``cells`` x ``cells`` cells of ``box`` and in all the rest."""
    x, y = landings(shots)
    edges = np.linspace(box[0], box[1], cells + 1), np.linspace(box[2], box[3], cells + 1)
    counts = np.histogram2d(x, y, edges)[0].ravel()
    expected = np.array(
        [
            expected_impacts(scene, edges[0][i], edges[0][i + 1], edges[1][j], edges[1][j + 1], **select)
            for i in range(cells)
            for j in range(cells)
        ]
    )
    whole = expected_impacts(scene, *PLANE, **select)
    enough = expected > 10.0
    counts = np.append(counts[enough], len(shots) - counts[enough].sum())
    expected = np.append(expected[enough], whole - expected[enough].sum())
    assert len(counts) > 30 and expected[-1] >= -1e-3 * whole
    if expected[-1] < 10.0:
        counts, expected = counts[:-1], expected[:-1]
    # exact mass fixes the number in all passes: less scatter, by at most one degree of freedom
    fixed = scene.arrivals == "exact_mass"
    return chi2.sf(((counts - expected) ** 2 / expected).sum(), len(counts) - fixed)


@pytest.fixture(scope="module", params=["poisson", "exact_mass"])
def peened_strip(request):
    """S230 and S390, half of the mass each, at 45 degrees, 20 mm/s, three passes 8 mm apart."""
    from scenes import bare_scene

    scene = bare_scene(
        impact_angle_deg=45.0,
        feed=dataclasses.replace(TRAVERSE, dwell_s=0.0),
        exposure_time_s=6.0,
        seed=SEED,
        arrivals=request.param,
    )
    media = tuple(dataclasses.replace(shot(g, "distribution"), mass_fraction=0.5) for g in ("S230", "S390"))
    scene = dataclasses.replace(scene, media=media)
    return scene, arrivals.draw_arrivals(scene)


@pytest.mark.parametrize("pass_id", [0, 1, 2])
@pytest.mark.parametrize("medium", [0, 1])
def test_mixed_media_at_45_degrees_pass_by_pass(peened_strip, pass_id, medium):
    scene, shots = peened_strip
    shots = shots[(shots["pass_id"] == pass_id) & (shots["medium"] == medium)]
    box = (-0.040, 0.040, -0.035, 0.035)
    assert chi_square(scene, shots, box, 14, pass_id=pass_id, medium=medium) > 0.01


@pytest.mark.parametrize(
    ("jet", "box"),
    [
        ({"profile": "gaussian"}, (-0.01, 0.01, -0.01, 0.01)),
        ({"impact_angle_deg": 30.0, "divergence_half_angle_deg": 5.0}, (-0.03, 0.05, -0.02, 0.02)),
        (
            {
                "impact_angle_deg": 30.0,
                "divergence_half_angle_deg": 5.0,
                "profile": "gaussian",
                "speed_cv": 0.1,
            },
            (-0.03, 0.05, -0.02, 0.02),
        ),
    ],
)
def test_jets_at_rest(make_scene, jet, box):
    scene = make_scene(exposure_time_s=2.0, seed=SEED, **jet)
    assert chi_square(scene, arrivals.draw_arrivals(scene), box, 14) > 0.01


@pytest.mark.parametrize(
    ("nozzle", "box"), [(0, (-0.06, 0.05, -0.05, 0.06)), (1, (-0.025, 0.030, -0.025, 0.025))]
)
def test_two_nozzles_one_of_them_travelling_in_bursts(make_scene, nozzle, box):
    scene = rich_scene(make_scene)
    shots = arrivals.draw_arrivals(scene)
    shots = shots[shots["nozzle_id"] == nozzle]
    assert chi_square(scene, shots, box, 12, nozzle=nozzle) > 0.01


@pytest.mark.parametrize(
    "pattern", [{"pattern": "pulsed", "duty": 0.3}, {"pattern": "sinusoidal", "amplitude": 1.0}]
)
def test_pulses_under_a_travelling_nozzle_leave_stripes(make_scene, pattern):
    feed = model.Feed(speed_m_s=0.05, stroke_m=0.1)
    pulse = model.Pulse(frequency_Hz=2.0, **pattern)
    scene = make_scene(feed=feed, pulse=pulse, exposure_time_s=2.0, seed=SEED, jet_diameter_m=0.008)
    shots = arrivals.draw_arrivals(scene)
    assert chi_square(scene, shots, (-0.06, 0.06, -0.004, 0.004), 24) > 0.01
    steady = dataclasses.replace(scene, nozzles=(dataclasses.replace(scene.nozzle, pulse=None),))
    assert chi_square(steady, shots, (-0.06, 0.06, -0.004, 0.004), 24) < 1e-6  # and the stripes are seen
