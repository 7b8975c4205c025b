"""The error of datasets."""

from .._errors import VertibenchError


class DatasetError(VertibenchError):
    """A dataset is missing, incomplete, damaged or unsuitable. The message is one line."""
