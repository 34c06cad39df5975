"""What every script run by ``yade`` does first: close its ports, and see to its temporary folder."""

from __future__ import annotations

import atexit
import gc
import os
import shutil
import socketserver
from pathlib import Path


def close_listeners() -> int:
    """Shut down the servers that ``yade`` starts unasked; returns how many listening sockets remain (0).

    It opens a Python prompt (port 9000) and an XML-RPC server (21000), both on all interfaces, without a
    switch to prevent it.  Both are ordinary socketserver objects of this process.
    """
    for server in [o for o in gc.get_objects() if isinstance(o, socketserver.BaseServer)]:
        server.shutdown()
        server.server_close()
    return len(listening_sockets())


def remove_scratch_at_exit() -> Path:
    """Have YADE's temporary folder removed when the script ends; returns it.

    YADE leaves one per run.  After ``kill -9`` it stays all the same: /tmp/yade-*, a few bytes, safe to delete.
    """
    from yade import O

    scratch = Path(O.tmpFilename()).parent
    atexit.register(shutil.rmtree, scratch, ignore_errors=True)
    return scratch


def listening_sockets() -> list[str]:
    """Local addresses (hex, as in /proc/net/tcp) of the sockets on which this process accepts connections."""
    own = set()
    for fd in os.listdir("/proc/self/fd"):
        try:
            target = os.readlink(f"/proc/self/fd/{fd}")
        except OSError:  # the descriptor of the listing itself is gone by now
            continue
        if target.startswith("socket:["):
            own.add(target[len("socket:[") : -1])
    listening = []
    for table in ("tcp", "tcp6"):
        with open(f"/proc/self/net/{table}") as f:
            for line in f.readlines()[1:]:
                _, local, _, state, *rest = line.split()
                if state == "0A" and rest[5] in own:  # 0A: LISTEN; rest[5]: inode
                    listening.append(local)
    return listening
