"""What a fleet's diagnoses say side by side: JSON for machines, lines for people."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from .history import Device, devices
from .lines import BagLine, FAILED

SCHEMA = 'hda.fleet/1'


def fleet_document(lines: Sequence[BagLine], arm: str, version: str,
                   skipped: Sequence[str] = ()) -> dict[str, Any]:
    """Return the JSON document of a fleet."""
    return {'schema': SCHEMA, 'arm': arm, 'version': version,
            'verdicts': dict(sorted(verdicts(lines).items())),
            'effects': [{'effect': effect, 'joint': joint, 'bags': count}
                        for (effect, joint), count in causes_of(lines)],
            'devices': [_device(device) for device in devices(lines)],
            'bags': [{**asdict(line), 'findings': [asdict(cause) for cause in line.findings]}
                     for line in lines],
            'skipped': list(skipped)}


def _device(device: Device) -> dict[str, Any]:
    latest = device.latest
    return {'device': device.name, 'bags': len(device.lines), 'latest': latest.bag,
            'date': latest.date, 'verdict': latest.verdict, 'severity': latest.severity,
            'causes': [{**asdict(course), 'points': [asdict(point) for point in course.points]}
                       for course in device.courses()]}


def verdicts(lines: Sequence[BagLine]) -> Counter[str]:
    """Return how many bags have each verdict, or none."""
    return Counter(line.verdict or FAILED for line in lines)


def causes_of(lines: Sequence[BagLine]) -> list[tuple[tuple[str, str | None], int]]:
    """Return every named cause with the number of bags that show it, the most first."""
    found = Counter((cause.effect, cause.joint) for line in lines for cause in line.findings)
    return sorted(found.items(), key=lambda item: (-item[1], item[0][0], item[0][1] or ''))
