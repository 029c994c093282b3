"""The reliability diagram: of the causes named with a probability, the share that is right."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure
from world_judging import probabilities
from world_tables import binned, calibration_error


def draw_diagram(results: Sequence[dict[str, Any]], path: Path) -> None:
    """Write the diagram, or nothing where no probability is stated."""
    pairs = [pair for result in results if 'said' in result for pair in probabilities(result)]
    if not pairs:
        return
    figure = Figure(figsize=(4.0, 4.0), layout='constrained')
    axes = figure.add_subplot()
    _, means, rights, counts = zip(*binned(pairs))
    axes.plot([0.0, 1.0], [0.0, 1.0], color='0.7', linewidth=1.0)
    axes.plot(means, rights, 'o-', color='tab:blue')
    for mean, right, count in zip(means, rights, counts):
        axes.annotate(str(count), (mean, right), textcoords='offset points', xytext=(-8, -4),
                      ha='right')
    axes.set(xlabel='probability stated', ylabel='share that is right', xlim=(0.0, 1.02),
             ylim=(0.0, 1.02), title=f'calibration error {calibration_error(pairs):.3f}')
    figure.savefig(path, dpi=150)
