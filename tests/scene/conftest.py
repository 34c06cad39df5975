"""A complete scene, key by key, to change one thing at a time."""

from __future__ import annotations

import pytest

from glue.errors import InputError
from glue.scene.reader import read_scene

BASE = {
    "schema": "1",
    "name": '"trial"',
    "seed": "1",
    "exposure_time_s": "3.0",
    "shots.grade": '"S390"',
    "nozzle.speed_m_s": "60.0",
    "nozzle.mass_flow_kg_s": "0.01667",
    "nozzle.jet_diameter_m": "0.020",
    "nozzle.stand_off_m": "0.10",
    "nozzle.impact_angle_deg": "90.0",
    "target.material": '"al2024-t351"',
    "target.window_m": "[0.004, 0.004]",
}


@pytest.fixture
def write_scene(tmp_path):
    """Writes the complete scene with ``changes`` (key path -> TOML text, or None); returns the file."""

    def write(changes=None):
        keys = dict(BASE)
        for key, value in (changes or {}).items():
            for old in [k for k in keys if k == key or k.startswith(key + ".")]:
                del keys[old]
            if value is not None:
                keys[key] = value
        path = tmp_path / "trial.toml"
        path.write_text("".join(f"{key} = {value}\n" for key, value in keys.items()), encoding="utf-8")
        return path

    return write


@pytest.fixture
def problems_of(write_scene):
    """The problems that reading the changed scene raises, without the leading file name."""

    def problems(changes, **arguments):
        path = write_scene(changes)
        with pytest.raises(InputError) as caught:
            read_scene(path, **arguments)
        return [problem.removeprefix(f"{path}: ") for problem in caught.value.problems]

    return problems
