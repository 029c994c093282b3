"""The settings that an estimator had while a recording was made."""

from collections.abc import Mapping
import json
from typing import Any, NamedTuple, TypeVar

from hda_arm_sim.foundation.parameter import Declared
from hda_msgs_json.errors import HdaError

from .estimate_messages import UNOBSERVED
from .estimator import EstimatorSettings
from .live_estimator import StateSettings
from ..samples.driver_states import Driver

NODE = 'torque_estimator'
Group = TypeVar('Group', bound=Declared)


class RecordedSettingsError(HdaError):
    """A recording that says of its settings what cannot be read."""


class RecordedSettings(NamedTuple):
    """The settings that a live estimator had, as far as it changes what it publishes."""

    estimator: EstimatorSettings = EstimatorSettings()
    state: StateSettings = StateSettings()
    unobserved: str = 'nan'             # what stands in wrenches for it
    driver: Driver = Driver()           # which no estimate shows

    def to_metadata(self) -> dict[str, str]:
        """Return what a recording says of these settings."""
        values = {rule.name: getattr(group, rule.name)
                  for group in (self.estimator, self.state) for rule in group.declarations()}
        return {'parameters': json.dumps({NODE: {**values, 'unobserved': self.unobserved}})}


def recorded_settings(metadata: Mapping[str, str]) -> RecordedSettings:
    """
    Return the settings that a recording states, defaults where it states none.

    Raise RecordedSettingsError or ParameterError for what cannot be settings.
    """
    try:
        said = json.loads(metadata.get('parameters', '{}'))
    except (ValueError, RecursionError):
        raise RecordedSettingsError('the parameters in the metadata are no JSON') from None
    values = said.get(NODE, {}) if isinstance(said, dict) else None
    if not isinstance(values, dict):
        raise RecordedSettingsError(
            f'the parameters of {NODE} in the metadata must be names with values, got {values!r}')
    return RecordedSettings(_group(EstimatorSettings, values), _group(StateSettings, values),
                            checked_unobserved(values.get('unobserved', 'nan')),
                            _driver(values))


def _driver(values: Mapping[str, Any]) -> Driver:
    """Return what a recording says of the names and topics of its driver."""
    names = [values.get(side, ['']) for side in ('link', 'motor')]
    topics = [values.get(topic, '') for topic in ('link_topic', 'motor_topic')]
    if not all(isinstance(each, list) and all(isinstance(name, str) for name in each)
               for each in names) or not all(isinstance(topic, str) for topic in topics):
        raise RecordedSettingsError(f'link and motor must be lists of names, link_topic and '
                                    f'motor_topic be names, got {[*names, *topics]!r}')
    link, motor = (tuple(filter(None, each)) for each in names)
    return Driver(link, motor, *topics)


def checked_unobserved(value: Any) -> str:
    """Return what stands for what cannot be observed; raise RecordedSettingsError."""
    if value not in UNOBSERVED:
        raise RecordedSettingsError(
            f'unobserved must be one of {", ".join(UNOBSERVED)} (what stands in a wrench where '
            f'nothing is known), got {value!r}')
    return str(value)


def _group(kind: type[Group], values: Mapping[str, Any]) -> Group:
    return kind(**{rule.name: values[rule.name] for rule in kind.declarations()
                   if rule.name in values})
