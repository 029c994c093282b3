"""Draw a block diagram: boxes at their places, arrows between them."""

from matplotlib.axes import Axes
from matplotlib.patches import FancyArrowPatch
from matplotlib.text import Text

from .rig.exhibit import Diagram, Wire
from ..pages.drawing import AFTER, INK, plain

_MARGIN = 0.8                       # around the blocks [grid]
_LIFT = 0.06                        # of a label above its arrow [grid]
_SLANTED = 0.66                    # where along a slanted arrow its label stands


def draw_diagram(axes: Axes, diagram: Diagram) -> None:
    """Draw a diagram into axes, which then hold nothing else."""
    columns = [block.x for block in diagram.blocks]
    rows = [block.y for block in diagram.blocks]
    axes.set_xlim(min(columns) - _MARGIN, max(columns) + _MARGIN)
    axes.set_ylim(max(rows) + _MARGIN, min(rows) - _MARGIN)
    axes.set_aspect('equal')
    boxes = {block.name: axes.text(
        block.x, block.y, plain(block.label), ha='center', va='center', fontsize=7.0, color=INK,
        bbox={'boxstyle': 'round,pad=0.45', 'facecolor': 'none', 'edgecolor': INK,
              'linewidth': 0.8}) for block in diagram.blocks}
    for wire in diagram.wires:
        _wire(axes, boxes, wire)


def _wire(axes: Axes, boxes: dict[str, Text], wire: Wire) -> None:
    """Draw an arrow from box to box, and beside it what it multiplies by."""
    begin, end = boxes[wire.start], boxes[wire.end]
    (x1, y1), (x2, y2) = begin.get_position(), end.get_position()
    axes.add_patch(FancyArrowPatch(
        (x1, y1), (x2, y2), connectionstyle=f'arc3,rad={wire.bend}', arrowstyle='-|>',
        mutation_scale=8.0, linewidth=0.9, color=AFTER, patchA=begin.get_bbox_patch(),
        patchB=end.get_bbox_patch(), shrinkA=2.0, shrinkB=2.0))
    _label(axes, (x1, y1), (x2 - x1, y2 - y1), wire)


def _label(axes: Axes, begin: tuple[float, float], way: tuple[float, float], wire: Wire) -> None:
    """Write beside an arrow: above or below its middle, or to the right of a slanted one."""
    level = way[1] == 0.0
    along = 0.5 if level else _SLANTED
    sag = 0.5 * wire.bend * way[0]
    below = sag > 0.0 if level else way[0] * way[1] < 0.0
    axes.text(begin[0] + along * way[0] + (0.0 if level else _LIFT),
              begin[1] + along * way[1] + sag + (_LIFT if below else -_LIFT), plain(wire.label),
              fontsize=6.5, color=AFTER, ha='center' if level else 'left',
              va='top' if below else 'bottom')
