"""Peak memory in MiB, on each system by its own means."""

import ctypes
import math
import subprocess
import sys

import pytest

from pipeline.core import memory
from pipeline.core.memory import peak_memory_mb


def test_the_peak_grows_by_what_is_used_and_stays():
    # in a process of its own: this one may have had its peak long ago; and a system may hand that peak on
    words = (
        "from pipeline.core.memory import peak_memory_mb as peak; a = peak(); b = bytearray(100 << 20); "
        "b[::4096] = b'x' * len(b[::4096]); m = peak(); del b; print(m - a, peak() - m)"
    )
    done = subprocess.run([sys.executable, "-c", words], capture_output=True, text=True, check=True)
    grown, after = map(float, done.stdout.split())
    assert 95 < grown < 115
    assert abs(after) < 5  # the memory is given back, the peak stays


def test_windows_names_no_module_that_it_lacks(monkeypatch):
    monkeypatch.setattr(sys, "platform", "win32")
    monkeypatch.setattr(ctypes, "WinDLL", lambda name: Kernel(answer=1), raising=False)
    monkeypatch.setitem(sys.modules, "resource", None)  # importing it would raise
    assert peak_memory_mb() == pytest.approx(123.0)


def test_a_system_that_does_not_tell_gives_no_number(monkeypatch):
    monkeypatch.setattr(sys, "platform", "win32")
    monkeypatch.setattr(ctypes, "WinDLL", lambda name: Kernel(answer=0), raising=False)
    assert math.isnan(peak_memory_mb())


@pytest.mark.skipif(ctypes.sizeof(ctypes.c_void_p) != 8, reason="sizes of a 64-bit system")
def test_the_record_is_as_long_as_windows_has_it():
    assert ctypes.sizeof(memory._Counters) == 72
    assert memory._Counters.PeakWorkingSetSize.offset == 8


class Kernel:
    """kernel32 as far as it is asked: the peak is 123 MiB."""

    def __init__(self, answer):
        class Ask:
            def __call__(self, process, counters, size):
                assert size == 72
                counters._obj.PeakWorkingSetSize = 123 << 20
                return answer

        class Current:
            def __call__(self):
                return -1

        self.K32GetProcessMemoryInfo = Ask()
        self.GetCurrentProcess = Current()
