"""What a page says of each effect, as the effects declare it, and the parts of its drawing."""

from hda_arm_sim.model.effects import EFFECTS
from hda_arm_sim.model.effects.words import Words

WORDS: dict[str, Words] = {effect.name: effect.words for effect in EFFECTS}

ELEMENTS = {
    'drive': 'drive', 'motor': 'motor', 'motor_encoder': 'motor encoder',
    'wave_generator': 'wave generator', 'flexspline': 'flexspline', 'flange': 'output flange',
    'bearing': 'link bearing', 'link_encoder': 'link encoder', 'link': 'link', 'tip': 'tip',
    'base': 'base',
}
