"""How a process is started so that it can be asked to stop, and how it is ended for good, on each system.

Windows knows no SIGTERM: a process that leads a group of its own is sent Ctrl-Break, which the command line
takes as an interruption.  For that it must share Blender's console, so its window is hidden, not missing.
Takes and gives processes; leaves out what they do.  Needs no bpy.
"""

import os
import signal
import subprocess
from typing import Any

WINDOWS = os.name == "nt"

CREATE_NEW_PROCESS_GROUP, STARTF_USESHOWWINDOW, SW_HIDE = 0x200, 1, 0
"""As subprocess has them on Windows only."""

PATIENCE_S = 2.0
"""A process that was asked to stop and still runs after this is ended."""


def start_options(windows: bool = WINDOWS, api: Any = subprocess) -> dict[str, Any]:  # noqa: ANN401 - a module
    """Further arguments of ``subprocess.Popen``: a group of its own, and no window that a person sees."""
    if not windows:
        return {"start_new_session": True}
    hidden = api.STARTUPINFO()
    hidden.dwFlags |= STARTF_USESHOWWINDOW
    hidden.wShowWindow = SW_HIDE
    return {"creationflags": CREATE_NEW_PROCESS_GROUP, "startupinfo": hidden}


def ask_to_stop(process: subprocess.Popen[bytes], windows: bool = WINDOWS) -> None:
    """Ask the process to end and keep what is finished; on Windows one without our console is ended."""
    if not windows:
        _signal_group(process, signal.SIGTERM)  # what it started hears it too
        return
    try:
        process.send_signal(getattr(signal, "CTRL_BREAK_EVENT", 1))
    except OSError:  # a Blender without any console shares none
        end(process, windows)


def end(process: subprocess.Popen[bytes], windows: bool = WINDOWS) -> None:
    """End the process and all that it started, and wait until it is gone."""
    if process.poll() is None:
        if windows:
            # TerminateProcess would leave its children alive
            subprocess.run(
                ["taskkill", "/PID", str(process.pid), "/T", "/F"],
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                check=False,
            )
        else:
            _signal_group(process, signal.SIGKILL)
    try:
        process.wait(PATIENCE_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def _signal_group(process: subprocess.Popen[bytes], number: signal.Signals) -> None:
    try:
        os.killpg(process.pid, number)
    except ProcessLookupError:  # gone in this moment
        return
