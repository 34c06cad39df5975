"""One run of the shot stream, put together from its parts, stepped to its end and checked."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np

import checkpoint
from bodies import Bodies
from contact_model import build_media
from dashpots import Dashpots
from flight import Fleet, FlowFailed
from flow_checks import audit, postflight
from glue.errors import InputError
from glue.flow.impacts import COLUMNS, TITLE
from glue.flow.surface import PLANE, TargetSurface
from glue.flow.table import TableWriter
from impact_logger import ImpactLogger
from kicks import Kicks
from leaps import Leaps
from plain_steps import PlainSteps
from run_plan import Plan
from shot_stream import Stream
from target_curved import CurvedTarget
from target_plane import PlaneTarget

DROPS_PER_FLIGHT = 20  # how often per flight of the shortest stand-off the shots are looked through
AUDIT_LOOKS = 20  # every so many of these looks all free shots are audited
# Give up on slow stragglers after this many flights of the longest stand-off; plain stepping pays for each.
TAIL_FLIGHTS, PLAIN_TAIL_FLIGHTS = 300.0, 20.0
PLAIN_STRIDE = 0.6  # plain stepping asks for contacts this often, in shortest contacts
# How far a shot may move before the collider looks again, in shot diameters: measured, plain 5 kg/min costs
# 1.28, 1.40, 1 and 1.17 times as much with .25, .5, 1 and 2.
SWEEP_DIAMETERS = 1.0


class FlowRun:
    """``scene`` with its physics decided, ``arrivals`` of it, what ``plan_run`` said; the log goes to ``out``.

    ``identity`` goes into the log's header and into checkpoints (``out/flow.checkpoint.npz``, every
    ``checkpoint_s`` wall seconds; None: none).  ``go_on``: continue from the checkpoint, if there is one.
    """

    def __init__(
        self,
        scene,
        plan: Plan,
        arrivals: np.ndarray,
        surface: TargetSurface,
        out: Path,
        identity: dict,
        *,
        plain: bool = False,
        jet_margin: float | None = None,
        checkpoint_s: float | None = 2.0,
        go_on: bool = False,
    ):
        flat = surface.kind == PLANE
        if plain and not flat:
            raise InputError(
                "plain stepping knows only the flat target: it does not foresee where to lay facets"
            )
        self.plan, self.out, self.identity, self.every = plan, out, identity, checkpoint_s
        self.file = None if plain or checkpoint_s is None else out / "flow.checkpoint.npz"
        self.begun, self._begun_cpu = time.monotonic(), time.process_time()
        made_of = build_media(
            plan.media,
            plan.target,
            *plan.laws,
            dt_s=plan.dt_s,
            sweep_m=SWEEP_DIAMETERS * scene.smallest_diameter_m,
            plane=flat,
        )
        largest = 0.5 * scene.largest_diameter_m
        target = PlaneTarget() if flat else CurvedTarget(surface, made_of.target, largest)
        bodies, fleet = Bodies(made_of.media, target), Fleet()
        self.dashpots = None
        if plan.maps:
            self.dashpots = Dashpots(
                *(plan.restitution, scene.restitution.shot_shot, plan.maps, plan.media, plan.target, bodies),
                plan.dt_s,
            )
        self.logger = ImpactLogger(
            self._emit,
            bodies,
            target,
            dt_s=plan.dt_s,
            speed_limit_m_s=plan.speed_limit_m_s,
            tune=self.dashpots,
            forces=scene.accuracy.flow_stiffness_scale == 1.0,  # those of softened contacts mean nothing
        )
        if plain:
            # dashpots are set after a contact's first step: then every step must be looked at
            stride = 1 if self.dashpots else max(1, int(PLAIN_STRIDE * plan.shortest_contact_steps))
            self.mover = PlainSteps(fleet, bodies, self.logger, stride)
        else:
            self.mover = Leaps(fleet, bodies, self.logger)
        margin = {} if jet_margin is None else {"jet_margin": jet_margin}
        self.stream = Stream(scene, arrivals, self.mover, plan.dt_s, **margin)
        self.kicks = Kicks(scene, self.mover, plan.dt_s)
        self.mover.kicks = self.kicks if self.kicks.stride else None
        flights = [nozzle.stand_off_m / nozzle.speed_m_s for nozzle in scene.nozzles]
        self.look_stride = max(1, round(min(flights) / DROPS_PER_FLIGHT / plan.dt_s))
        self.tail_s = (PLAIN_TAIL_FLIGHTS if plain else TAIL_FLIGHTS) * max(flights)
        self.end_s = float(arrivals["time_s"][-1]) + max(flights)
        self.wall_before_s = 0.0
        saved = checkpoint.load(self.file, identity) if go_on and self.file else None
        self.writer = TableWriter(
            *(out / "impacts.csv", TITLE, COLUMNS, {"model": "dem", **identity}),
            resume=tuple(saved["log"]) if saved else None,
        )
        if saved:
            self.wall_before_s = saved["wall_s"]
            spots = self.dashpots.spots if self.dashpots else None
            checkpoint.restore(saved, self.stream, self.kicks, spots, self.writer.part)

    def _emit(self, rows) -> None:
        first = self.writer.rows_written
        self.writer.write((first + i, *row) for i, row in enumerate(rows))

    def run(self, report: dict) -> None:
        """To the end; ``report`` gets the numbers and checks. Raises FlowFailed; the log stays as .part then."""
        try:
            self._simulate()
            checks = postflight(self.plan, self.stream)
            report["checks"] = [row._asdict() for row in checks]
            failed = [row for row in checks if not row.passed]
            if failed:
                raise FlowFailed("; ".join(f"{r.name}: {r.value:.6g}, limit {r.limit:.6g}" for r in failed))
            self.writer.finish()
        except BaseException:
            self.writer.abandon()
            raise
        finally:
            report.update(self.summary())
        if self.file:
            self.file.unlink(missing_ok=True)

    def wall_s(self) -> float:
        """Wall time of this run, with that before a checkpoint that it goes on from."""
        return self.wall_before_s + time.monotonic() - self.begun

    def _simulate(self) -> None:
        """Feed and step until every shot has struck or gone, at most ``tail_s`` after the last arrival."""
        logger, mover, stream, kicks = self.logger, self.mover, self.stream, self.kicks
        said = saved = time.monotonic()
        while True:
            if logger.step % self.look_stride == 0:
                stream.drop()
                if logger.step % (AUDIT_LOOKS * self.look_stride) == 0:
                    audit(mover)
                now = time.monotonic()
                if now - said > 1.0:
                    self._say()
                    said = now
                if self.file and now - saved > self.every and checkpoint.quiet(mover):
                    checkpoint.save(self.file, self.identity, stream, kicks, self.writer, self.wall_s())
                    saved = now
            if kicks.stride and logger.step % kicks.stride == 0:
                kicks.all()
            stream.feed()
            wait = stream.steps_to_next()
            if wait is None and (not stream.falling() or logger.clock() > self.end_s + self.tail_s):
                break
            look = self.look_stride - logger.step % self.look_stride
            wait = look if wait is None else min(wait, look)
            mover.advance(int(min(wait, kicks.next_step(logger.step) - logger.step)))
        stream.drop()
        audit(mover)
        logger.flush()

    def _say(self) -> None:
        self.writer.flush()
        done = min(max(self.logger.clock() / self.end_s, 1e-6), 0.999)
        print(f"progress {done:.3f} eta_s {self.wall_s() * (1.0 / done - 1.0):.0f}", flush=True)

    def summary(self) -> dict:
        """The numbers of flow.json that come from the run; SI."""
        plan, logger, stream = self.plan, self.logger, self.stream
        live = stream.fleet.shots
        own = {"grazes_between_questions": self.mover.grazes} if isinstance(self.mover, PlainSteps) else {}
        return {
            "stepping": self.mover.name,
            **own,
            "dt_s": plan.dt_s,
            "dt_over_P": plan.dt_over_P,
            "calibration": {"shot_target": plan.shot_target._asdict(), "shot_shot": plan.shot_shot._asdict()},
            "restitution_by": "contact" if plan.maps else "pair",
            "steps": logger.step - stream.first_step,
            "executed_steps": logger.executed,
            "kick_interval_s": self.kicks.stride and self.kicks.stride * plan.dt_s,
            "simulated_s": logger.clock(),
            "peak_live_shots": stream.peak_live,
            "arrived": stream.next,
            "mass_fed_kg": stream.mass_in_kg,
            "impacts": self.writer.rows_written,
            "dropped": stream.dropped,
            "in_flight": len(live),
            "shots_that_never_struck": stream.never_struck + sum(s.impacts == 0 for s in live),
            "shot_shot_collisions": logger.collisions,
            "top_speed_m_s": logger.top_speed,
            "stepping_wall_s": self.wall_s(),
            "stepping_cpu_s": time.process_time() - self._begun_cpu,  # since the last start
        }
