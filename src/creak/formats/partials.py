"""Names of files and folders on their way, and the removal of those whose process is gone."""

from __future__ import annotations

import os
import re
import shutil
import socket
import time
import uuid
from functools import cache
from pathlib import Path

from creak.digest import digest

OLD = 7 * 86_400.0
"""s since the last change after which what another machine left, or one that was started anew since, is removed."""
LONGEST = 100
"""Bytes of the own name in a partial one."""
OWNED = re.compile(
    r"\.(?P<owner>.+)\.(?P<process>\d+)\.((?P<start>\d*)-(?P<machine>[0-9a-f]{8})-)?[0-9a-f]{4,12}\.partial", re.S
)
NAMELESS = re.compile(r"\..+\.[0-9a-f]{32}\.partial", re.S)
"""As earlier versions called them: nothing tells whose they are. Files of any other name are not creak's."""


def partial_name(name: str) -> str:
    """Hidden, with the host and process that it belongs to: .NAME.HOST.PROCESS.START-MACHINE-RANDOM.partial."""
    short = name.encode()[:LONGEST].decode(errors="ignore")
    process = os.getpid()
    own = f"{_start(process)}-{_machine()}-{uuid.uuid4().hex[:12]}"
    return f".{short}.{socket.gethostname()}.{process}.{own}.partial"


def remove_dead(folder: Path) -> None:
    """Remove the partial files and folders of processes that no longer run.

    Of this machine, since it was started: those whose process is gone or was started at another time. Of others
    that share the folder, which cannot be asked: those that have not changed for a week.
    """
    for path in folder.glob(".*.partial"):
        if not _may_live(path):
            _remove(path)


@cache
def remove_dead_once(folder: Path) -> None:
    """The same, once in the life of this process."""
    remove_dead(folder)


def _may_live(path: Path) -> bool:
    """Whether somebody may still be writing it, or it is none of creak's."""
    found = OWNED.fullmatch(path.name)
    if found is None and NAMELESS.fullmatch(path.name) is None:
        return True
    if found and found["owner"].endswith(f".{socket.gethostname()}") and found["machine"] in (None, _machine()):
        alive = _alive(int(found["process"]), found["start"] or "")
        if alive is not None:
            return alive
    try:
        return time.time() - path.lstat().st_mtime < OLD
    except OSError:  # gone meanwhile
        return True


def _alive(process: int, start: str) -> bool | None:
    """Whether a process of this machine runs, started then (empty: whenever); None: this system does not say."""
    if Path("/proc/self/stat").exists():
        now = _start(process)
        return bool(now) and start in ("", now)
    if os.name != "posix":
        return None
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        return True
    return True


def _start(process: int) -> str:
    """When a process was started, in ticks since the machine was; empty: there is none, or the system does not say."""
    try:
        words = Path(f"/proc/{process}/stat").read_text(encoding="utf-8", errors="replace").rpartition(")")[2].split()
    except OSError:
        return ""
    return "" if words[0] == "Z" else words[19]


@cache
def _machine() -> str:
    """This machine since its start, and the container on it: process numbers mean the same only within one."""
    found = [socket.gethostname()]
    try:
        found += [Path("/proc/sys/kernel/random/boot_id").read_text(encoding="utf-8"), os.readlink("/proc/self/ns/pid")]
    except OSError:
        found.append("")
    return digest(found, 4)


def _remove(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path, ignore_errors=True)
        return
    try:
        path.unlink(missing_ok=True)
    except OSError:  # of another user: left to them
        return
