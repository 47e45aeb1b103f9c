"""What goes wrong, as exceptions."""

import errno
import os


class Error(ValueError):
    """A failure of Octavo.

    Attributes
    ----------
    kind : str
        "invalid_argument", "not_octavo", "unsupported_version", "corrupt", "truncated",
        "limit_exceeded", "source_rejected", "io", "out_of_memory", "cancelled" or "internal",
        as in the JSON output of the program.
    detail : str
        What went wrong, without the path and without advice.
    path : str
        The file it is about; empty where there is none.
    offset : int or None
        Where in the file, in bytes.
    """

    kind = "internal"

    def __init__(self, text, detail="", path="", offset=None):
        super().__init__(text)
        self.detail = detail or text
        self.path = path
        self.offset = offset

    def __str__(self):
        return str(self.args[0])

    def __reduce__(self):
        return type(self), (self.args[0], self.detail, self.path, self.offset)


class ArgumentError(Error):
    """What was asked for makes no sense, or not for this file."""
    kind = "invalid_argument"


class FormatError(Error):
    """The file is no .8vo file."""
    kind = "not_octavo"


class VersionError(Error):
    """The file needs a newer Octavo."""
    kind = "unsupported_version"


class CorruptError(Error):
    """Bytes of the file are damaged; nothing of the damaged part is returned."""
    kind = "corrupt"


class TruncatedError(CorruptError):
    """The file ends early."""
    kind = "truncated"


class LimitError(Error):
    """A limit of memory, voxels or the format would be passed."""
    kind = "limit_exceeded"


class SourceError(Error):
    """The voxels or files given to a build cannot be taken as they are."""
    kind = "source_rejected"


class StorageError(Error, OSError):
    """Reading or writing failed."""
    kind = "io"


class MissingError(StorageError, FileNotFoundError):
    """There is no such file; `errno` and `filename` are those of a FileNotFoundError."""

    errno = errno.ENOENT
    strerror = os.strerror(errno)
    filename = property(lambda self: self.path)


class ExistsError(StorageError, FileExistsError):
    """A file stands there already, and was not to be replaced; `errno` and `filename` are those of
    a FileExistsError."""

    errno = errno.EEXIST
    strerror = os.strerror(errno)
    filename = property(lambda self: self.path)


class OutOfMemoryError(Error, MemoryError):
    """Memory ran out."""
    kind = "out_of_memory"


class Cancelled(Error):
    """The work was asked to stop."""
    kind = "cancelled"


class InternalError(Error):
    """A fault of Octavo itself."""
    kind = "internal"


_CLASSES = {c.kind: c for c in (
    ArgumentError, FormatError, VersionError, CorruptError, TruncatedError, LimitError,
    SourceError, StorageError, OutOfMemoryError, Cancelled, InternalError)}

# (kind or None for any, field, value or None for any): what helps. The first row that fits counts.
_ADVICE = (
    (None, "dtype", None, "convert it with .astype()"),
    (None, "label_names", None, 'kind="labels" makes labels of them'),
    (None, "keep_details", None, "keep_details={}"),
    ("source_rejected", "max_error", None, "max_error={} would do"),
    (None, "max_error", "0", "leave out max_error"),
    (None, "max_memory", None, "raise max_memory"),
    (None, "output.overwrite", None, "overwrite=True replaces it"),
    (None, "overwrite", None, "overwrite=True replaces it"),
    (None, "repair.nan", None, "nan=VALUE replaces NaN"),
    (None, "repair.infinity", None, "inf=VALUE replaces infinities"),
    (None, "spacing_mm", None, "give spacing=(z, y, x) in mm"),
    (None, "interrupted", "resume", "resume=True goes on behind them"),
    (None, "interrupted", "discard", "overwrite=True starts anew"),
    ("io", "interrupted", "", "resume=True goes on with it, overwrite=True starts anew"),
)


# The field of a failure of a path where nothing is, and those of one where something stands.
_MISSING_PATH = "path.missing"
_EXISTING_PATH = ("overwrite", "output.overwrite")


def _advice_of(kind, hints):
    for field, value in hints:
        for row_kind, row_field, row_value, text in _ADVICE:
            if row_field != field or (row_kind or kind) != kind:
                continue
            if row_value not in (None, value) or ("{}" in text and not value):
                continue
            return text.format(value)
    return ""


def make_error(kind, detail, path="", offset=None, hints=()):
    """The exception for a failure of the library: its words and what would help in Python."""
    text = f"{path}: {detail}" if path else detail
    advice = _advice_of(kind, hints)
    if advice:
        text = f"{text} ({advice})"
    if path and any(field == _MISSING_PATH for field, _ in hints):
        return MissingError(text, detail, path)
    if kind == "io" and path and any(field in _EXISTING_PATH for field, _ in hints):
        return ExistsError(text, detail, path)
    return _CLASSES.get(kind, InternalError)(text, detail, path, offset)


def package_error(package, text, error):
    """The error for an `ImportError` of an optional package.

    `text` where there is none; where there is one that cannot be imported, as an old one beside a
    new NumPy, why as well.
    """
    cause = error
    while isinstance(cause.__cause__, ImportError):
        cause = cause.__cause__
    is_missing = isinstance(cause, ModuleNotFoundError)
    if is_missing and (cause.name or "").partition(".")[0] == package:
        return ArgumentError(text)
    reason = (str(cause).splitlines() or [type(cause).__name__])[0]
    return ArgumentError(f"{text}; the one that is installed cannot be imported: {reason}")
