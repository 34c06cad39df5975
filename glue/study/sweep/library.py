"""The impacts that the runs of a study share: grouped by all that decides them but the speed, each solved once.

Runs whose scenes have ``accuracy.dimple_speed_ratio`` take their dimples between impacts at powers of it
(``glue.target.between``); so a material needs one library for all speeds, angles, diameters and densities of a study.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from contextvars import copy_context

from glue import stopping
from glue.errors import PeenError
from glue.scene.model import Scene
from glue.study.dimple_stage import impact_density, impact_speeds, layer_speeds, ready_kernels, scene_physics
from glue.study.rundir import digest
from glue.target.between import DENSITY_KG_M3
from glue.target.reduced_impact import Numerics, solve_reduced
from glue.target.speeds import cores, solve_speeds

_POLL_S = 0.3


def libraries(scenes: Iterable[tuple[str, Scene]], target: bool) -> list[dict]:
    """[{"run": the first that uses it, "runs": all names, "speeds_m_s", "layer_speeds_m_s": rising}] of (run's name, scene).

    ``target``: the stage of that name is to run too; the second list is of the layer model's impacts.
    """
    found: dict[str, dict] = {}
    for name, scene in scenes:
        library = found.setdefault(_key(scene), {"run": name, "runs": [], "speeds_m_s": set(), "layer_speeds_m_s": set()})
        library["runs"].append(name)
        library["speeds_m_s"].update(impact_speeds(scene))
        if target and scene.models.target.model == "layers":
            library["layer_speeds_m_s"].update(layer_speeds(scene))
    return [library | {key: sorted(library[key]) for key in ("speeds_m_s", "layer_speeds_m_s")} for library in found.values()]


def count(found: Iterable[dict]) -> int:
    """Number of impacts in ``libraries``."""
    return sum(len(library["speeds_m_s"]) + len(library["layer_speeds_m_s"]) for library in found)


def solve_libraries(
    wanted: Sequence[tuple[Scene, dict]],
    jobs: int | None = None,
    progress: Callable[[float, str], None] = lambda share, text: None,
) -> int:
    """Solve the impacts of (a scene of the library, library) into the cache, ``jobs`` at a time; how many failed.

    One that fails is no failure here: the runs that need it will say so.  Ctrl-C stops all.
    """
    ready_kernels()
    each: list[tuple] = []
    for scene, library in wanted:
        each += [(_solve, scene, scene_physics(scene)[0], speed) for speed in reversed(library["speeds_m_s"])]
        each += [(_solve_layer, scene, speed) for speed in reversed(library["layer_speeds_m_s"])]
    failed = 0
    with ThreadPoolExecutor(jobs or cores()) as pool:  # threads: the work is FreeFem++'s
        waiting = {pool.submit(copy_context().run, *impact) for impact in each}
        try:
            while waiting:
                stopping.check()
                ended, waiting = wait(waiting, timeout=_POLL_S, return_when=FIRST_COMPLETED)
                failed += sum(isinstance(done.exception(), PeenError) for done in ended)
                for done in ended:
                    if not isinstance(done.exception(), PeenError):
                        done.result()
                number = len(each) - len(waiting)
                progress(number / len(each), f"{number} of {len(each)} shared impacts")
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    return failed


def _tell(share: float, text: str = "") -> None:
    stopping.check()


def _solve(scene: Scene, physics, speed: float) -> None:
    solve_speeds(
        scene.target.material, [speed], density_kg_m3=impact_density(scene),
        elements_per_radius=scene.accuracy.dimple_elements_per_radius, physics=physics,
        numerics=Numerics(steps_per_contact=scene.accuracy.dimple_steps_per_contact), jobs=1, progress=_tell,
    )  # fmt: skip


def _solve_layer(scene: Scene, speed: float) -> None:
    material, shared = scene.target.material, scene.accuracy.dimple_speed_ratio
    solve_reduced(
        material, material.combined, speed_m_s=speed, density_kg_m3=DENSITY_KG_M3 if shared else impact_density(scene),
        elements_per_radius=scene.accuracy.dimple_elements_per_radius, progress=_tell,
    )  # fmt: skip


def _key(scene: Scene) -> str:
    """Hash of all that decides the scene's impacts but their speed."""
    accuracy = scene.accuracy
    return digest(
        [
            dataclasses.asdict(scene.target.material), impact_density(scene), dataclasses.asdict(scene_physics(scene)[0]),
            accuracy.dimple_speed_ratio, accuracy.dimple_elements_per_radius, accuracy.dimple_steps_per_contact,
        ]
    )  # fmt: skip
