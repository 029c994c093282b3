"""The column maps that come with the package."""

from importlib import resources

SHIPPED = resources.files('hda_arm_sim.config') / 'maps'


def shipped_maps() -> tuple[str, ...]:
    """Return the names of the maps that come with the package."""
    return tuple(sorted(item.name for item in SHIPPED.iterdir() if item.name.endswith('.yaml')))
