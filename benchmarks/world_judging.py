"""What counts as identified, wrong, placed: judgements of one record of the study of worlds."""

from collections.abc import Iterator
from typing import Any

from diagnosis_tables import pairs_of, Place
from hidden_truth import ONE_EQUATION

Outcome = dict[str, Any]


def hidden_places(result: Outcome) -> set[Place]:
    """Return effects and joints that are hidden."""
    return set(pairs_of(result['hidden']))


def allowed(result: Outcome) -> set[Place]:
    """Return what may be named: what is hidden, its twins, and what the log itself adds."""
    joints = {joint for _, joint in hidden_places(result)} | {None, 'joint1', 'joint2'}
    twins = {(name, joint) for effect, joint in hidden_places(result) if effect in ONE_EQUATION
             for name in ONE_EQUATION}
    return hidden_places(result) | twins | {
        (name, joint) for name in result['tolerated'] for joint in joints}


def groups(result: Outcome) -> list[set[Place]]:
    """Return the sets of causes that are reported together as alike."""
    return [{(name, joint) for name, joint in pair} for pair in result['alike']]


def identified(result: Outcome) -> set[Place]:
    """Return what is hidden and named, or reported together with its twin."""
    named = set(pairs_of(result['said'])) | set().union(*groups(result))
    return {place for place in hidden_places(result)
            if place in named or _twin_named(result, place, named)}


def _twin_named(result: Outcome, place: Place, named: set[Place]) -> bool:
    """Return whether a law that names such a form as well is named at its joint."""
    forms = [one for one in result['tolerated'] if one not in ('clock_jitter', 'external_contact')]
    return len(result['hidden']) == 1 and any(
        (name, joint) in named for name in forms for joint in (place[1], None))


def wrong(result: Outcome) -> set[Place]:
    """Return causes that are named and not hidden, and sets called alike that hold no true one."""
    fair = allowed(result)
    named = {place for place in pairs_of(result['said']) if place not in fair}
    return named | {sorted(group, key=str)[0] for group in groups(result) if not group & fair}


def all_identified(result: Outcome) -> bool:
    """Return whether everything hidden is identified, and nothing wrong."""
    return identified(result) == hidden_places(result) and not wrong(result)


def accused(result: Outcome) -> bool:
    """Return whether a healthy arm is accused: of a cause, or of one without a name."""
    return bool(wrong(result)) or result['verdict'] == 'unknown'


def visible(result: Outcome) -> bool:
    """Return whether all that is hidden is above the smallest size that the report states."""
    return all(above for *_, above in result['sizes'])


def unknown_at_joint(result: Outcome) -> bool:
    """Return whether what no catalogue has is unknown, at its site and joint."""
    rest, (_, joint, _, site, *_) = result['rest'], result['hidden'][0]
    return (result['verdict'] == 'unknown' and not wrong(result) and rest is not None
            and rest[0] == site and rest[1] in (joint, None))


def follows(result: Outcome) -> bool:
    """Return whether the rest follows the right coordinate."""
    return unknown_at_joint(result) and result['rest'][2] == result['hidden'][0][4]


def largest_identified(result: Outcome, most: int = 5) -> float:
    """Return which share of the largest causes by what they do is identified."""
    places = [(one[0], one[1]) for one in result['hidden']]
    order = sorted(range(len(places)), key=lambda place: -result['powers'][place])[:most]
    return sum(places[place] in identified(result) for place in order) / len(order)


def intervals(result: Outcome) -> Iterator[bool]:
    """Yield for each number of the causes named right whether its interval holds the truth."""
    said = {(name, joint): numbers for name, joint, numbers, _ in result['said']}
    for hidden, numbers in zip(result['hidden'], result['numbers']):
        found = said.get((hidden[0], hidden[1]), {})
        for name, (whole, _) in numbers.items():
            if name in found:
                _, low, high = found[name]
                yield low <= whole <= high


def probabilities(result: Outcome) -> Iterator[tuple[float, bool]]:
    """Yield each cause that is named with a probability, and whether it is right."""
    for name, joint, _, probability in result['said']:
        if probability is not None:
            yield probability, (name, joint) in allowed(result)


def simple_is_right(result: Outcome) -> bool:
    """Return whether the best correlation names the one cause that is hidden."""
    best = result['baseline']
    return best is not None and (best[0], best[1]) in allowed(result)


def simple_is_wrong(result: Outcome) -> bool:
    """Return whether the best correlation names a cause that is not hidden."""
    return result['baseline'] is not None and not simple_is_right(result)
