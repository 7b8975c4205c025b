"""The one kind of error."""


class DatasetError(Exception):
    """A dataset can't be used. The message is one line: where, what, what to do."""

    def __init__(self, where: object, what: str, to_do: str):
        super().__init__(" ".join(f"{where}: {what} ({to_do})".split()))
