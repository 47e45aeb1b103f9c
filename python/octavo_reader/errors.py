"""The one exception of this package."""


class OctavoError(Exception):
    """A file that cannot be read; `kind` says why, as in the C++ library.

    kind  "not_octavo", "unsupported_version", "truncated", "corrupt", "invalid_argument"
    """

    def __init__(self, kind: str, text: str) -> None:
        super().__init__(f"{kind}: {text}")
        self.kind = kind


def require_known(condition: bool, text: str) -> None:
    """Raises OctavoError "unsupported_version" with `text` unless `condition` holds."""
    if not condition:
        raise OctavoError("unsupported_version", f"{text}, which this reader does not know")


def require(condition: bool, text: str) -> None:
    """Raises OctavoError "corrupt" with `text` unless `condition` holds."""
    if not condition:
        raise OctavoError("corrupt", text)
