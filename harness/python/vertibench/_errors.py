"""The kind of error that this package raises."""


class VertiBenchError(Exception):
    """Something can't be used or found. The message is one line: where, what, what to do."""

    def __init__(self, where: object, what: str, to_do: str):
        super().__init__(" ".join(f"{where}: {what} ({to_do})".split()))


class MissingError(VertiBenchError):
    """The program, the tasks or a planner isn't where it is looked for."""
