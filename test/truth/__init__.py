"""
An arm that hides effects: simulated independently of the library, to test what it finds.

README.md lists equations, parameters and sizes of all effects.
"""

from .catalogue import CATALOGUE
from .effect import Effect, Hidden, Parameter, TruthError
from .layout import draw, EFFECTS
from .outside import OUTSIDE
from .recording import Device, record, Reference, TruthRecord

__all__ = ['CATALOGUE', 'Device', 'draw', 'Effect', 'EFFECTS', 'Hidden', 'OUTSIDE', 'Parameter',
           'record', 'Reference', 'TruthError', 'TruthRecord']
