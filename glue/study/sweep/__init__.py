"""Parametric studies: one scene, axes along which it changes, a table of what came out."""

from glue.study.sweep.run import run_study

__all__ = ["run_study"]
