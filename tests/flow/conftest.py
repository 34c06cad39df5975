import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))

from scenes import bare_scene  # noqa: E402


@pytest.fixture
def make_scene():
    """``bare_scene`` of scenes.py: a flow scene with any field changed."""
    return bare_scene
