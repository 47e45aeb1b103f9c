"""Metadata: docs/format.md, sections 7 and 9."""

import json
import re

from .errors import OctavoError, require

_DEPTH_LIMIT = 16
_VALUE_LIMIT = 65536
_STRING_LIMIT = 65536
_DIGIT_LIMIT = 4000
_STRING = re.compile(r'"(?:[^"\\]|\\.)*"', re.DOTALL)


class _Members(list):
    """The (name, value) pairs of an object, as they are written."""


def parse_metadata(data: bytes) -> dict:
    """The JSON object in UTF-8 that stands in `data`. Raises OctavoError "corrupt"."""
    try:
        text = data.decode()
        _prove_depth(text)
        members = json.loads(text, object_pairs_hook=_Members, parse_int=_integer,
                             parse_constant=_reject)
        require(isinstance(members, _Members), "the metadata is no JSON object")
        return _Limits().proven(members)
    except ValueError as error:
        raise OctavoError("corrupt", f"the metadata is no JSON: {error}") from None


def _prove_depth(text: str) -> None:
    depth = 0
    for bracket in re.findall(r"[\[\]{}]", _STRING.sub("", text)):
        depth += 1 if bracket in "[{" else -1
        require(depth <= _DEPTH_LIMIT, "the metadata is nested too deep")


def _integer(digits: str) -> int | float:
    return int(digits) if len(digits) <= _DIGIT_LIMIT else float(digits)


def _reject(name: str) -> None:
    raise ValueError(f"{name} is no number")


class _Limits:
    """Counts the values of one text."""

    def __init__(self) -> None:
        self._count = 0

    def proven(self, value: object) -> object:
        """The value with its objects as dict. Raises OctavoError "corrupt" beyond a limit."""
        self._count += 1
        require(self._count <= _VALUE_LIMIT, "the metadata has too many values")
        if isinstance(value, _Members):
            return {self._string(name): self.proven(member) for name, member in value}
        if isinstance(value, list):
            return [self.proven(item) for item in value]
        return self._string(value) if isinstance(value, str) else value

    def _string(self, text: str) -> str:
        require(len(text.encode()) <= _STRING_LIMIT, "the metadata has too long a string")
        return text
