"""Some runs of a ladder in a process of their own:  python -m glue.study.tradeoff.child JOBS.json

JOBS.json: [[scene file, content file, run directory, [stage, …]], …].  Prints ``done K SECONDS`` or ``failed K REASON`` (a
JSON text) after each.
"""

from __future__ import annotations

import json
import os
import sys
import time
from pathlib import Path

from glue import stopping
from glue.errors import PeenError
from glue.study import pipeline
from glue.target.cache import cache_root


def main(argv: list[str]) -> int:
    os.environ.setdefault("NUMBA_CACHE_DIR", str(cache_root() / "numba"))
    told = [""]

    def progress(stage: str, fraction: float | None, text: str) -> None:
        if stage != told[0]:
            told[0] = stage
            print(f"{stage} {text}", flush=True)

    for k, (scene, content, out, stages) in enumerate(json.loads(Path(argv[0]).read_text())):
        begun = time.monotonic()
        try:
            with stopping.noticed():
                pipeline.run(scene, Path(out), only=stages, progress=progress, content=Path(content).read_bytes())
        except PeenError as problem:
            print(f"failed {k} {json.dumps(str(problem))}", flush=True)
        except KeyboardInterrupt:
            return 130
        else:
            print(f"done {k} {time.monotonic() - begun:.3f}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
