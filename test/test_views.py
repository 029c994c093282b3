"""What RViz and Foxglove are asked to show is there: topics, fields of messages, panels."""

import json
import re

from hda_arm_sim.model.files import read_arm
from hda_msgs_json.schemas import DEFINITIONS, short_name
from hda_msgs_json.topics import DIAGNOSTICS, ROBOT_DESCRIPTION
from hda_torque_estimator.recording.recorded_topics import system_topics
from project_files import ROOT
import pytest
import yaml

ARM = read_arm('hda_arm.yaml')
TYPES = {topic.name.strip('/'): topic.message_type
         for topic in (*system_topics(ARM), ROBOT_DESCRIPTION)}
LAYOUT = json.loads((ROOT / 'config' / 'foxglove_layout.json').read_text())
PLOTTED = [path['value'] for name, panel in LAYOUT['configById'].items()
           if name.startswith('Plot!') for path in panel['paths']]


def leaves(tree: object) -> list[str]:
    """Return the panels of a tree of splits."""
    if isinstance(tree, str):
        return [tree]
    return [leaf for side in ('first', 'second') for leaf in leaves(tree[side])]


def test_every_panel_has_its_place_and_its_settings():
    placed = leaves(LAYOUT['layout'])
    assert sorted(placed) == sorted(LAYOUT['configById'])
    assert len(set(placed)) == len(placed)


@pytest.mark.parametrize('path', PLOTTED)
def test_a_plotted_path_leads_to_a_number(path):
    """Each part of a path is a field of the message, and an index is one of a joint."""
    name, *fields = path.strip('/').split('.')
    kind = TYPES[name]
    for field in fields:
        word, index = re.fullmatch(r'(\w+)(?:\[(\d+)\])?', field).groups()
        kinds = {line.split()[1]: line.split()[0]
                 for line in DEFINITIONS[short_name(kind)].splitlines()}
        kind = kinds[word].removesuffix('[]')
        assert kinds[word].endswith('[]') == (index is not None)
        assert index is None or int(index) < len(ARM.labels)
    assert kind == 'float64'


def test_other_panels_name_topics_that_are_there():
    panels = LAYOUT['configById']
    assert panels['DiagnosticSummary!health']['topicToRender'] == DIAGNOSTICS.name
    assert panels['RawMessages!state']['topicPath'].strip('/') in TYPES
    assert {topic.strip('/') for topic in panels['3D!arm']['topics']} <= TYPES.keys()


def test_rviz_shows_topics_that_are_there():
    shown = yaml.safe_load((ROOT / 'config' / 'view.rviz').read_text())['Visualization Manager']
    named = [display[key]['Value'] for display in shown['Displays']
             for key in ('Topic', 'Description Topic') if key in display]
    assert len(named) == 4
    assert set(named) <= TYPES.keys()
