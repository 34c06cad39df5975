"""How numba compiles the event loop: its parts without reference counts, the whole kept on disk.

numba counts the references to every array of every call, with locked instructions: a third of the time here,
where functions are small and are handed all arrays.  Parts own no array and return none, so they need not.

numba keeps a compiled function as long as its own file does not change, and would go on using a kernel whose
parts changed in other files.  So the parts are not kept, and the whole closes over ``sources``, on which what is
kept depends.
"""

from __future__ import annotations

import hashlib
from pathlib import Path

from numba import njit


def part(function):
    """Compile a function that only other compiled ones call; see above."""
    return njit(function, _nrt=False)


def sources() -> int:
    """A number that changes with any file that the event loop is made of."""
    here = Path(__file__).parent
    names = ("drag", "jets", "pair_contact", "restitution", "tangential", "touch")
    files = sorted(here.glob("event_*.py")) + [here / f"{name}.py" for name in names]
    digest = hashlib.sha256(b"".join(file.read_bytes() for file in files)).digest()
    return int.from_bytes(digest[:7], "big")
