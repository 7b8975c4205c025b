"""The kind of error that datasets raise."""

from .._errors import VertibenchError


class DatasetError(VertibenchError):
    """A dataset can't be used. The message is one line: where, what, what to do."""
