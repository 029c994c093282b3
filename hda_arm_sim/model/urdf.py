"""
Read robot descriptions (URDF) of strangers: links with inertia, joints, nothing else.

Documents that declare anything (a DOCTYPE, entities) are refused before any of it is used, and no
file that a document names is ever opened. Every mistake is one sentence.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, NoReturn
from xml.parsers import expat
from xml.sax.saxutils import quoteattr

from hda_msgs_json.errors import HdaError

LARGEST = 1 << 22       # bytes of a description without its meshes: 50 times a humanoid's
_DEEPEST = 64           # elements within each other; a description has five
_MOST = 100_000         # elements; a humanoid has 3000
_KEPT = {'robot': {'link', 'joint'}, 'link': {'inertial'},
         'inertial': {'origin', 'mass', 'inertia'},
         'joint': {'origin', 'parent', 'child', 'axis', 'limit', 'mimic'}}


class UrdfError(HdaError):
    """A robot description that cannot be read, or that no body can have."""


@dataclass
class Element:
    """An element of the description with what it holds."""

    name: str
    attributes: Mapping[str, str]
    parts: list['Element'] = field(default_factory=list)

    def part(self, name: str) -> 'Element | None':
        """Return the first part of a name, if there is one."""
        return next((part for part in self.parts if part.name == name), None)

    def named(self, name: str) -> Iterator['Element']:
        """Yield the parts of a name."""
        return (part for part in self.parts if part.name == name)

    @property
    def label(self) -> str:
        """Return what it is called; raises UrdfError without a name."""
        label = self.attributes.get('name', '')
        if not label:
            raise UrdfError(f'a {self.name} of the description has no name')
        return label

    def text(self) -> str:
        """Return the element as a description again, on lines of its own."""
        inner = ''.join(part.text() for part in self.parts)
        held = ''.join(f' {key}={quoteattr(value)}' for key, value in self.attributes.items())
        end = f'>\n{inner}</{self.name}>\n' if inner else '/>\n'
        return f'<{self.name}{held}{end}'


class _Reader:
    """What expat reads, made into elements; all but links and joints is passed over."""

    def __init__(self) -> None:
        self.root: Element | None = None
        self._open: list[Element] = []
        self._passed_over = 0
        self._seen = 0
        self.parser = expat.ParserCreate()
        self.parser.StartElementHandler = self._begin
        self.parser.EndElementHandler = self._end
        self.parser.StartDoctypeDeclHandler = self._refuse
        self.parser.EntityDeclHandler = self._refuse
        self.parser.ExternalEntityRefHandler = self._refuse

    def _begin(self, name: str, attributes: dict[str, str]) -> None:
        self._seen += 1
        if self._seen > _MOST or len(self._open) + self._passed_over > _DEEPEST:
            raise UrdfError(f'it holds more than {_MOST} elements, or more than {_DEEPEST} within '
                            'each other')
        if self.root is None:
            if name != 'robot':
                raise UrdfError(f'it is no robot description: it holds <{name:.40}>, not <robot>')
            self.root = Element(name, {'name': attributes.get('name', 'robot')})
            self._open.append(self.root)
            return
        if name.startswith('xacro:') and not self._passed_over:
            raise UrdfError('it is xacro; make a description of it first: xacro FILE > robot.urdf')
        if self._passed_over or name not in _KEPT.get(self._open[-1].name, ()):
            self._passed_over += 1
            return
        self._open.append(Element(name, attributes))
        self._open[-2].parts.append(self._open[-1])

    def _end(self, name: str) -> None:
        if self._passed_over:
            self._passed_over -= 1
        else:
            self._open.pop()

    def _refuse(self, *declared: Any) -> NoReturn:
        raise UrdfError('it declares a document type or entities, which are never read; take the '
                        '<!DOCTYPE ...> out')


def read_description(text: str) -> Element:
    """Return the robot of a description with its links and joints; raises UrdfError."""
    if len(text) > LARGEST:
        raise UrdfError(f'it is too long: at most {LARGEST >> 20} MiB are read')
    reader = _Reader()
    try:
        reader.parser.Parse(text.encode('utf-8', 'surrogateescape'), True)
    except UrdfError:
        raise
    except expat.ExpatError as error:
        raise UrdfError(f'it is no XML: {error}') from None
    except (ValueError, LookupError) as error:      # an encoding that it only claims to have
        raise UrdfError(f'it is no XML: {error}') from None
    assert reader.root is not None                  # expat refuses a document without a root
    return reader.root
