"""Almen strips by the layer model: arc heights over exposure, and the intensity, of any stream of shots.

One impact at each of a few speeds on SAE 1070 serves every shot: sizes scale exactly, and of density and speed only
density x speed^2 counts.  Between the speeds the layer functions (``glue.target.layers``) and the dimple's radius are
interpolated in the logarithm of the speed.  A strip is held flat while it is peened and let go after: the layers are
those of a part too thick to stretch, then ``strip_arc_height_m``.

The curve is the model's own, without scatter: the intensity is the exact root of h(2 T) = 1.1 h(T) (SAE J443).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from glue.errors import InputError
from glue.scene.catalogue import material
from glue.scene.model import Material
from glue.target.dimple import zero_height_radius
from glue.target.layers import CALIBRATED, LayerShape, LayersResult, layer_profile, layer_shape
from glue.target.part import strip_arc_height_m
from glue.target.reduced_impact import solve_reduced
from glue.target.speeds import Curve, spaced
from glue.theory.almen import Strip, mils

STRIP_MATERIAL = "sae1070"
DENSITY_kg_m3 = 7800.0  # of the shots that are solved
SPEEDS_m_s = tuple(spaced(10.0, 160.0, 7))  # wide enough for 4A of .3 mm shot to 24A of 1.4 mm
ELEMENTS = 3  # per dimple radius: preset fast
RISE = 1.1
MODEL_ERROR = 0.10  # of an arc height: what the layers are from cells in the largest stress (make fit-layers)
_HEAVIEST = CALIBRATED["exposure"].most


class Stream(NamedTuple):
    """Impacts on a place, (k,) each of equally many: diameter, density, normal speed; and their number per area and second."""

    diameter_m: np.ndarray
    density_kg_m3: np.ndarray
    normal_speed_m_s: np.ndarray
    flux_1_m2_s: float


def even_stream(diameter_m: float, density_kg_m3: float, normal_speed_m_s: float, flux_1_m2_s: float = 1e6) -> Stream:
    """Shots all alike."""
    return Stream(*(np.array([float(v)]) for v in (diameter_m, density_kg_m3, normal_speed_m_s)), float(flux_1_m2_s))


@dataclass(frozen=True)
class StripLibrary:
    """Impacts on strip steel at rising speeds, as layer functions; ``own`` material and speeds only in tests."""

    material: Material
    speeds_m_s: tuple[float, ...]
    shapes: tuple[LayerShape, ...]  # all on one grid of zeta

    @cached_property
    def radius(self) -> Curve:
        """Dimple radius over shot radius."""
        return Curve("dimple radius on the strip", self.speeds_m_s, [s.radius_R for s in self.shapes])

    def equivalent_m_s(self, stream: Stream) -> np.ndarray:
        """Speed (k,) of a shot of DENSITY_kg_m3 that leaves the same dimple.  Raises InputError outside the library."""
        speed = stream.normal_speed_m_s * np.sqrt(stream.density_kg_m3 / DENSITY_kg_m3)
        low, high = self.speeds_m_s[0], self.speeds_m_s[-1]
        if not ((speed >= low * (1 - 1e-9)) & (speed <= high * (1 + 1e-9))).all():
            raise InputError(
                f"strip: normal speeds of {stream.normal_speed_m_s.min():.4g} to {stream.normal_speed_m_s.max():.4g} m/s; the"
                f" impacts on strip steel are solved for {low:g} to {high:g} m/s of steel shot (speed x root of density)"
            )
        return np.clip(speed, low, high)

    def shape_at(self, speed_m_s: float) -> LayerShape:
        """Layer functions at a speed of steel shot: straight in its logarithm between the two solved ones beside it."""
        k = int(np.clip(np.searchsorted(self.speeds_m_s, speed_m_s), 1, len(self.speeds_m_s) - 1))
        low, high = self.speeds_m_s[k - 1 : k + 1]
        share = math.log(speed_m_s / low) / math.log(high / low)
        a, b = self.shapes[k - 1 : k + 1]
        mixed = ((1.0 - share) * getattr(a, name) + share * getattr(b, name) for name in ("s_Pa", "p", "h"))
        return LayerShape(a.zeta, *mixed, float(self.radius(speed_m_s)))

    def dimple_radii_m(self, stream: Stream) -> np.ndarray:
        """Dimple radius on the strip (k,)."""
        return 0.5 * stream.diameter_m * self.radius(self.equivalent_m_s(stream))

    def hits_1_s(self, stream: Stream) -> float:
        """Dimple area per area and second: exposure (mean hits) of a point of the strip per second."""
        return stream.flux_1_m2_s * float(np.mean(math.pi * self.dimple_radii_m(stream) ** 2))

    def layers(self, stream: Stream, hits: float, *, check: bool = False) -> LayersResult:
        """The clamped strip's layers after ``hits`` dimple areas per area.  Raises InputError beyond the model."""
        speed, radii = self.equivalent_m_s(stream), self.dimple_radii_m(stream)
        largest = int(np.argmax(radii))
        energy = stream.diameter_m**3 * speed**2 / radii**3
        area = float((math.pi * radii**2).sum()) / hits
        return layer_profile(
            self.shape_at(float(speed[largest])), self.material, radii, area, work_ratio=energy / energy[largest], check=check
        )

    def arc_height_m(self, strip: Strip, stream: Stream, hits: float) -> float:
        """Gauge reading [m].  Raises InputError when the strip ends inside the peened layer."""
        found = self.layers(stream, hits)
        try:
            return strip_arc_height_m(found, strip.thickness_m, self.material.E_Pa, self.material.nu)
        except InputError as problem:
            raise InputError(f"strip {strip.letter}: {problem}; a thicker strip") from None

    def saturation(self, strip: Strip, stream: Stream) -> tuple[float, float]:
        """(hits, arc height [m]) at the exact root of h(2 T) = 1.1 h(T).  Raises InputError when there is none."""
        from scipy.optimize import brentq  # here and below: half a second that other stages do without

        def over(x: float) -> float:
            hits = math.exp(x)
            return self.arc_height_m(strip, stream, 2.0 * hits) - RISE * self.arc_height_m(strip, stream, hits)

        low, high = math.log(0.02), math.log(0.5 * _HEAVIEST)
        if over(low) < 0.0 or over(high) > 0.0:
            raise InputError(
                f"strip {strip.letter}: no saturation within {0.5 * _HEAVIEST:g} hits per point, beyond which the layer model is not"
                " calibrated"
            )
        hits = math.exp(brentq(over, low, high, xtol=1e-5))
        return hits, self.arc_height_m(strip, stream, hits)

    def intensity_m(self, strip: Strip, stream: Stream) -> float:
        """Arc height [m] at saturation."""
        return self.saturation(strip, stream)[1]


class IntensityCurve:
    """Intensity of one strip over a factor on all speeds of a stream, as far as the library and the strip go.

    A monotone spline through POINTS exact values in logarithms.  Beyond some speed a thin strip yields through half of its
    thickness and bends less again: the rising part alone counts.  Raises InputError when there is none.
    """

    POINTS = 17

    def __init__(self, library: StripLibrary, strip: Strip, stream: Stream):
        from scipy.interpolate import PchipInterpolator

        self.library, self.strip, self.stream = library, strip, stream
        equivalent = stream.normal_speed_m_s * np.sqrt(stream.density_kg_m3 / DENSITY_kg_m3)
        least, most = library.speeds_m_s[0] / equivalent.min(), library.speeds_m_s[-1] / equivalent.max()
        found = []
        for x in np.linspace(math.log(least), math.log(most), self.POINTS) if least < most else ():
            try:
                value = math.log(self.exact(math.exp(x)))
            except InputError:  # too deep for the strip, or no saturation
                if found:
                    break
                continue
            if found and value <= found[-1][1]:
                break
            found.append((float(x), value))
        if len(found) < 2:
            raise InputError(f"strip {strip.letter}: no speed at which these shots bend it as they should; allowed another strip")
        self.x, self.y = map(np.array, zip(*found))
        self._spline = PchipInterpolator(self.x, self.y)

    def exact(self, factor: float) -> float:
        """Intensity [m] with the speeds of the stream times ``factor``, from the model itself."""
        return self.library.intensity_m(self.strip, self.faster(factor))

    def faster(self, factor: float) -> Stream:
        return self.stream._replace(normal_speed_m_s=self.stream.normal_speed_m_s * factor)

    def exponent(self, factor: float) -> float:
        """Intensity ~ speed^exponent there."""
        return float(self._spline(np.clip(math.log(factor), self.x[0], self.x[-1]), 1))

    def factor(self, intensity_m: float, *, polish: bool = True) -> float:
        """The factor that brings this intensity; to 1e-4 with ``polish``, else as good as the spline.

        Raises InputError with what can be had when it lies beyond.
        """
        from scipy.optimize import brentq

        y = math.log(intensity_m)
        if not self.y[0] <= y <= self.y[-1]:
            ends = (
                f"{mils(math.exp(self.y[k])):.3g}{self.strip.letter} (at"
                f" {self.stream.normal_speed_m_s.mean() * math.exp(self.x[k]):.3g} m/s normal speed)"
                for k in (0, -1)
            )
            raise InputError(f"{mils(intensity_m):.3g}{self.strip.letter} is out of reach of these shots: allowed {' to '.join(ends)}")
        x = brentq(lambda x: float(self._spline(x)) - y, self.x[0], self.x[-1], xtol=1e-9)
        for _ in range(5 if polish else 0):
            off = (math.log(self.exact(math.exp(x))) - y) / self.exponent(math.exp(x))
            x = float(np.clip(x - off, self.x[0], self.x[-1]))
            if abs(off) < 1e-4:
                break
        return math.exp(x)


def strip_library(progress: Callable[[float, str], None] | None = None, elements_per_radius: int = ELEMENTS) -> StripLibrary:
    """The impacts on strip steel, from the cache where they were solved before (some 15 s where not).

    Raises SolverFailed, NotConverged.
    """
    steel, shapes = material(STRIP_MATERIAL), []
    for k, speed in enumerate(SPEEDS_m_s):
        if progress:
            progress(k / len(SPEEDS_m_s), f"impact on strip steel at {speed:.4g} m/s")
        impact = solve_reduced(
            steel, steel.combined, speed_m_s=speed, density_kg_m3=DENSITY_kg_m3, elements_per_radius=elements_per_radius
        )
        shapes.append(layer_shape(impact, steel.combined, zero_height_radius(impact)))
    return StripLibrary(steel, SPEEDS_m_s, tuple(shapes))
