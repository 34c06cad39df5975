"""Overlap of clouds against closed forms: crossing cylinders, parted circles, profiles, pulses, mixtures."""

import dataclasses
import math

import numpy as np
import pytest

from glue.flow import overlap
from glue.flow.overlap import autocorrelation, cross_section_m2, incoming, meetings_1_s, outgoing
from glue.scene.model import Pulse

R, H, V, RATE, SECTION = 0.010, 0.10, 60.0, 2e4, math.pi * 1e-6
PER_VOLUME = RATE / (math.pi * R**2 * V)  # of the bare scene's jet at that rate


def early_height_m(rising_m_s, relative_m_s):
    """Height that rebounds have when shots 1 mm wide touch 2/3 of that before their centres pass each other."""
    return 2e-3 / 3.0 * rising_m_s / relative_m_s


def test_jets_crossing_at_right_angles_share_half_a_steinmetz_solid(make_scene):
    a = make_scene(impact_angle_deg=45.0).nozzle
    b = dataclasses.replace(a, azimuth_deg=180.0)
    volume = 16.0 / 3.0 * R**3 / 2.0  # the half above the target
    got = meetings_1_s(incoming(a, RATE), incoming(b, RATE), SECTION)
    assert got == pytest.approx(SECTION * math.sqrt(2.0) * V * PER_VOLUME**2 * volume, rel=0.01)
    aside = dataclasses.replace(b, aim_m=(0.0, 0.021))
    assert meetings_1_s(incoming(a, RATE), incoming(aside, RATE), SECTION) == 0.0


@pytest.mark.parametrize("angle", [30.0, 45.0, 75.0])
@pytest.mark.parametrize("azimuth", [0.0, 130.0])
def test_oblique_jet_and_its_rebounds_part_like_two_circles(make_scene, angle, azimuth):
    """Common area of equal circles t apart, summed over t = z s (cot a_in + cot a_out), by another quadrature."""
    e, kept = 0.5, 0.7
    nozzle = make_scene(impact_angle_deg=angle, azimuth_deg=azimuth).nozzle
    s, c = math.sin(math.radians(angle)), math.cos(math.radians(angle))
    relative = V * math.hypot((1.0 - kept) * c, (1.0 + e) * s)
    slide = c + kept * c / e  # d t / dz
    low = early_height_m(e * V * s, relative) * slide
    t = low + (2.0 * R - low) * (np.arange(20_000) + 0.5) / 20_000
    common = 2.0 * R**2 * np.arccos(t / (2.0 * R)) - 0.5 * t * np.sqrt(4.0 * R**2 - t**2)
    volume = common.mean() * (2.0 * R - low) / slide / s
    assert 2.0 * R / slide < H * s  # parted below the nozzle
    out = outgoing(nozzle, RATE, e, kept)
    assert out.velocity_m_s[2] == pytest.approx(e * V * s)
    got = meetings_1_s(incoming(nozzle, RATE), out, SECTION)
    assert got == pytest.approx(SECTION * relative * PER_VOLUME**2 / e * volume, rel=0.01)


def test_a_diverging_jet_and_its_rebounds_above_it(make_scene):
    """Two coaxial discs at every height: the incoming one is the smaller, so all its shots are in the other."""
    e, kept, half = 0.5, 0.75, math.radians(5.0)
    nozzle = make_scene(divergence_half_angle_deg=5.0).nozzle
    at_target = R + H * math.tan(half)
    low = early_height_m(e, 1.0 + e)
    z = low + (H - low) * (np.arange(2000) + 0.5) / 2000
    radius = at_target + kept / e * math.tan(half) * z
    per_shot = SECTION * (1.0 + e) * (RATE / (math.pi * radius**2 * e * V)).mean() * (H - low)
    got = meetings_1_s(incoming(nozzle, RATE), outgoing(nozzle, RATE, e, kept), SECTION)
    assert got / RATE == pytest.approx(per_shot, rel=1e-3)


def test_a_gaussian_jet_is_denser_where_its_rebounds_are(make_scene):
    even, peaked = (make_scene(profile=p).nozzle for p in ("uniform", "gaussian"))
    ratio = np.divide(
        *(meetings_1_s(incoming(n, RATE), outgoing(n, RATE, 0.5, 0.7), SECTION) for n in (peaked, even))
    )
    # pi integral of the squared profile exp(-2 u^2) / (pi/2 (1 - e^-2)) over the unit disc
    assert ratio == pytest.approx((1.0 - math.exp(-4.0)) / (1.0 - math.exp(-2.0)) ** 2, rel=1e-3)


def test_faster_shots_overtake_within_one_jet(make_scene):
    jet = incoming(make_scene().nozzle, RATE)
    volume = math.pi * R**2 * H
    assert meetings_1_s(jet, jet, SECTION, 3.0) == pytest.approx(
        SECTION * 3.0 * PER_VOLUME**2 * volume, rel=1e-3
    )
    assert meetings_1_s(jet, jet, SECTION) == 0.0  # all at one velocity


def test_pulses_meet_what_left_before(make_scene):
    """Bursts longer than a shot's way there and back meet themselves: as often as their flow is above the mean."""

    def ratio(frequency_Hz, duty):
        still = make_scene().nozzle
        pulsed = dataclasses.replace(still, pulse=Pulse("pulsed", frequency_Hz, duty=duty))
        return np.divide(
            *(meetings_1_s(incoming(n, RATE), outgoing(n, RATE, 0.5, 0.7), SECTION) for n in (pulsed, still))
        )

    assert ratio(1.0, 0.25) == pytest.approx(4.0, rel=0.02)  # 5 ms there and back in bursts of 250 ms
    assert ratio(20_000.0, 0.25) == pytest.approx(1.0, rel=0.05)


@pytest.mark.parametrize(
    "pulse",
    [Pulse("pulsed", 7.0, duty=0.3), Pulse("pulsed", 7.0, duty=0.8), Pulse("sinusoidal", 7.0, amplitude=0.6)],
)
def test_autocorrelation_is_that_of_the_flow(pulse):
    t = np.arange(200_000) / 200_000 / 7.0

    def flow(t):
        if pulse.pattern == "pulsed":
            return ((t * 7.0) % 1.0 < pulse.duty) / pulse.duty
        return 1.0 + pulse.amplitude * np.sin(2.0 * math.pi * 7.0 * t)

    for lag in (0.0, 0.011, 0.05, 0.13, -0.3):
        assert autocorrelation(pulse, lag) == pytest.approx((flow(t) * flow(t + lag)).mean(), abs=1e-4)


def test_cross_section_of_a_mixture(make_scene):
    assert cross_section_m2(make_scene()) == pytest.approx(SECTION)
    (small,) = make_scene(diameter_m=0.5e-3).media
    big = make_scene().shots
    mixed = dataclasses.replace(
        make_scene(),
        media=tuple(dataclasses.replace(m, mass_fraction=0.5) for m in (small, big)),
    )
    # by number 8 of 9 are small: pi/4 of the mean of 1^2, 1.5^2, 2^2 x .5 mm squared, weights 64, 16, 1 over 81
    assert cross_section_m2(mixed) == pytest.approx(math.pi / 4.0 * 0.25e-6 * (64 * 4 + 16 * 9 + 16) / 81)


def test_a_shot_keeps_less_of_its_tangential_speed_the_steeper_it_strikes(make_scene):
    kept = [
        overlap.kept_tangential_speed(make_scene(impact_angle_deg=a).nozzle, 0.6, 0.2)
        for a in (20.0, 45.0, 70.0)
    ]
    assert kept[0] == pytest.approx(1.0 - 0.2 * 1.6 * math.tan(math.radians(20.0)))  # sliding: Coulomb
    assert kept[0] > kept[1] > kept[2] > 0.4
    assert overlap.kept_tangential_speed(make_scene(impact_angle_deg=20.0).nozzle, 0.6, 0.0) == 1.0
