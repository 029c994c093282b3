"""
Who may see the page and press its buttons: whoever holds the token, on this machine.

A page of another origin can make a browser send requests here. A name that leads to this machine
can make them look like its own. So the origin and the name are checked as well.
"""

from collections.abc import Mapping
import hmac
import secrets

HOST = '127.0.0.1'
TOKEN_BYTES = 24
"""Enough that nobody guesses it: 192 bits."""


class Access:
    """The token of one run, and the names under which it is reached."""

    def __init__(self, port: int) -> None:
        """Make a new token."""
        self.token = secrets.token_urlsafe(TOKEN_BYTES)
        self.cookie = f'hda_live_{port}'         # browsers keep those of all ports together
        self._hosts = {f'{name}:{port}' for name in (HOST, 'localhost')}
        self.url = f'http://{HOST}:{port}/?token={self.token}'

    def refusal(self, headers: Mapping[str, str], token: str | None) -> str | None:
        """Return why a request is refused, in one sentence; None if it is not."""
        if headers.get('Host', '') not in self._hosts:
            return 'the page is served on this machine only, under the address that was printed'
        origin = headers.get('Origin')
        if origin is not None and origin not in {f'http://{host}' for host in self._hosts}:
            return 'requests of other pages are refused'
        if token is None or not hmac.compare_digest(token.encode(), self.token.encode()):
            return 'the token is missing or wrong: open the address that `hda live` printed'
        return None
