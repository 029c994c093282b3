"""Text from files and names as a terminal may show it: nothing in it moves the cursor."""

LONGEST = 1000          # characters of one line: an error says what is wrong, not all that is


def printable(text: str, keep: str = '') -> str:
    r"""
    Return text with every character that does not print as its escape, such as `\x1b`.

    Characters in `keep` stay. Printing the result never fails on half a surrogate pair.
    """
    if text.isprintable():
        return text
    return text.translate({ord(one): ascii(one)[1:-1] for one in set(text)
                           if not one.isprintable() and one not in keep})


def one_line(text: str) -> str:
    """Return text as one printable line of bounded length."""
    line = printable(' '.join(text[:4 * LONGEST].split()))
    return line if len(line) <= LONGEST else f'{line[:LONGEST]} ...'
