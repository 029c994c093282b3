"""
Diagnose a measurement: from raw readings to causes, an extended arm, and its gain on unseen data.

Fits see the training stretches only. What they claim is confirmed by simulation on the held-out
stretches; a cause that does not gain there is not named.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects import effect_named, EFFECTS, Site
import numpy as np

from .assumptions import AsRecorded, EFFECTIVE, twin_of
from .balances.healthy_twin import noise_of, torque_noise_of
from .balances.led import held_against, third_witnesses, why_led
from .balances.stand_in import with_stand_in
from .detectability.excitation import nothing_seen, remarks, shows_too_little, smallest_sizes
from .detectability.one_sided import one_sided
from .detectability.oscillating_loops import oscillating_loops
from .detectability.slow_rate import FAST, rate_hides
from .findings.certainty import probability, verdict_probability
from .findings.gains import gains, METRIC
from .findings.origin import Origin, RecordingFacts, RecordingPart
from .findings.report import Alike, at_place, Diagnosis, Finding, TotalGain
from .fitting.alignment import aligned, is_aligned
from .fitting.fit import Fit, Fitter
from .fitting.hypotheses import HYPOTHESES, left_aside
from .fitting.nuisance import is_of_log
from .fitting.starting_points import split_at_contacts
from .judging.candidates import with_sizes
from .judging.contradicted_sensors import contradicted, in_sensors_alone
from .judging.discrepancy_search import search_beside_discrepancy
from .judging.goodness_of_fit import GoodnessOfFit
from .judging.listed_causes import told, too_small
from .judging.search import is_stuck, search, SearchResult, without_noise
from .judging.verdict import residuals
from .readings.raw_readings import (extended_by, RAW_EFFECTS, raw_findings, raw_readings,
                                    raw_total, RawReadings)
from .reporting.next_steps import next_steps
from .reporting.unexplained import unexplained
from .validation import Grounds, proven
from ..least_squares.term import Place
from ..measurements.effort import as_held
from ..measurements.measurement import Measurement
from ..measurements.running_clock import inside, Spans, split
from ..significance import MATERIAL
from ..significance import STILL

# Numerics; choices unless stated otherwise.
_ROUNDS = 2             # of searches, while zeros of recordings, stretches or noise move
_LAST_NOISE = 1         # seed of the twin of the arm that was found


class Conclusion(NamedTuple):
    """A diagnosis, the arm extended by it, and what it rests on."""

    diagnosis: Diagnosis
    extended: Arm
    evidence: Grounds | None       # None where nothing moved


def diagnose(measurement: Measurement, arm: Arm, *, names: Sequence[str] | None = None,
             about: Sequence[Place] = (), origin: Origin = Origin(),
             notify: Callable[[str], None] = lambda text: None) -> Conclusion:
    """
    Return what the simulation of `arm` gets wrong about a measurement that passed the gate.

    Several recordings of the arm, brought together by `alignment.together`, are one measurement;
    `origin` has their names. `notify` hears what is being done. Of an arm without a model of its
    links the gears are judged alone: what the motors give against what the gears twist.
    """
    given, arm, measurement = arm, with_stand_in(arm), as_held(measurement, arm)
    training, held_out = split(measurement)
    facts = _facts(measurement, arm, training, held_out, origin.sources)
    if (np.ptp(measurement.reading[:, :, 1], axis=0) < STILL).all():
        return Conclusion(_unmoved(facts, arm, origin), given, None)
    unloaded = why_led(measurement, given)
    names, aside = _sought(measurement, arm, names, unloaded)
    notify('looking at the raw readings')
    raw = _of_gears(raw_readings(measurement, arm, names, training), bool(unloaded))
    fitter, found, training, held_out, scales = _scaled(raw, names, training, held_out, notify)
    fitter, found, plain = _reconsidered(fitter, found, names, notify)
    first = found.first
    beside = search_beside_discrepancy(fitter, found, names, notify)
    twin = twin_of(beside.fitter.balancer, fitter.on(beside.found.last.terms), _LAST_NOISE,
                   torque_noise_of(fitter.noise, plain, fitter.balancer, arm))
    proof = proven(beside.fitter, beside.found, twin, arm, held_out, notify)
    judged, pairs = proof.judged.with_rest(beside.channels), proof.pairs
    evidence = proof.evidence.as_measured(fitter) if beside.nameless else proof.evidence
    shown = raw_findings(raw, measurement, fitter.balancer, arm, evidence.extended, held_out)
    fitted = (*shown, *proof.findings)
    named, unsure = told(fitted)
    evidence = evidence.without({(one.effect, one.joint) for one in unsure})
    total = raw_total(shown) if named and named == shown else _total(evidence)
    nameless = len(evidence.fit.accepted) < len(proof.evidence.fit.accepted)
    left = judged.unexplained.any() or nameless
    rest = unexplained(fitter, evidence.fit, is_sure=True) if left else None
    notify('finding the smallest size of every effect that would have shown')
    sizes = smallest_sizes(beside.fitter, proof.found, proof.kept, raw, training, names)
    verdict, limit = _verdict(judged, named, bool(pairs), bool(unsure)), None
    if verdict == 'no_discrepancy' and shows_too_little(sizes, arm, about):
        verdict, limit = 'insufficient_excitation', _limit(evidence, names, about)
    diagnosis = Diagnosis(
        verdict, named, with_sizes(fitter, evidence.fit, pairs), rest,
        tuple(one.row() for one in sizes), total,
        residuals(fitter, first, evidence.fit, inside(fitter.balancer.time, held_out)),
        replace(facts, training=training, held_out=held_out), origin.arm_file, origin.version, 0.0,
        (*facts.remarks, *proof.remarks, *_not_gaining(raw, shown),
         *(cause.sentence() for cause in beside.nameless), *scales,
         *in_sensors_alone(fitter, evidence.fit), *aside, *_between(fitter.balancer.measurement),
         *remarks(sizes, arm, about, FAST if limit == 'rate' else None)), limited_by=limit,
        probability=_probability(verdict, named, pairs, judged),
        listed=(*unsure, *too_small(fitter, found, _places(fitted, pairs))))
    diagnosis = replace(diagnosis, steps=next_steps(diagnosis))
    model = replace(_model(evidence, raw, named, pairs), links=given.links)
    return Conclusion(diagnosis, model, evidence)


def _total(evidence: Grounds) -> TotalGain:
    """Return what all causes gain together on held-out stretches."""
    return gains(evidence.fitter.balancer, evidence.twin, evidence.before, evidence.extended,
                 evidence.held_out).total()


def _places(fitted: Sequence[Finding], pairs: Sequence[Alike]) -> set[Place]:
    """Return the places of all causes that were fitted."""
    return {*((one.effect, one.joint) for one in fitted),
            *(place for pair in pairs for place in pair.effects)}


def _limit(evidence: Grounds, names: Sequence[str], about: Sequence[Place]) -> str:
    """Return what kept a recording from showing what was asked for."""
    hidden = rate_hides(evidence.fitter.balancer, evidence.extended, names, about, EFFECTIVE)
    return 'rate' if hidden else 'motion'


def _of_gears(raw: RawReadings, led: bool) -> RawReadings:
    """Return readings whose links are led, or not."""
    return raw._replace(measurement=replace(raw.measurement, led=led))


def _sought(measurement: Measurement, arm: Arm, names: Sequence[str] | None,
            unloaded: str) -> tuple[list[str], tuple[str, ...]]:
    """Return which effects are looked for, all unless some are named, and why others are not."""
    names = sought_effects() if names is None else names
    planar = left_aside(arm, names)
    if unloaded:
        of_links = [name for name in names if effect_named(name).site is Site.LINK]
        why = [f'{unloaded}, so only the gears are judged, '
               'and nothing is said of the links']
        led = replace(measurement, led=True)
        why += [*held_against(led), *one_sided(led)]
        return [name for name in names if name not in planar and name not in of_links], tuple(why)
    why = [f'of a chain of links {", ".join(planar)} are not looked for'] if planar else []
    why += third_witnesses(measurement)
    return [name for name in names if name not in planar], tuple(why)


def _model(evidence: Grounds, raw: RawReadings, findings: Sequence[Finding],
           pairs: Sequence[Alike]) -> Arm:
    """Return the arm with what is named, the first of what looks alike, and all tolerances."""
    named = {(one.effect, one.joint) for one in findings}
    named.update(place for pair in pairs for place in pair.effects)
    fit = evidence.fit
    model = evidence.fitter.on([
        *(term for term in fit.accepted if term.place in named),
        *(term for term in fit.nuisance if not is_of_log(term))])
    return extended_by([cause for cause in raw.causes
                        if (cause.effect.name, cause.joint) in named], model)


def _not_gaining(raw: RawReadings, shown: Sequence[Finding]) -> Iterator[str]:
    """Yield of which causes of raw readings nothing is said, and why."""
    named = {(one.effect, one.joint) for one in shown}
    for name, joint in ((cause.effect.name, cause.joint) for cause in raw.causes):
        if (name, joint) not in named:
            yield (f'{at_place(name, joint)} is not named: readings show it, but it gains '
                   'nothing on stretches that no fit has seen')


def _between(measurement: Measurement) -> Iterator[str]:
    """Yield what a log does not know of its commands, and of the motion between its samples."""
    if measurement.untold:
        yield (f'commands were recorded every {1e3 * measurement.untold:.3g} ms and not in '
               'between: a lag or a delay of up to half of that is not named')
    if measurement.blind:
        period = 1e3 * measurement.parts * measurement.dt
        yield (f'for {len(measurement.blind) * measurement.dt:.2g} s samples every {period:.3g} '
               'ms do not show how the arm moved, as in long gaps, where it shakes or where '
               'encoders err: nothing is judged there')


def _facts(measurement: Measurement, arm: Arm, training: Spans, held_out: Spans,
           sources: Sequence[str]) -> RecordingFacts:
    """Return what is diagnosed, and of several recordings where each begins."""
    dt, pieces = measurement.dt, measurement.pieces()
    parts = [RecordingPart(source, piece.start * dt, (piece.stop - piece.start) * dt)
             for source, piece in zip(sources, pieces)]
    return RecordingFacts(measurement.duration, len(measurement.command), 1.0 / dt, training,
                          held_out, tuple(parts) if len(pieces) > 1 else (),
                          oscillating_loops(measurement, arm))


def _searched(raw: RawReadings, names: Sequence[str], training: Spans, held_out: Spans,
              notify: Callable[[str], None]) -> tuple[Fitter, SearchResult, Spans, Spans]:
    """
    Return what was found, with the zeros of several recordings as it has them.

    What is assumed of them is asked again of the arm that was found, and only of that where
    friction builds up. A contact in held-out stretches may show only when what was found is known.
    """
    arm, turns = raw.arm, tuple[int, ...]()
    for _ in range(_ROUNDS):
        raw = raw._replace(measurement=aligned(raw.measurement, arm))
        recorded = AsRecorded.of(raw, training)
        if arm is not raw.arm:                  # a cause may be what is loud at turns
            turns = tuple(sorted({*turns, *recorded.turning(arm)}))
        fitter = recorded.fitter(turns, arm)
        seen, unseen = _split(fitter, arm, names, training, held_out)
        fitter = replace(fitter, rows=inside(fitter.balancer.time, seen))
        found = search(fitter, names, notify=notify)
        if turns and is_stuck(fitter, found):
            fitter, found = _without_turns(recorded.without_turns(fitter, arm), fitter, found,
                                           names)
        arm = fitter.on(found.last.terms)
        if (is_aligned(fitter.balancer, arm, fitter.noise) and recorded.bears_out(fitter, arm)
                and (seen != training or _split(fitter, arm, names, seen, unseen)[0] == seen)):
            break
    return fitter, found, seen, unseen


def _scaled(raw: RawReadings, names: Sequence[str], training: Spans, held_out: Spans,
            notify: Callable[[str], None]) -> tuple[Fitter, SearchResult, Spans, Spans,
                                                    tuple[str, ...]]:
    """
    Return what `_searched` does, with the scales of sensors as others have them, and remarks.

    Where others contradict the gain of a sensor, all is looked for again without it.
    """
    searched = _searched(raw, names, training, held_out, notify)
    gains = contradicted(*searched[:2])
    if not gains:
        return *searched, ()
    again = raw._replace(measurement=raw.measurement.rescaled(gains))
    return *_searched(again, names, training, held_out, notify), tuple(
        f'the reference torque of {label} shows {1.0 + gain:.3g} times what motor, torsion and '
        'links agree on: its scale tells nothing, its course does'
        for label, gain in gains.items())


def _reconsidered(fitter: Fitter, found: SearchResult, names: Sequence[str],
                  notify: Callable[[str], None]) -> tuple[Fitter, SearchResult, Array]:
    """
    Return a fitter with the noise beside the causes, what it finds, and what resolution leaves.

    A wrong extension makes noise of its own, so the fitter's noise only falls. Where it falls far,
    it had hidden something. A cause that is not kept has shown nothing of the noise: a lag makes
    commands smoother, and what they leave quieter. So the noise is asked again without it.
    """
    taken, begun = fitter.noise, found.last
    for _ in range(_ROUNDS):
        before = found.last
        noise, plain = noise_of(fitter.balancer,
                                fitter.as_noisy(before) if before.accepted else fitter.arm)
        fitter = replace(fitter, noise=np.minimum(taken, noise))
        if (taken ** 2 > (1.0 + MATERIAL ** 2) * fitter.noise ** 2).any():
            found = search(fitter, names, found, notify)
        elif before is not begun:
            found = found.refitted(fitter)
        found = without_noise(fitter, found)
        if _placed(before) <= _placed(found.last):
            break
    return *_with_torque_noise(fitter, found, plain), plain


def _with_torque_noise(fitter: Fitter, found: SearchResult,
                       plain: Array) -> tuple[Fitter, SearchResult]:
    """
    Return a fitter with the noise of torques as it is with what was found, and that found by it.

    Torques that scatter move the links. Where a balance lacks inertia, that motion takes a part
    of them away, and they seemed quieter. Noise of readings stays as it is beside the causes:
    `plain` (c,).
    """
    fit, own = found.last, slice(len(fitter.arm.labels))
    arm = fitter.on(fit.terms)
    if fitter.as_noisy(fit) == arm:
        return fitter, found
    noise, of_readings = (each[own] for each in noise_of(fitter.balancer, arm))
    louder = fitter.noise.copy()
    louder[own] = np.maximum(louder[own], np.sqrt(
        plain[own] ** 2 + np.maximum(noise ** 2 - of_readings ** 2, 0.0)))
    fitter = replace(fitter, noise=louder)
    return fitter, found.refitted(fitter)


def _placed(fit: Fit) -> set[Place]:
    """Return the places of the causes of a fit."""
    return {term.place for term in fit.accepted}


def _without_turns(other: Fitter, fitter: Fitter, found: SearchResult,
                   names: Sequence[str]) -> tuple[Fitter, SearchResult]:
    """
    Return a search by the `other`, without turns, if it leaves no rest as that with them did.

    A wrong torque is largest where shafts turn round as well.
    """
    again = search(other, names)
    return (fitter, found) if is_stuck(other, again) else (other, again)


def _split(fitter: Fitter, arm: Arm, names: Sequence[str], training: Spans,
           held_out: Spans) -> tuple[Spans, Spans]:
    """Return the stretches for fits and the others; where a contact shows, it is in both."""
    if not any(HYPOTHESES[name].passing for name in names if name in HYPOTHESES):
        return training, held_out
    return split_at_contacts(fitter.balancer, arm, fitter.noise, training, held_out)


def sought_effects() -> tuple[str, ...]:
    """Return the names of the effects that the raw readings or the balances can show."""
    return tuple(effect.name for effect in EFFECTS
                 if effect.name in HYPOTHESES or effect.name in RAW_EFFECTS)


def _unmoved(facts: RecordingFacts, arm: Arm, origin: Origin) -> Diagnosis:
    """Return the diagnosis of a recording in which no link moved: it shows nothing."""
    none, sizes = float('nan'), nothing_seen(arm, sought_effects())
    nothing = TotalGain(none, none, none, none, none, none, METRIC, '1')
    diagnosis = Diagnosis(
        'insufficient_excitation', (), (), None, tuple(one.row() for one in sizes),
        nothing, (), facts, origin.arm_file, origin.version, 0.0,
        (*facts.remarks, *remarks(sizes, arm, ())),
        limited_by='motion', probability=1.0)
    return replace(diagnosis, steps=next_steps(diagnosis))


def _probability(verdict: str, findings: tuple[Finding, ...], pairs: Sequence[Alike],
                 judged: GoodnessOfFit) -> float:
    """Return the probability of a verdict; a law at its bound is another one for certain."""
    left = judged.nothing_left if judged.unexplained.any() or verdict != 'unknown' else -1.0
    return verdict_probability(verdict, findings, [pair.probability for pair in pairs],
                               probability(left))


def _verdict(judged: GoodnessOfFit, findings: tuple[Finding, ...], tied: bool,
             is_unsure: bool) -> str:
    """Return the verdict that the findings, one that is not sure, and the rest call for."""
    if judged.unexplained.any() or is_unsure:
        return 'unknown'
    if tied:
        return 'ambiguous'
    return 'explained' if findings else 'no_discrepancy'
