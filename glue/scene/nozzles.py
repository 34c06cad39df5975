"""The nozzles of a scene: jet, feed and pulses, and the exposure that a feed takes."""

from __future__ import annotations

from glue.scene import schema
from glue.scene.fields import show
from glue.scene.model import Feed, Nozzle, Pulse
from glue.scene.specification import PROVISIONAL_SPEED_m_s, speed_key
from glue.scene.table import Table

_KEYS = (*schema.NOZZLE, *schema.SPECIFIED, *schema.SETTINGS, *schema.JET, *schema.FEED, *schema.PULSE)
_REST = "feed_speed_m_s"
_SPEED_FIELDS = {"speed_m_s": schema.NOZZLE["speed_m_s"], **schema.SPECIFIED, **schema.SETTINGS}


def read_nozzles(
    top: Table, exposure_time_s: float | None, speeds_m_s: list[float] | None = None, passes: int | None = None
) -> tuple[Nozzle, ...] | None:
    """``[nozzle]``, or several ``[[nozzle]]``; None when any of them is refused.

    ``speeds_m_s``: what was found for those that say no speed themselves (by nozzle), in place of a provisional one;
    ``passes``: number found for those that travel, None where the file says it.

    ``exposure_time_s`` is the file's, None when it is refused or left out for the feed to say (:func:`feed_says`).
    """
    tables = top.several("nozzle", ", ".join(schema.NOZZLE), schema.MAX_NOZZLES)
    if tables is None:
        return None
    if exposure_time_s is None and "exposure_time_s" not in top and feed_says(top):
        for table in tables:  # one path gives the exposure; no other can follow from it
            if "stroke_m" not in table and table.data.get(_REST, 0) != 0:
                sentence = "missing, and required without exposure_time_s"
                table.problem("stroke_m", f"{sentence}; {schema.FEED['stroke_m'].allowed}")
    found = speeds_m_s if speeds_m_s and len(speeds_m_s) == len(tables) else [PROVISIONAL_SPEED_m_s] * len(tables)
    nozzles = [_read_nozzle(table, exposure_time_s, v, passes) for table, v in zip(tables, found)]
    return None if None in nozzles else tuple(nozzles)


def feed_says(top: Table) -> bool:
    """Whether the length of the exposure follows from a nozzle's path: one moves and has a ``stroke_m``."""
    nozzles = top.data.get("nozzle")
    nozzles = nozzles if isinstance(nozzles, list) else [nozzles]
    return any(isinstance(nozzle, dict) and "stroke_m" in nozzle and nozzle.get(_REST, 0) != 0 for nozzle in nozzles)


def read_exposure(top: Table, written_s: float | None, nozzles: tuple[Nozzle, ...] | None) -> float | None:
    """The exposure [s]: as ``written_s``, or as long as the feed takes; both must agree, as must all nozzles.

    Writes its problems to the log and answers None then.
    """
    if nozzles is None:
        return written_s
    field = schema.TOP["exposure_time_s"]
    timed = [(_name(nozzles, n), nozzle.feed.duration_s) for n, nozzle in enumerate(nozzles) if nozzle.feed]
    if written_s is None and timed and "exposure_time_s" not in top:
        written_s = timed[0][1]
        if problem := field.problem(written_s):
            top.problem("exposure_time_s", f"as long as the feed of {timed[0][0]} takes: {problem}")
            return None
        how = f"derived: passes x stroke over feed speed and the dwells between, of {timed[0][0]}"
        top.log.default("exposure_time_s", written_s, how)
    for name, duration_s in timed:
        if written_s is not None and abs(duration_s - written_s) > 1e-6 * written_s:
            said = "exposure_time_s says" if "exposure_time_s" in top else f"{timed[0][0]} takes"
            top.problem(
                f"{name}.stroke_m",
                f"its passes and dwells take {duration_s:.9g} s, but {said} {written_s:.9g} s; allowed: the same within "
                "1e-6, or one of the two left out",
            )
            return None
    return written_s


def _name(nozzles, n: int) -> str:
    return "nozzle" if len(nozzles) == 1 else f"nozzle[{n + 1}]"


def _read_nozzle(table: Table, exposure_time_s: float | None, found_m_s: float, passes: int | None) -> Nozzle | None:
    table.refuse_others(_KEYS, elsewhere=schema.BELONGS_IN)
    key = speed_key(table)
    values = {"speed_m_s": None if key is None else table.get(key, _SPEED_FIELDS[key])}
    if key not in (None, "speed_m_s") and values["speed_m_s"] is not None:
        values["speed_m_s"] = found_m_s
        if problem := schema.NOZZLE["speed_m_s"].problem(found_m_s):
            table.problem(key, f"leads to a speed of {show(found_m_s)} m/s: {problem}")
    values |= table.get_all({k: v for k, v in schema.NOZZLE.items() if k != "speed_m_s"}) | table.get_all(schema.JET)
    before = len(table.log.problems)
    feed, pulse = _read_feed(table, exposure_time_s, passes), _read_pulse(table)
    moving = feed is None and table.data.get(_REST, 0) != 0  # then only for want of an exposure
    if len(table.log.problems) > before or moving or None in values.values():
        return None
    return Nozzle(**values, feed=feed, pulse=pulse)


def _read_feed(table: Table, exposure_time_s: float | None, passes: int | None) -> Feed | None:
    """The feed; None for a nozzle at rest, or (with a problem in the log) when it is refused."""
    speed = table.get(_REST, schema.FEED[_REST])
    given = [key for key in schema.FEED if key in table and key != _REST]
    if speed is None:
        return None
    if speed == 0.0:
        for key in given:
            table.problem(key, f"has no effect on a nozzle at rest; allowed: {_REST} above 0, or no {key}")
        return None
    found = {} if passes is None or "passes" in table else {"passes": passes}
    asked = [key for key in schema.FEED if key not in (_REST, "stroke_m", *found)]
    values = {key: table.get(key, schema.FEED[key]) for key in asked} | found
    if values["passes"] == 1 and not found:
        for key in ("pitch_m", "dwell_s"):
            if table.data.get(key, 0) != 0:
                table.problem(key, "has no effect with one pass; allowed 0, or passes from 2 up")
    if "stroke_m" in table:
        stroke = table.get("stroke_m", schema.FEED["stroke_m"])
    elif None in values.values() or exposure_time_s is None:
        return None
    else:
        stroke = _stroke_m(table, speed, values["passes"], values["dwell_s"], exposure_time_s)
    if stroke is None or None in values.values():
        return None
    return Feed(
        speed, stroke, values["passes"], values["pitch_m"], values["dwell_s"], values["feed_direction_deg"]
    )


def _stroke_m(
    table: Table, speed: float, passes: int, dwell_s: float, exposure_time_s: float
) -> float | None:
    """The stroke [m] that fills the exposure, printed as a default."""
    field = schema.FEED["stroke_m"]
    dwells_s = (passes - 1) * dwell_s
    if dwells_s >= exposure_time_s:
        most = exposure_time_s / (passes - 1)
        table.problem(
            "dwell_s",
            f"{passes - 1} dwells of {show(dwell_s)} s leave no time to move in {show(exposure_time_s)} s; allowed "
            f"below {show(most)} s",
        )
        return None
    stroke = speed * (exposure_time_s - dwells_s) / passes
    if problem := field.problem(stroke):
        table.problem("stroke_m", f"feed speed x (exposure - dwells) / passes: {problem}")
        return None
    table.log.default(table.at("stroke_m"), stroke, "derived: feed speed x (exposure - dwells) / passes")
    return stroke


def _read_pulse(table: Table) -> Pulse | None:
    """The pulses; None for a steady flow, or (with a problem in the log) when they are refused."""
    pattern = table.get("mass_flow_pattern", schema.PULSE["mass_flow_pattern"])
    if pattern is None:
        return None
    wanted = ("pulse_frequency_Hz", *schema.PULSE_KEYS[pattern]) if pattern != "steady" else ()
    for key in schema.PULSE:
        if key in table and key not in wanted and key != "mass_flow_pattern":
            words = [word for word, keys in schema.PULSE_KEYS.items() if key in keys] or [
                "pulsed",
                "sinusoidal",
            ]
            patterns = " or ".join(f'"{word}"' for word in words)
            table.problem(
                key,
                f'has no effect with mass_flow_pattern = "{pattern}"; allowed: mass_flow_pattern = {patterns}, or no {key}',
            )
    values = {key.removeprefix("pulse_"): table.get(key, schema.PULSE[key]) for key in wanted}
    return Pulse(pattern, **values) if wanted and None not in values.values() else None
