"""Run commands of `hda` as a terminal does, within the process of a test."""

from hda_torque_estimator.cli import main


def complaint_of(capsys, *words):
    """Return the one line of a command that cannot do its job."""
    try:
        code = main(list(words))
    except SystemExit as stop:
        code = stop.code
    said = capsys.readouterr()
    assert (code, said.out, len(said.err.splitlines())) == (2, '', 1), said.err
    return said.err
