"""Draw a block diagram: boxes at their places, arrows between them."""

from matplotlib.axes import Axes
from matplotlib.patches import FancyArrowPatch

from .exhibit import Diagram, Wire
from ..pages.drawing import AFTER, INK, plain

_MARGIN = 0.6                       # around the blocks [grid]


def draw_diagram(axes: Axes, diagram: Diagram) -> None:
    """Draw a diagram into axes, which then hold nothing else."""
    places = {block.name: (block.x, block.y) for block in diagram.blocks}
    columns, rows = zip(*places.values())
    axes.set_xlim(min(columns) - _MARGIN, max(columns) + _MARGIN)
    axes.set_ylim(max(rows) + _MARGIN, min(rows) - _MARGIN)
    boxes = {}
    for block in diagram.blocks:
        boxes[block.name] = axes.text(
            block.x, block.y, plain(block.label), ha='center', va='center', fontsize=7.5,
            color=INK, bbox={'boxstyle': 'round,pad=0.45', 'facecolor': 'none',
                             'edgecolor': INK, 'linewidth': 0.8})
    for wire in diagram.wires:
        _wire(axes, places, boxes, wire)


def _wire(axes: Axes, places: dict, boxes: dict, wire: Wire) -> None:
    """Draw an arrow from box to box, and what it multiplies by beside its middle."""
    (x1, y1), (x2, y2) = places[wire.start], places[wire.end]
    axes.add_patch(FancyArrowPatch(
        (x1, y1), (x2, y2), connectionstyle=f'arc3,rad={wire.bend}', arrowstyle='-|>',
        mutation_scale=8.0, linewidth=0.9, color=AFTER, patchA=boxes[wire.start].get_bbox_patch(),
        patchB=boxes[wire.end].get_bbox_patch(), shrinkA=2.0, shrinkB=2.0))
    middle = (0.5 * (x1 + x2) + 0.5 * wire.bend * (y2 - y1),
              0.5 * (y1 + y2) - 0.5 * wire.bend * (x2 - x1))
    axes.text(*middle, plain(wire.label), fontsize=6.5, color=AFTER, ha='center', va='center',
              bbox={'facecolor': 'white', 'alpha': 0.8, 'edgecolor': 'none', 'pad': 0.5})
