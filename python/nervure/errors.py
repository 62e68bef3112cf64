"""What a user is told in one sentence in place of a traceback."""

import re


class InputError(Exception):
    """Input that nervure cannot use; the message says why and, if possible, what to do. Exit code 2."""


class SceneError(InputError):
    """A scene or an override that cannot be used; the message names file or key."""

    @property
    def key(self) -> str | None:
        """The key that the units blame, if they do."""
        blamed = re.match(r"scene key `(.*?)`", str(self))
        return blamed[1] if blamed else None
