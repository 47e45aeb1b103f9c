"""The one exception of this package."""


EXIT_STATUS = {"invalid_argument": 2, "not_octavo": 3, "unsupported_version": 3, "corrupt": 4,
               "truncated": 4, "limit_exceeded": 6}


class OctavoError(Exception):
    """A file that cannot be read; `kind` says why, as in the C++ library.

    kind  "not_octavo", "unsupported_version", "truncated", "corrupt", "limit_exceeded",
          "invalid_argument"
    """

    def __init__(self, kind: str, text: str) -> None:
        super().__init__(f"{kind}: {text}")
        self.kind = kind


def require_known(condition: bool, text: str) -> None:
    """Raises OctavoError "unsupported_version" with `text` unless `condition` holds."""
    if not condition:
        raise OctavoError("unsupported_version", f"{text}, which this reader does not know")


def require_within(value: int, limit: int, what: str) -> None:
    """Raises OctavoError "limit_exceeded" for a value above what any file of 1.0 has."""
    if value > limit:
        raise OctavoError("limit_exceeded", f"{what}: {value}, at most {limit} are possible")


def require(condition: bool, text: str) -> None:
    """Raises OctavoError "corrupt" with `text` unless `condition` holds."""
    if not condition:
        raise OctavoError("corrupt", text)
