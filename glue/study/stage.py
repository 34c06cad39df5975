"""What a stage of the pipeline is, and what it is given."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from glue.scene.model import Scene


@dataclass(frozen=True)
class Work:
    """What a stage gets: the scene, the run directory and a way to tell how far it is."""

    scene: Scene
    path: Path
    scene_file: Path
    progress: Callable[[float | None, str], None]
    complete: frozenset[str] = frozenset()  # stages whose files may be read
    go_on: bool = False  # a stopped attempt with the same inputs left its files: go on from there


@dataclass(frozen=True)
class Stage:
    """A step of the way from nozzle to report.

    ``needs``: stages whose files it reads. ``uses``: stages whose files it reads when they are there.
    ``code``: glob patterns, relative to the checkout, of the sources that decide its result.
    ``owns``: files and folders of the run directory that it alone writes. ``run(work)`` does it and
    returns (metrics by section of metrics.json, names of the files written). ``solvers``: those of
    yade and freefem that it runs, or a function (scene, run directory) -> those, where the scene and what
    earlier stages found decide; their versions are part of what its result depends on.
    ``refuse(scene, scene_file)`` raises InputError, before any stage runs, for a scene that the stage would
    refuse. ``resumes``: it can go on from what a stopped attempt left.
    """

    name: str
    needs: tuple[str, ...]
    code: tuple[str, ...]
    owns: tuple[str, ...]
    run: Callable[[Work], tuple[dict, list[str]]]
    uses: tuple[str, ...] = ()
    solvers: tuple[str, ...] | Callable[[Scene, Path], tuple[str, ...]] = ()
    refuse: Callable[[Scene, Path], None] = lambda scene, scene_file: None
    resumes: bool = False

    def runs(self, scene: Scene, path: Path) -> tuple[str, ...]:
        """The solvers that it runs for ``scene`` in the run directory ``path``."""
        return self.solvers(scene, path) if callable(self.solvers) else self.solvers
