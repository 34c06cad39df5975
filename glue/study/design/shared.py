"""The impacts between which all dimples of a design's window lie, solved on all cores before the search begins."""

from __future__ import annotations

from glue.scene.model import Scene
from glue.study.design.problem import Problem
from glue.study.sweep.library import count, libraries, solve_libraries
from glue.target.between import grid


def solve_window(problem: Problem, jobs: int, progress) -> str:
    """Solve them into the cache; what was done, in words.  One that fails is told by the settings that need it."""
    corners = problem.corners()
    if not corners or any(scene.specification is not None for scene in corners):
        return "speeds are known setting by setting, and so are their impacts"
    found = libraries([(str(k), scene) for k, scene in enumerate(corners)], "target" in problem.goals.stages)
    wanted = [(corners[int(library["run"])], _filled(library, corners)) for library in found]
    failed = solve_libraries(wanted, jobs, progress)
    speeds = [speed for _, library in wanted for speed in library["speeds_m_s"]]
    told = f"dimples between impacts at {len(set(speeds))} speeds, {min(speeds):.3g} to {max(speeds):.4g} m/s"
    more = count(library for _, library in wanted) - len(set(speeds))
    return told + (f", and {more} other impacts" if more else "") + (f"; {failed} failed" if failed else "")


def _filled(library: dict, corners: list[Scene]) -> dict:
    """``library`` with the speeds between those of the corners."""
    return library | {
        key: grid(library[key][0], library[key][-1])
        for key in ("speeds_m_s", "layer_speeds_m_s")
        if library[key] and corners[0].accuracy.dimple_speed_ratio
    }
