"""Numbers as people read them: with few figures, in handy units, with their interval."""

from collections.abc import Sequence
import math
import re

# Choices unless stated otherwise.
# (source: one radian in minutes of arc)
ARCMIN = 10800.0 / math.pi      # one radian [arcmin]
_PREFIXES = ((1e-6, 'µ'), (1e-3, 'm'), (1.0, ''))
_COARSE = 0.1           # angle from which degrees say more than mrad [rad]
_FIGURES = 4            # of the largest number of a row
_TINY, _HUGE = 1e-5, 1e7        # beyond which a number is written with an exponent
_BEFORE_UNIT = re.compile(r'(?<=\d) (?=[µmk]?(?:N|m|s|g|rad|Hz)\b|%|°|arcmin\b)')
_SCALED = ('s', 'rad', 'N*m', 'm', 'N', 'rad/s', 'N*m*s/rad')


def figure(value: float) -> str:
    """Return a number with four figures."""
    return f'{value:.4g}' if math.isfinite(value) else 'unknown'


def short(value: float) -> str:
    """Return a number with two figures and no exponent where it is large."""
    if not math.isfinite(value):
        return 'unknown'
    whole = abs(value) >= 99.5          # two figures of 99.7 are those of 100
    return f'{value:,.0f}' if whole else f'{value:.2g}'


def unit(name: str) -> str:
    """Return a unit as people write it; a pure number has none."""
    return '' if name == '1' else name.replace('*', '\N{MIDDLE DOT}')


def with_unit(name: str, scale: str) -> str:
    """Return a name with its unit in brackets, as heads of tables have it."""
    return f'{name} [{unit(scale)}]' if unit(scale) else name


def percent(share: float) -> str:
    """Return a share in per cent with at most one decimal."""
    if not math.isfinite(share):
        return 'unknown'
    shown = f'{100.0 * share:.1f} %'
    return shown.removeprefix('-') if shown == '-0.0 %' else shown


def handy(value: float, scale: str) -> str:
    """Return a value with the unit in which people say it; angles in minutes of arc as well."""
    if scale in ('', '1'):
        return f'{short(100.0 * value)} %'
    if scale not in _SCALED or not math.isfinite(value):
        return f'{short(value)} {unit(scale)}'
    if scale == 'rad' and abs(value) >= _COARSE:
        return f'{short(math.degrees(value))}°'
    size, prefix = _prefixed(abs(value))
    shown = f'{short(value / size)} {prefix}{unit(scale)}'
    return f'{shown} ({short(value * ARCMIN)} arcmin)' if scale == 'rad' else shown


def ranged(low: float, high: float, scale: str) -> str:
    """
    Return both ends of a range as `0.18 and 0.22 mrad`, in the unit of the larger one.

    They have two figures, and more where these do not distinguish them.
    """
    largest = max(abs(low), abs(high))
    if scale in ('', '1') or (scale == 'rad' and largest >= _COARSE):
        apart = (handy(low, scale), handy(high, scale))
        if apart[0] != apart[1]:
            return ' and '.join(apart)
    size, prefix = _prefixed(largest) if scale in _SCALED else (1.0, '')
    first, last = (short(end / size) for end in (low, high))
    if first == last:
        (first, last), whole = in_unit([low, high], scale)
    else:
        whole = prefix + unit(scale)
    both = f'{first} and {last} {whole}'.rstrip()
    if scale != 'rad':
        return both
    first, last = (short(end * ARCMIN) for end in (low, high))
    return f'{both} ({first}{f" and {last}" * (first != last)} arcmin)'


def in_unit(values: Sequence[float], scale: str) -> tuple[list[str], str]:
    """
    Return numbers of one unit, and the handy unit that all of them have.

    The largest has four figures, and none has more decimals than it.
    """
    largest = max((abs(value) for value in values if math.isfinite(value)), default=0.0)
    size, prefix = _prefixed(largest) if scale in _SCALED and largest else (1.0, '')
    return [_decimal(value / size, largest / size) for value in values], prefix + unit(scale)


def _decimal(value: float, largest: float) -> str:
    """Return a number with as many decimals as the largest one beside it has in four figures."""
    if not math.isfinite(value) or not _TINY < largest < _HUGE:
        return figure(value)
    decimals = max(0, _FIGURES - 1 - math.floor(math.log10(largest)))
    text = f'{value:.{decimals}f}'
    text = text.rstrip('0').rstrip('.') if '.' in text else text
    return '0' if text == '-0' else text


def unbroken(text: str) -> str:
    """Return a text in which no line ends between a number and its unit."""
    return _BEFORE_UNIT.sub('\N{NO-BREAK SPACE}', text)


def spoken(name: str) -> str:
    """Return the name of a joint or an effect as words: `joint1` is joint 1."""
    return re.sub(r'(?<=[a-z])(?=\d+$)', ' ', name.replace('_', ' '))


def capital(sentence: str) -> str:
    """Return a sentence that begins with a capital letter."""
    return sentence[:1].upper() + sentence[1:]


def _prefixed(size: float) -> tuple[float, str]:
    """Return the largest prefix of which a size has at least a tenth, or two hundredths of 1."""
    found = _PREFIXES[0]
    for one in _PREFIXES:
        if size >= 0.1 * one[0]:
            found = one
    return found
