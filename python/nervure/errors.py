"""What a user is told in one sentence in place of a traceback."""

import re


class Refusal(Exception):
    """Something that was given cannot be used: the message says what, and where it can what to do. Exit code 2."""


class SceneError(Refusal):
    """A scene or an override that cannot be used; the message names file or key."""

    @property
    def key(self) -> str | None:
        """The key that the units blame, if they do."""
        blamed = re.match(r"scene key `(.*?)`", str(self))
        return blamed[1] if blamed else None
