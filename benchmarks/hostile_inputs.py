"""Inputs that are nearly right, made by seeds: each kind writes its files and returns a call."""

from collections.abc import Callable
from functools import cache
from importlib import resources
import io
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

from hda_arm_sim.model.files import read_arm
from hda_msgs_json.bag import BagWriter
from hda_msgs_json.bag_writer import Files
from hda_msgs_json.samples import JointSamples
from hda_msgs_json.topics import JOINT_STATES
import numpy as np
import pyarrow as pa
import pyarrow.parquet
from scipy.io import savemat

Random = np.random.Generator
ARM = 'hda_arm.yaml'
SAMPLES = 300                   # of the bag: too few to be diagnosed, enough for all else
SCALARS = (
    '2001-99-99', '[deg]', '{a: b}', '~', '.nan', '.inf', '-1', '1e308', '1e999', '0x' + 'f' * 99,
    '!!int ""', '!!timestamp x', '!!python/object:os.system x', '*nothing', '&a [*a]', '"', "'",
    '\x00', '\x1b[2J', 'joint1', '9' * 5000, '[' * 300, '- ' * 300, '\udcff', 'true', '', '0o9',
    '1:99:99', '<<: x', '? [a]', '|', '%TAG', '@', '`', '2001-01-01T00:00:00+99:99', 'é', '1_0')
WORDS = (
    '', ' ', '-', '--', '-1', '.', '..', '/', '/dev/null', '/dev/zero', '/proc/self/mem', 'nan',
    'inf', '1e999', '9' * 400, 'a' * 5000, '\x1b[31m', '\n', '\u202e', 'joint9', 'payload',
    '--json', '--help', '--out', '--arm', '--force', '--each', '--workers', '--motion', '--tilt',
    '*', '~', '$HOME', '%s', '{}', '\udcff', '0:1', 'missing.yaml', 'missing.mcap')
EFFECTS = """- {effect: backlash, joint: joint1, parameters: {half_width: 1.0e-4}}
- {effect: payload, parameters: {mass: 1.0}}
- effect: coulomb_friction
  joint: joint2
  parameters: {torque: 0.01}
"""
COLUMN_MAP = """time: {column: t, unit: s, zero: first}
each:
  ratio: 100.0
  motor: {position: {column: 'qm{n}', unit: rad, sign: 1}, effort: {column: 'tau{n}', unit: N*m}}
  link: {position: {column: 'q{n}', unit: rad, side: link, zero: mean}}
joints: [joint1, joint2]
"""


class Place(NamedTuple):
    """A folder with the files of one input, and where the command is to write."""

    folder: Path

    @property
    def out(self) -> Path:
        """Return where the command is to write."""
        return self.folder / 'out'

    def put(self, name: str, content: bytes) -> str:
        """Write a file, and return its path."""
        (self.folder / name).write_bytes(content)
        return str(self.folder / name)


def model(random: Random, place: Place) -> list[str]:
    """Return a call with a damaged arm."""
    text = (resources.files('hda_arm_sim.config') / ARM).read_text()
    arm = place.put('arm.yaml', damaged_text(random, text))
    return ['simulate', '--arm', arm, '--motion', 'nowhere.csv', '--out', str(place.out)]


def effects(random: Random, place: Place) -> list[str]:
    """Return a call with damaged effects."""
    file = place.put('effects.yaml', damaged_text(random, EFFECTS))
    return ['simulate', '--arm', ARM, '--effects', file, '--motion', 'nowhere.csv', '--out',
            str(place.out)]


def column_map(random: Random, place: Place) -> list[str]:
    """Return a call with a damaged column map."""
    table = place.put('table.npz', tables()['npz'])
    file = place.put('map.yaml', damaged_text(random, COLUMN_MAP))
    return ['import', table, '--map', file, '--out', str(place.out)]


def table(random: Random, place: Place) -> list[str]:
    """Return a call with a damaged table."""
    kind = str(random.choice(list(tables())))
    damage = damaged_text if kind == 'csv' and random.random() < 0.7 else damaged_bytes
    content = tables()[kind]
    file = place.put(f'table.{kind}', damaged_text(random, content.decode())
                     if damage is damaged_text else damaged_bytes(random, content))
    if random.random() < 0.5:
        return ['import', file, '--guess']
    file_of_map = place.put('map.yaml', COLUMN_MAP.encode())
    return ['import', file, '--map', file_of_map, '--out', str(place.out)]


def bag(random: Random, place: Place) -> list[str]:
    """Return a call with a damaged bag: bytes that are broken, or numbers that cannot be."""
    bag = place.folder / 'bag'
    if random.random() < 0.5:
        _write_bag(bag, strange_samples(random), str(random.choice(['zstd', 'none', 'lz4'])))
    else:
        bag.mkdir()
        for name, content in whole_bag().items():
            chosen = random.random() < 0.7
            text = name.endswith('.yaml') and random.random() < 0.7
            (bag / name).write_bytes(
                content if not chosen else damaged_text(random, content.decode()) if text
                else damaged_bytes(random, content))
    out = ['--out', str(place.out)]
    calls = (['info', str(bag)], ['repair', str(bag), *out],
             ['estimate', str(bag), '--arm', ARM, *out],
             ['calibrate', str(bag), '--arm', ARM, *out],
             ['diagnose', str(bag), '--arm', ARM, *out])
    if random.random() < 0.02:              # seconds where the bag is right: it draws much
        return ['compare', str(bag), str(bag), *out, '--align', 'offset']
    return list(calls[random.integers(len(calls))])


def arguments(random: Random, place: Place) -> list[str]:
    """Return a call with words that cannot be; none of them names something to work on."""
    calls = (['simulate', '--arm', ARM, '--motion', 'rich', '--duration', '0'],
             ['estimate', 'missing', '--arm', ARM], ['import', 'missing.csv', '--map', 'm.yaml'],
             ['calibrate', 'missing', '--arm', ARM], ['diagnose', 'missing', '--arm', ARM],
             ['plan', '--arm', ARM, '--between', 'payload', 'nothing'],
             ['compare', 'missing', 'missing'], ['reproduce', 'nothing'], ['repair', 'missing'],
             ['info', 'missing'])
    words = [*calls[random.integers(len(calls))], '--out', str(place.out)]
    for _ in range(int(random.integers(1, 4))):
        at = int(random.integers(1, len(words) + 1))
        words[at:at + int(random.integers(2))] = [str(WORDS[random.integers(len(WORDS))])]
    if words[0] == 'reproduce':             # without a figure it makes all
        words.append('nothing')
    # Paths that commands may write to stay in the folder of this input.
    return [words[0], *(place.folder.joinpath('others').as_posix() if before == '--out'
                        and not word.startswith(('-', str(place.folder))) and word.strip()
                        else word for before, word in zip(words, words[1:]))]


KINDS: dict[str, Callable[[Random, Place], list[str]]] = {
    'models': model, 'maps': column_map, 'tables': table, 'effects': effects, 'bags': bag,
    'arguments': arguments}


def damaged_text(random: Random, text: str) -> bytes:
    """Return text with some words, lines or characters changed."""
    for _ in range(int(random.integers(1, 4))):
        lines = text.split('\n')
        at = int(random.integers(len(lines)))
        scalar = SCALARS[random.integers(len(SCALARS))]
        words = lines[at].split(' ')
        match int(random.integers(7)):
            case 0:
                del lines[at]
            case 1:
                lines.insert(at, lines[int(random.integers(len(lines)))])
            case 2:
                lines[at] = ' ' * int(random.integers(9)) + lines[at].strip()
            case 3:
                lines[at] = f'{lines[at].partition(":")[0]}: {scalar}'
            case 4:
                lines.insert(at, scalar)
            case 5:
                lines[at] = lines[at][:int(random.integers(len(lines[at]) + 1))]
            case _:
                words[int(random.integers(len(words)))] = scalar
                lines[at] = ' '.join(words)
        text = '\n'.join(lines)
    content = text.encode(errors='surrogateescape')
    return damaged_bytes(random, content) if random.random() < 0.1 else content


def damaged_bytes(random: Random, content: bytes) -> bytes:
    """Return bytes that are flipped, cut, repeated or put in."""
    changed = bytearray(content)
    for _ in range(int(random.integers(1, 6))):
        at, span = int(random.integers(len(changed) + 1)), int(random.integers(1, 9))
        match int(random.integers(5)):
            case 0:
                changed[at:at + 1] = bytes(value ^ 1 << span % 8 for value in changed[at:at + 1])
            case 1:
                changed[at:at + span] = random.bytes(span)
            case 2:
                changed[at:at] = changed[:64 * span]
            case 3:
                changed[at:at + span] = b'\xff' * span
            case _:
                del changed[at:at + span]
    return bytes(changed[:int(random.integers(len(changed) + 1))] if random.random() < 0.2
                 else changed)


def strange_samples(random: Random) -> JointSamples:
    """Return joint states with stamps, readings or names that no robot has."""
    good = samples()
    stamps, position = good.stamps.copy(), good.position.copy()
    effort, names = good.effort.copy(), list(good.names)
    at = int(random.integers(1, len(stamps)))
    odd = float(random.choice([1e308, -1e308, 1e20, np.nan, np.inf, 1e-300]))
    match int(random.integers(8)):
        case 0:
            stamps = np.full_like(stamps, int(random.integers(3)))
        case 1:
            stamps = stamps[0] + np.arange(len(stamps)) * int(random.integers(1, 900))
        case 2:
            stamps[at:] += int(10.0 ** random.uniform(9.0, 18.0))
        case 3:
            stamps[at:] -= min(int(10.0 ** random.uniform(6.0, 9.0)), int(stamps[0]))
        case 4:
            position[at:, int(random.integers(4))] = odd
        case 5:
            position[at], effort[at] = odd, odd
        case 6:
            names[int(random.integers(4))] = str(random.choice(['\x1b[2J', '', 'joint1', 'a\n']))
        case _:
            stamps = random.permutation(stamps)
    return JointSamples(stamps, tuple(names), position, good.velocity, effort)


@cache
def samples() -> JointSamples:
    """Return joint states of the arm in motion."""
    time = 1e-3 * np.arange(SAMPLES)
    ratios = [joint.ratio for joint in read_arm(ARM).joints]
    link = np.stack([np.sin(3.0 * time), np.cos(2.0 * time)], axis=1)
    position = np.concatenate([link, link * ratios], axis=1)
    effort = np.concatenate([np.full((SAMPLES, 2), np.nan), 0.01 * link], axis=1)
    return JointSamples(10 ** 9 + 10 ** 6 * np.arange(SAMPLES),
                        ('joint1', 'joint2', 'joint1_motor', 'joint2_motor'), position,
                        np.full((SAMPLES, 4), np.nan), effort)


@cache
def whole_bag() -> dict[str, bytes]:
    """Return the files of a bag that is right."""
    with TemporaryDirectory() as folder:
        _write_bag(Path(folder) / 'bag', samples(), 'none')
        return {file.name: file.read_bytes() for file in (Path(folder) / 'bag').iterdir()}


def _write_bag(path: Path, content: JointSamples, compression: str) -> None:
    with BagWriter(path, {}, files=Files(compression)) as writer:
        writer.write_joint_states(JOINT_STATES, content)


@cache
def tables() -> dict[str, bytes]:
    """Return a table that is right, in every format."""
    held = samples()
    columns = {'t': held.stamps * 1e-9, 'q1': held.position[:, 0], 'q2': held.position[:, 1],
               'qm1': held.position[:, 2], 'qm2': held.position[:, 3],
               'tau1': held.effort[:, 2], 'tau2': held.effort[:, 3]}
    rows = '\n'.join(','.join(f'{value:.6g}' for value in row)
                     for row in zip(*(column[:40] for column in columns.values())))
    npz, mat, parquet = io.BytesIO(), io.BytesIO(), io.BytesIO()
    np.savez(npz, **columns)
    savemat(mat, columns)
    pyarrow.parquet.write_table(pa.table(columns), parquet)
    return {'csv': f'{",".join(columns)}\n{rows}\n'.encode(), 'npz': npz.getvalue(),
            'mat': mat.getvalue(), 'parquet': parquet.getvalue()}
