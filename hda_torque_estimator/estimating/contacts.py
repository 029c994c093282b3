"""The contacts of a recording: when something touched the arm, and beyond which joint."""

from collections import Counter
from typing import NamedTuple

from hda_arm_sim.model.arm import Arm
import numpy as np

from .estimates import Estimates
from .laws import layout
from .state_messages import touched_beyond

# Choices unless stated otherwise.
_APART = 0.1            # pauses between two contacts that are none, as in laws/contact.py [s]
_LINES = 5              # contacts that are listed one by one


class Contact(NamedTuple):
    """One contact: seconds since the first sample, and the joint that it mostly lay beyond."""

    begin: float
    end: float
    beyond: str

    def __str__(self) -> str:
        """Return one sentence."""
        return f'contact from {self.begin:.2f} to {self.end:.2f} s, beyond {self.beyond}'


def contacts(arm: Arm, estimates: Estimates, level: float) -> list[Contact]:
    """
    Return the contacts of a recording; none where links are unknown.

    A contact lasts while some joint feels it, and is one if all joints together exceed `level`
    deviations meanwhile. So a collision, which stays reported until the reset, is over when the
    arm is let go.
    """
    touched = np.array(touched_beyond(arm.labels, estimates.joints, estimates.tip))
    rows = np.flatnonzero(touched != '')
    if arm.links is None or not len(rows):
        return []
    time = (estimates.stamps - estimates.stamps[0]) * 1e-9
    felt = estimates.tip[:, layout.CONTACT_DEVIATIONS]
    parts = np.split(rows, np.flatnonzero(np.diff(time[rows]) > _APART) + 1)
    return [Contact(float(time[part[0]]), float(time[part[-1]]),
                    str(Counter(touched[part].tolist()).most_common(1)[0][0]))
            for part in parts if felt[part].max() > level]


def contact_lines(found: list[Contact]) -> list[str]:
    """Return what people read of contacts: the first ones, and how many more there are."""
    lines = [str(one) for one in found[:_LINES]]
    return [*lines, f'and {len(found) - _LINES} contacts more'] if found[_LINES:] else lines
