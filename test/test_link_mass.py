"""A link of another mass: in which laws it is looked for, and that it has its own name."""

from hda_arm_sim.model.files import read_arm
from hda_torque_estimator.diagnosis.detectability.effect_shapes import shapes
from hda_torque_estimator.diagnosis.fitting.hypotheses import terms_of
import pytest
from truth import worlds
from world_fits import diagnosed

ARM, COBOT = read_arm('hda_arm.yaml'), read_arm('cobot7.yaml')
NAME = 'link_inertia_error'


@pytest.mark.parametrize(('arm', 'others'), [(ARM, ('error',)), (COBOT, ())])
def test_beside_the_mass_in_a_plane_the_inertia_keeps_its_tolerance(arm, others):
    for label in arm.labels:
        inertia, mass = (term for term in terms_of(arm, NAME) if term.joint == label)
        assert inertia.free == inertia.sought == ('error',)
        assert (mass.free, mass.sought, mass.freedom) == (('mass', *others), ('mass',), 1)
        assert (mass.deviations()[1:] < 0.05).all()


@pytest.mark.parametrize('arm', [ARM, COBOT])
def test_the_smallest_size_is_that_of_the_number_that_it_is_stated_in(arm):
    """A mass shows at a smaller share than an inertia does, as it has a weight."""
    assert {term.free for term in shapes(None, arm, NAME)} == {('error',)}


# Without a law of its own, 996103 was a torque constant, a stiffness and a tilt, for certain.
@pytest.mark.parametrize('seed', [996103, pytest.param(996113, marks=pytest.mark.study)])
def test_a_lighter_link_is_named_with_its_joint(seed):
    world = worlds.draw(seed, (NAME,), motion='rich', rate=1000, seconds=30.0, joints=2)
    hidden = world.hidden[0]
    said = diagnosed(world)
    found, = (one for one in said.findings if one.effect != 'clock_jitter')
    assert len(said.findings) == 1 + (world.logger.jitter > 0.0)
    assert hidden.form == 'mass'
    assert (said.verdict, found.effect, found.joint) == ('explained', NAME, hidden.joint)
    assert found.parameters['mass'].value == pytest.approx(
        hidden.parameters['relative_error'], abs=0.03)
