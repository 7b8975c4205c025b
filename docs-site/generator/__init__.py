"""Generator of the documentation site: prepares a folder of Markdown pages for MkDocs."""


class SiteError(Exception):
    """Problems of the sources, one line each: where, what, what to do."""

    def __init__(self, *problems: str) -> None:
        super().__init__("\n".join(problems))
        self.problems = problems
