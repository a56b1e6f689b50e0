# SPDX-License-Identifier: MIT
"""What goes wrong, with the place and what would be right there."""


class InputError(ValueError):
    """Input that cannot be used: `place` is a file, line or option, `problem` what is wrong with it."""

    def __init__(self, place: object, problem: str) -> None:
        super().__init__(f"{place}: {problem}")
        self.place, self.problem = str(place), problem


class ProgramError(RuntimeError):
    """The program `trilat` ended with `code`; the text is what it said."""

    def __init__(self, code: int, message: str) -> None:
        super().__init__(message or f"trilat ended with exit code {code}")
        self.code = code
