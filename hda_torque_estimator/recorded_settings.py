"""The settings that an estimator had while a recording was made."""

from collections.abc import Mapping
import json
from typing import Any, NamedTuple, TypeVar

from hda_arm_sim.model.parameter import Declared

from .estimator import EstimatorSettings
from .live_estimator import StateSettings

NODE = 'torque_estimator'
Group = TypeVar('Group', bound=Declared)


class RecordedSettingsError(ValueError):
    """A recording that says of its settings what cannot be read."""


class RecordedSettings(NamedTuple):
    """What a live estimator was told, as far as it changes what it publishes."""

    estimator: EstimatorSettings = EstimatorSettings()
    state: StateSettings = StateSettings()

    def to_metadata(self) -> dict[str, str]:
        """Return what a recording says of these settings."""
        values = {rule.name: getattr(group, rule.name)
                  for group in self for rule in group.declarations()}
        return {'parameters': json.dumps({NODE: values})}


def recorded_settings(metadata: Mapping[str, str]) -> RecordedSettings:
    """
    Return the settings that a recording tells, defaults where it tells none.

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
    return RecordedSettings(_group(EstimatorSettings, values), _group(StateSettings, values))


def _group(kind: type[Group], values: Mapping[str, Any]) -> Group:
    return kind(**{rule.name: values[rule.name] for rule in kind.declarations()
                   if rule.name in values})
