"""Tells cheaply which runs of a study are finished: by what their manifests record, without hashing their files again.

``pipeline.is_done`` hashes every file that a stage wrote and every source that it depends on, for each run: half a minute for
hundreds of runs.  Here the sources are hashed once, and files have only to be there.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from glue.errors import InputError
from glue.scene.reader import read_scene
from glue.study.manifest import read_manifest
from glue.study.pipeline import code_digests, stage_inputs, with_needs
from glue.study.rundir import RunDirectory, digest
from glue.study.stage import Stage
from glue.study.sweep.plan import Run


class Finished:
    """Asked for each run: are all wanted stages complete, from these inputs, by these sources and solvers?"""

    def __init__(self, only: Sequence[str], stages: Sequence[Stage]):
        self.stages = with_needs(only, stages)
        self._code = {stage.name: code_digests(stage) for stage in self.stages}

    def __call__(self, path: Path, run: Run) -> bool:
        if run.scene is None or not path.is_dir():
            return False
        try:
            folder = RunDirectory(path, read_manifest(path), -1)  # read only: no lock
            if run.inputs_sha256 is None:  # what the scene specifies was found by the run, and lies in its folder
                if folder.manifest["scene_sha256"] != run.scene_sha256:
                    return False
                scene = read_scene(folder.scene_file)
            else:
                if folder.manifest["inputs_sha256"] != run.inputs_sha256:
                    return False
                scene = run.scene
            return all(self._complete(folder, scene, stage) for stage in self.stages)
        except (InputError, OSError, KeyError):
            return False

    def _complete(self, folder: RunDirectory, scene, stage: Stage) -> bool:
        record = folder.manifest["stages"].get(stage.name)
        if record is None or record["state"] != "complete":
            return False
        if record["input_sha256"] != digest(stage_inputs(folder, scene, stage, self._code[stage.name])):
            return False
        return all((folder.path / name).is_file() for name in record["outputs"])
