"""One run of the ladder in a process of its own:  python -m glue.study.tradeoff.child SCENE CONTENT OUT STAGE..."""

from __future__ import annotations

import os
import sys
from pathlib import Path

from glue import stopping
from glue.errors import PeenError
from glue.study import pipeline
from glue.target.cache import cache_root


def main(argv: list[str]) -> int:
    scene, content, out, *stages = argv
    os.environ.setdefault("NUMBA_CACHE_DIR", str(cache_root() / "numba"))
    told = [""]

    def progress(stage: str, fraction: float | None, text: str) -> None:
        if stage != told[0]:
            told[0] = stage
            print(f"{stage} {text}", flush=True)

    try:
        with stopping.noticed():
            pipeline.run(scene, Path(out), only=stages, progress=progress, content=Path(content).read_bytes())
    except PeenError as problem:
        print(f"peen: {problem}", flush=True)
        return problem.exit_code
    except KeyboardInterrupt:
        return 130
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
