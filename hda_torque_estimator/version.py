"""The version of the package that is running."""

from importlib import metadata


def version() -> str:
    """Return the version, as bags and reports name it."""
    try:
        return metadata.version('hda-torque-estimator')
    except metadata.PackageNotFoundError:
        return 'not installed'
