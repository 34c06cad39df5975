"""Collision number against values measured in YADE (1 mm, 60 m/s, 20 mm jet, 100 mm stand-off, e .6)."""

import pytest

from glue.errors import InputError
from glue.flow.regime import collision_number


@pytest.mark.parametrize(
    "kg_min, pi, collisions, within",
    [
        (0.02, 0.0036, 0.0036, 0.03),
        (0.1, 0.018, 0.017, 0.05),
        (1.0, 0.18, 0.143, 0.09),
        (5.0, 0.907, 0.419, 0.09),
        (10.0, 1.8, 0.576, 0.09),
    ],
)
def test_normal_incidence(make_scene, kg_min, pi, collisions, within):
    got = collision_number(make_scene(mass_flow_kg_s=kg_min / 60), 0.6)
    assert got["pi"] == pytest.approx(pi, rel=0.015)  # two printed digits
    assert got["pi_eff"] == got["pi"]
    assert got["collisions_per_shot"] == pytest.approx(collisions, rel=within)


def test_oblique_is_less(make_scene):
    got = collision_number(make_scene(impact_angle_deg=45.0), 0.6)
    # .23 * 20 / (100 * cos 45)
    assert got["pi_eff"] / got["pi"] == pytest.approx(0.0650538, rel=1e-5)
    steep = collision_number(make_scene(impact_angle_deg=89.0), 0.6)
    assert steep["pi_eff"] == steep["pi"]


def test_restitution_out_of_range(make_scene):
    for e in (0.0, -0.1, 1.1, float("nan")):
        with pytest.raises(InputError, match="must lie in"):
            collision_number(make_scene(), e)
