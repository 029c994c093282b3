"""How people speak of an effect: a sentence with its size, the part that has it, and the check."""

from typing import NamedTuple

# What a mechanic does about several effects.
CHECK_GREASE = 'Feel whether it turns evenly by hand with the drive off; check grease and seals.'
CHECK_MESH = 'Check grease, alignment and wear of the teeth; compare with a gear of the same size.'
CHECK_DRIVE = 'Read the settings of the drive, and measure its current beside the command.'
CHECK_ENCODER = ('Check how the disc is seated, and the error curve that the encoder itself can '
                 'show.')


class Words(NamedTuple):
    """
    What a page says of an effect.

    A sentence goes on after a joint or the arm. `{size}` is the largest of the named numbers in
    the unit in which people say it, times `scale`; other numbers stand there by their names.
    `less` is the sentence for a negative size. Other numbers that were found as well follow with
    the words `beside`.
    """

    said: str
    element: str                    # part of the arm that has it, as a drawing names it
    check: str                      # what a mechanic does about it
    size: tuple[str, ...] = ()
    scale: float = 1.0
    less: str = ''
    beside: tuple[tuple[str, str], ...] = ()
