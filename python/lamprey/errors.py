"""What lamprey raises."""


class InputError(ValueError):
    """A problem, a file or an argument that is wrong, in one line: where, what was found, what is allowed, how to mend it.

    file, line and column are None where they are not known; key is that of the problem file, or the argument's name.
    """

    file: str | None = None
    line: int | None = None
    column: int | None = None
    key: str = ""
    message: str = ""
