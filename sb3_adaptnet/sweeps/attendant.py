"""The process of one run, and whoever looks after it."""

import os
import signal
import subprocess
import sys
import threading
from pathlib import Path

from sb3_adaptnet.sweeps.unit import UnitFolder

COMMAND = ("-m", "sb3_adaptnet.commands.main", "sweep", "run")
"""Words for Python that do one run; its folder follows."""
ATTENDED = "--attended"
"""Tells the process that its input is a pipe from whoever looks after it."""
REFUSED = 2
"""Exit code of a process that was given bad input: once more would give the same."""


class RunDiedError(RuntimeError):
    """The process of a run was killed, stopped or broke; it can be taken up again."""


def attend(path: str | Path) -> bool:
    """Let a process do what its run's folder says, and wait for its end.

    The process holds the other end of a pipe: if this one ends, whatever way, it saves a checkpoint and ends, too.

    Args:
        path: the run's folder.

    Returns:
        Whether the run is done; if not, its input was refused, and `failure.txt` says why.

    Raises:
        RunDiedError: if the process was killed or broke.
    """
    folder = UnitFolder(path)
    if folder.is_done():
        print(f"{folder.path.name}: done before", flush=True)
        return True
    print(f"{folder.path.name}: {'goes on' if folder.begun else 'begins'}", flush=True)
    folder.failure.unlink(missing_ok=True)
    code = _wait_for_process(folder)
    if code == 0:
        print(f"{folder.path.name}: done", flush=True)
        return True
    words = f"exit code {code}: {last_line(folder.log)}" if code > 0 else f"killed by signal {-code}"
    folder.failure.write_text(f"{words}\n", encoding="utf-8")
    print(f"{folder.path.name}: {words}", flush=True)
    if code == REFUSED:
        return False
    raise RunDiedError(f"{folder.path.name}: {words}")


def _wait_for_process(folder: UnitFolder) -> int:
    command = [sys.executable, *COMMAND, str(folder.path), ATTENDED]
    with folder.log.open("ab") as log:
        # A session of its own: Ctrl-C reaches this process alone, which then closes the pipe.
        process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=log, stderr=subprocess.STDOUT, start_new_session=True
        )
        try:
            return process.wait()
        finally:
            assert process.stdin is not None
            process.stdin.close()
            process.wait()


def end_with_attendant() -> None:
    """Send this process SIGTERM as soon as whoever holds the other end of its input is gone."""

    def wait() -> None:
        while os.read(0, 1):
            pass
        os.kill(os.getpid(), signal.SIGTERM)

    threading.Thread(target=wait, daemon=True).start()


def last_line(log: Path) -> str:
    """The last line of a log that says something."""
    lines = [line.strip() for line in log.read_text(encoding="utf-8", errors="replace").splitlines() if line.strip()]
    return lines[-1] if lines else "it said nothing"
