"""Memory that a long command gives back stays with its process, for the next array as large."""

from ctypes import CDLL
import sys

# Names of glibc, with their meaning in mallopt(3).
_TRIM_THRESHOLD, _MMAP_MAX = -1, -4
_NEVER = 2 ** 31 - 1    # bytes free at the end of the heap that are given back: a C int at most


def keep_freed_memory() -> None:
    """
    Let this process keep what it frees; where the C library is not glibc nothing changes.

    Arrays of more than 32 MB come from the system and go back to it else, each time. Its pages
    are made and cleared anew: a copy of derivative columns of seven joints took eight times as
    long as copying does.
    """
    if not sys.platform.startswith('linux'):
        return
    adjust = getattr(CDLL(None), 'mallopt', None)
    if adjust is not None:
        adjust(_MMAP_MAX, 0)
        adjust(_TRIM_THRESHOLD, _NEVER)
