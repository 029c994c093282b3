"""Two bags laid over each other: clocks are found again, and so is what was hidden in one."""

from html.parser import HTMLParser
import json
from pathlib import Path

from hda_arm_sim.foundation.arrays import Array
from hda_msgs_json.bag import BagWriter
from hda_msgs_json.samples import JointSamples, WrenchSamples
from hda_msgs_json.topics import JOINT_STATES, TIP_WRENCH
from hda_torque_estimator.cli import main
from hda_torque_estimator.comparison.align import align, Alignment
from hda_torque_estimator.comparison.compare import compare, Comparison, Difference
from hda_torque_estimator.comparison.page import page
from hda_torque_estimator.comparison.plots import figures
from hda_torque_estimator.comparison.report import sentences
from hda_torque_estimator.comparison.signals import bag_of, BagSignals, CompareError
import numpy as np
import pytest

EPOCH = 1_700_000_000_000_000_000
NOISE = 2e-4
RATE = 500.0
DURATION = 20.0
SEEDS = range(20)
OFFSET = 1.3
TIME = np.arange(round(20.0 * RATE)) / RATE
POSITION, OTHER = 'joint_states/joint1/position', 'joint_states/joint2/'


def motion(seed: int, time: Array) -> Array:
    """Return two angles [rad] that move in their own ways, (k, 2)."""
    random = np.random.default_rng(seed)
    angle = np.zeros((len(time), 2))
    for column in (0, 1):
        for frequency in random.uniform(0.1, 1.5, 6):
            angle[:, column] += random.uniform(0.05, 0.2) * np.sin(
                2.0 * np.pi * (frequency * time + random.random()))
    return angle


def bag(seed: int, *, noise_seed: int = 0, offset: float = 0.0, drift: float = 0.0,
        rate: float = RATE, noise: float = NOISE, added: Array | None = None) -> BagSignals:
    """Return a recording of a motion that began `offset` before it, by a clock that drifts."""
    random = np.random.default_rng((seed, noise_seed))
    time = np.arange(round(DURATION * rate)) / rate
    position = motion(seed, offset + (1.0 + drift) * time)
    position += noise * random.normal(size=position.shape)
    if added is not None:
        position[:, 0] += added
    velocity = np.gradient(position, axis=0) * rate
    stamps = EPOCH + np.round(1e9 * time).astype(np.int64)
    return bag_of(f'bag{noise_seed}', {'/joint_states': JointSamples(
        stamps, ('joint1', 'joint2'), position, velocity, np.full_like(position, np.nan))})


def aligned(first: BagSignals, second: BagSignals, mode: str = 'drift') -> Alignment:
    """Return the alignment by all common signals."""
    return align(first, second, sorted(first.signals.keys() & second.signals.keys()), mode)


def clocks(seed: int) -> tuple[float, float]:
    """Return an offset [s] and a drift that no two seeds share."""
    random = np.random.default_rng((seed, 99))
    return float(random.uniform(-4.0, 4.0)), float(random.uniform(-3e-4, 3e-4))


def test_offset_and_drift_lie_within_their_intervals_as_often_as_said():
    inside = np.zeros(2)
    for seed in SEEDS:
        offset, drift = clocks(seed)
        start = max(0.0, -offset)
        found = aligned(bag(seed, noise_seed=1, offset=start),
                        bag(seed, noise_seed=2, offset=start + offset, drift=drift))
        truth = np.array([offset + drift * found.middle, drift])
        half = found.quantile * np.sqrt(np.diag(found.covariance))
        missed = np.abs(np.array([found.shift, found.drift]) - truth)
        inside += missed <= half
        assert (missed < 3.0 * half).all()
        assert half[0] < 0.005 / RATE
        assert half[1] < 2e-6
    assert (inside >= 0.75 * len(SEEDS)).all()


@pytest.mark.parametrize('rate', [125.0, 1000.0])
def test_an_offset_is_found_between_recordings_of_two_rates(rate):
    found = aligned(bag(3, noise_seed=1), bag(3, noise_seed=2, offset=2.34567, rate=rate),
                    'offset')
    assert found.drift == 0.0
    assert found.offset == pytest.approx(2.34567, abs=2e-4)


def test_a_copy_lies_exactly_over_the_recording():
    found = aligned(bag(5), bag(5))
    assert abs(found.offset) < 1e-9
    assert abs(found.drift) < 1e-9


def test_times_go_to_the_other_bag_and_back():
    found = Alignment('drift', 1.5, 2e-3, 7.0, np.zeros((2, 2)), 0.0)
    time = np.linspace(0.0, 20.0, 5)
    np.testing.assert_allclose(found.to_second(found.to_first(time)), time, atol=1e-12)
    assert found.to_first(np.zeros(1))[0] == pytest.approx(found.offset)


def still_but_once(seed: int) -> BagSignals:
    """Return a recording of a single short move, 6 s after its start or 7 s."""
    move = 0.5 * np.tanh((TIME - 6.0 - seed) / 0.1)
    move += 1e-4 * np.random.default_rng(seed).normal(size=len(TIME))
    stamps = EPOCH + np.round(1e9 * TIME).astype(np.int64)
    return bag_of('once', {'js': JointSamples(
        stamps, ('joint1',), move[:, None], *np.full((2, len(TIME), 1), np.nan))})


def test_a_single_move_determines_an_offset():
    found = aligned(still_but_once(0), still_but_once(1), 'offset')
    assert found.offset == pytest.approx(-1.0, abs=1e-4)


def test_a_periodic_motion_is_laid_with_the_most_overlap_and_says_so():
    position = np.sin(np.pi * TIME)[:, None]
    stamps = EPOCH + np.round(1e9 * TIME).astype(np.int64)
    bags = [bag_of('sine', {'js': JointSamples(stamps[::step], ('joint1',), position[::step],
                                               *np.full((2, len(TIME[::step]), 1), np.nan))})
            for step in (1, 10)]
    found = aligned(*bags)
    assert found.offset == pytest.approx(0.0, abs=1e-4)
    assert {round(rival) for rival in found.rivals} >= {-4, -2, 2, 4}


def test_stamps_are_believed_when_asked():
    found = aligned(bag(1), bag(2), 'none')
    assert (found.offset, found.drift) == (0.0, 0.0)


def test_other_motions_are_not_aligned():
    with pytest.raises(CompareError, match='cannot be aligned.*--align none'):
        aligned(bag(1), bag(2))


def test_a_drift_that_no_clock_has_is_not_believed():
    move = np.tanh((TIME - 10.0) / 0.3), np.tanh((TIME - 10.0) / 0.4)
    bags = [bag_of('once', {'js': JointSamples(
        EPOCH + np.round(1e9 * TIME).astype(np.int64), ('joint1',), angle[:, None],
        *np.full((2, len(TIME), 1), np.nan))}) for angle in move]
    with pytest.raises(CompareError, match='with a drift of .* %'):
        aligned(*bags)


@pytest.mark.parametrize(('drift', 'doubted'), [(1e-4, False), (2e-3, True)])
def test_a_drift_that_clocks_seldom_have_is_doubted(drift, doubted):
    found = compare(bag(1, noise_seed=1), bag(1, noise_seed=2, drift=drift), 'drift')
    assert any('seldom drift' in line for line in sentences(found)) == doubted


def test_bags_that_stand_still_are_not_aligned():
    still = [bag_of('still', {'js': JointSamples(
        EPOCH + np.arange(2000) * 2_000_000, ('joint1',), *(
            np.random.default_rng(seed).normal(size=(3, 2000, 1))))}) for seed in (1, 2)]
    with pytest.raises(CompareError, match='none of the 3 common signals moves'):
        aligned(*still)


def compared(seed: int, added: Array | None = None, mode: str = 'drift') -> Comparison:
    """Return two recordings of one motion, something added to `POSITION` of the second."""
    return compare(bag(seed, noise_seed=1),
                   bag(seed, noise_seed=2, offset=OFFSET, drift=1e-4, added=added), mode)


def position_of(found: Comparison) -> Difference:
    """Return the difference of the angle that something was added to."""
    return next(each for each in found.differences if each.name == POSITION)


@pytest.mark.parametrize('seed', SEEDS)
def test_nothing_is_reported_between_two_noisy_copies(seed):
    found = compared(seed)
    assert len(found.differences) == 4
    assert [each.name for each in found.differences if each.is_significant] == []
    assert position_of(found).rms == pytest.approx(np.sqrt(2.0) * NOISE, rel=0.1)


@pytest.mark.parametrize('size', [4.0, 50.0])
@pytest.mark.parametrize('seed', SEEDS[:6])
def test_a_step_is_found_where_it_was_hidden(seed, size):
    found = compared(seed, np.where(TIME > 7.0, size * NOISE, 0.0))
    assert found.differences[0].name == POSITION
    assert position_of(found).start == pytest.approx(OFFSET + 7.0, abs=0.02)
    assert [each.start for each in found.differences if each.name.startswith(OTHER)] == [None] * 2


def test_a_slow_departure_is_found_once_it_leaves_the_noise():
    ramp = np.maximum(TIME - 7.0, 0.0) * 10.0 * NOISE
    start = position_of(compared(2, ramp)).start
    assert start is not None
    assert OFFSET + 7.05 < start < OFFSET + 7.6


def test_what_comes_and_goes_within_noise_has_no_start():
    spike = np.where(np.abs(TIME - 9.0) < 0.01, 100.0 * NOISE, 0.0)
    found = position_of(compared(2, spike))
    assert found.start is None
    assert found.largest > 90.0 * NOISE


def test_another_start_is_found_from_the_first_common_moment():
    found = position_of(compared(4, np.full(len(TIME), 0.5), 'offset'))
    assert found.start == pytest.approx(OFFSET, abs=2.0 / RATE)
    assert found.mean == pytest.approx(0.5, rel=1e-3)


@pytest.mark.parametrize('frequency', [11.7, 37.3, 120.0])
def test_a_line_is_found(frequency):
    line = 2.0 * NOISE * np.sin(2.0 * np.pi * frequency * TIME)
    found, = position_of(compared(1, line)).spectrum.lines
    assert found.frequency == pytest.approx(frequency, abs=0.03)
    assert found.amplitude == pytest.approx(2.0 * NOISE, rel=0.1)


def test_gaps_and_nan_leave_common_times_out_and_nothing_else():
    position = motion(1, TIME)
    position[1000:1500, 0] = np.nan
    kept = np.r_[0:4000, 4250:len(TIME)]
    broken = bag_of('broken', {'joint_states': JointSamples(
        EPOCH + np.round(1e9 * TIME[kept]).astype(np.int64), ('joint1', 'joint2'),
        position[kept], *np.full((2, len(kept), 2), np.nan))})
    whole = bag(1, noise=0.0)
    found = compare(whole, broken, 'none')
    lengths = {each.name: len(each.laid.time) for each in found.differences}
    assert lengths == {POSITION: len(TIME) - 750, OTHER + 'position': len(TIME) - 250}
    assert all(each.largest < 1e-9 for each in found.differences)
    assert broken.sampling['joint_states'].lost == 250
    assert set(found.only_first) == {'joint_states/joint1/velocity', OTHER + 'velocity'}


def test_wrenches_are_compared_in_their_units():
    stamps = EPOCH + np.arange(1000) * 10_000_000
    values = np.full((1000, 3), np.nan)
    values[:, 0] = np.sin(np.arange(1000) / 50.0)
    bags = [bag_of(name, {'tip': WrenchSamples(stamps, 'base', scale * values, values)})
            for name, scale in (('one', 1.0), ('two', 1.2))]
    found = {each.name: each for each in compare(*bags, 'none').differences}
    assert {name: each.unit for name, each in found.items()} == {
        'tip/force.x': 'N', 'tip/torque.x': 'N*m'}
    assert found['tip/force.x'].relative == pytest.approx(0.2, rel=0.01)
    assert found['tip/torque.x'].start is None


def test_numbers_beyond_sense_are_left_out_and_stamps_beyond_sense_refused():
    position, stamps = motion(1, TIME), EPOCH + np.round(1e9 * TIME).astype(np.int64)
    position[500, 0], position[600, 0] = 1e300, np.inf
    rest = np.full((2, *position.shape), np.nan)
    found = compare(bag_of('wild', {'joint_states': JointSamples(
        stamps, ('joint1', 'joint2'), position, *rest)}), bag(1), 'drift')
    assert position_of(found).largest < 10.0 * NOISE
    stamps[5000:] += 2**61
    with pytest.raises(CompareError, match='stamps span 2.306e.09 s at 500 Hz'):
        bag_of('wild', {'joint_states': JointSamples(
            stamps, ('joint1', 'joint2'), position, *rest)})


def test_bags_without_a_common_signal_or_time_are_refused():
    one, two = bag(1), bag_of('two', {'tip': WrenchSamples(
        EPOCH + np.arange(100) * 10_000_000, 'base', *np.zeros((2, 100, 3)))})
    with pytest.raises(CompareError, match='no signal in common: .* and 1 more.*tip/force.x'):
        compare(one, two, 'none')
    late = BagSignals('late', EPOCH + 10**12, one.signals, one.sampling)
    with pytest.raises(CompareError, match='do not overlap in time.* 1000.000 s'):
        compare(one, late, 'none')
    with pytest.raises(CompareError, match='empty has no signal to compare'):
        bag_of('empty', {})


def written(path: Path, *, noise_seed: int, offset: float = 0.0, wrench: bool = False) -> str:
    """Write a recording, its stamps a day apart from those of others, and return its path."""
    position = motion(6, offset + TIME)
    position += NOISE * np.random.default_rng(noise_seed).normal(size=position.shape)
    position[TIME > 8.0, 0] += 20.0 * NOISE if offset else 0.0
    stamps = EPOCH + noise_seed * 86_400_000_000_000 + np.round(1e9 * TIME).astype(np.int64)
    with BagWriter(path, {}) as bag:
        bag.write_joint_states(JOINT_STATES, JointSamples(
            stamps, ('joint1', 'joint2'), position, *np.full((2, *position.shape), np.nan)))
        if wrench:
            bag.write_wrenches(TIP_WRENCH, WrenchSamples(
                stamps, 'base', *np.zeros((2, len(stamps), 3))))
    return str(path)


@pytest.fixture(scope='module')
def pair(tmp_path_factory: pytest.TempPathFactory) -> tuple[str, str]:
    """Return two bags of one motion; the second begins later and steps."""
    place = tmp_path_factory.mktemp('bags')
    return (written(place / 'one', noise_seed=1, wrench=True),
            written(place / 'two', noise_seed=2, offset=OFFSET))


def test_command_writes_what_it_says(pair, tmp_path, capsys):
    out = tmp_path / 'deep' / 'out'
    assert main(['compare', *pair, '--out', str(out), '--json']) == 0
    report = json.loads(capsys.readouterr().out)
    assert report == json.loads((out / 'compare.json').read_text())
    assert report['schema'] == 'hda.compare/1'
    offset = report['alignment']['offset']
    assert offset['low'] < OFFSET < offset['high']
    assert [each['name'] for each in report['signals']] == [POSITION, OTHER + 'position']
    assert report['signals'][0]['start'] == pytest.approx(OFFSET + 8.0, abs=0.01)
    assert report['signals'][1]['start'] is None
    assert len(report['only_in_first']) == 6
    assert report['first']['topics']['joint_states'] == {
        'samples': len(TIME), 'rate': RATE, 'lost': 0, 'longest_gap': 1.0 / RATE}


def test_table_lists_what_differs_first(pair, tmp_path, capsys):
    assert main(['compare', *pair, '--out', str(tmp_path / 'out')]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == '1 of 2 common signals differs beyond noise, first at 9.302 s.'
    rows = [line.split()[0] for line in lines if line.startswith('  joint_states')]
    assert rows == [POSITION, OTHER + 'position']
    assert any('only in the first:' in line for line in lines)


def complaint(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    """Return the one line of a comparison that cannot be made."""
    assert main(['compare', *words]) == 2
    said = capsys.readouterr()
    assert said.out == ''
    assert len(said.err.splitlines()) == 1
    return said.err


def test_bad_input_is_one_line_and_leaves_nothing(pair, tmp_path, capsys):
    out = tmp_path / 'out'
    torn = tmp_path / 'torn.mcap'
    torn.write_bytes(b'no bag')
    for bags, says in (((pair[0], str(tmp_path / 'nowhere')), 'nowhere'),
                       ((str(torn), pair[1]), 'torn.mcap'),
                       ((*pair, '--align', 'none'), 'do not overlap')):
        assert says in complaint(capsys, *bags, '--out', str(out))
    assert list(tmp_path.iterdir()) == [torn]
    assert 'exists' in complaint(capsys, *pair, '--out', str(torn))
    assert 'cannot be written' in complaint(capsys, *pair, '--out', str(torn / 'out'))
    assert torn.read_bytes() == b'no bag'


class Outline(HTMLParser):
    """Collect the text of a page, its tags, and what it would load."""

    def __init__(self, text: str) -> None:
        """Read a page."""
        super().__init__()
        self.texts: list[str] = []
        self.tags: list[str] = []
        self.loads: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Keep a tag and its links that leave the page."""
        self.tags.append(tag)
        self.loads += [value or '' for name, value in attrs
                       if name in ('src', 'href', 'xlink:href') and value[:1] != '#']

    def handle_data(self, data: str) -> None:
        """Keep a text."""
        self.texts.append(data)


def test_page_shows_every_signal_and_loads_nothing(pair, tmp_path, capsys):
    out = tmp_path / 'out'
    assert main(['compare', *pair, '--out', str(out)]) == 0
    page = (out / 'compare.html').read_text(encoding='utf-8')
    shown = Outline(page.replace('<wbr>', ''))      # long names may break
    assert {POSITION, OTHER + 'position', 'tip/wrench/force.x'} <= set(shown.texts)
    assert shown.tags.count('figure') == 1
    assert shown.loads == []
    assert sorted(path.name for path in out.iterdir()) == [
        'compare.html', 'compare.json', 'signal_1.png']


def test_names_on_the_page_are_text():
    position = motion(1, TIME)
    name = '<b>"R&D"</b> $5'
    bags = [bag_of(name, {'joint_states': JointSamples(
        EPOCH + np.round(1e9 * TIME).astype(np.int64), (name,), scale * position[:, :1],
        *np.full((2, len(TIME), 1), np.nan))}) for scale in (1.0, 1.1)]
    found = compare(*bags, 'none')
    shown = Outline(page(found, '<0>'))
    assert f'joint_states/{name}/position' in shown.texts
    assert 'b' not in shown.tags


def test_alike_signals_are_drawn_too():
    assert len(figures(compared(1))) == 2
