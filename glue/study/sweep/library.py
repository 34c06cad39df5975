"""The dimples that the runs of a study share: grouped by all that decides them but the speed, each solved once.

Runs whose scenes have ``accuracy.dimple_speed_ratio`` take speeds that are powers of RATIO; so a material and a
shot need one library for all speeds and angles of the study, of about log(fastest / slowest) / log(RATIO) impacts.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from contextvars import copy_context

from glue import stopping
from glue.errors import PeenError
from glue.scene.model import Scene
from glue.study.dimple_stage import dimple_speed, other_speeds, ready_kernels, scene_physics
from glue.study.reference import reference_impact
from glue.study.rundir import digest
from glue.target.reduced_impact import Numerics
from glue.target.speeds import cores, solve_speeds

RATIO = 1.05  # the dimple is then that of a shot up to 5 % faster, its radius 2.4 % larger; what uses it scales it back
_POLL_S = 0.3


def libraries(scenes: Sequence[tuple[str, Scene]]) -> list[dict]:
    """[{"run": the first that uses it, "runs": all names, "speeds_m_s": rising}] of (run's name, scene)."""
    found: dict[str, dict] = {}
    for name, scene in scenes:
        library = found.setdefault(_key(scene), {"run": name, "runs": [], "speeds_m_s": set()})
        library["runs"].append(name)
        library["speeds_m_s"] |= {dimple_speed(scene), *other_speeds(scene)}
    return [library | {"speeds_m_s": sorted(library["speeds_m_s"])} for library in found.values()]


def solve_libraries(
    wanted: Sequence[tuple[Scene, Sequence[float]]],
    jobs: int | None = None,
    progress: Callable[[float, str], None] = lambda share, text: None,
) -> int:
    """Solve the impacts of (a scene of the library, speeds [m/s]) into the cache, ``jobs`` at a time; how many failed.

    One that fails is no failure here: the runs that need it will say so.  Ctrl-C stops all.
    """
    ready_kernels()
    each = [(scene, scene_physics(scene)[0], speed) for scene, speeds in wanted for speed in reversed(speeds)]
    failed = 0
    with ThreadPoolExecutor(jobs or cores()) as pool:  # threads: the work is FreeFem++'s
        waiting = {pool.submit(copy_context().run, _solve, *impact) for impact in each}
        try:
            while waiting:
                stopping.check()
                ended, waiting = wait(waiting, timeout=_POLL_S, return_when=FIRST_COMPLETED)
                failed += sum(isinstance(done.exception(), PeenError) for done in ended)
                for done in ended:
                    if not isinstance(done.exception(), PeenError):
                        done.result()
                number = len(each) - len(waiting)
                progress(number / len(each), f"{number} of {len(each)} shared dimples")
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    return failed


def _solve(scene: Scene, physics, speed: float) -> None:
    def tell(share: float, text: str = "") -> None:
        stopping.check()

    solve_speeds(
        scene.target.material, [speed], density_kg_m3=reference_impact(scene)[1].density_kg_m3,
        elements_per_radius=scene.accuracy.dimple_elements_per_radius, physics=physics,
        numerics=Numerics(steps_per_contact=scene.accuracy.dimple_steps_per_contact), jobs=1, progress=tell,
    )  # fmt: skip


def _key(scene: Scene) -> str:
    """Hash of all that decides the scene's dimples but their speed."""
    accuracy = scene.accuracy
    return digest(
        [
            dataclasses.asdict(scene.target.material), reference_impact(scene)[1].density_kg_m3,
            dataclasses.asdict(scene_physics(scene)[0]), accuracy.dimple_elements_per_radius, accuracy.dimple_steps_per_contact,
        ]
    )  # fmt: skip
