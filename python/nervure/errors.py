"""What a user is told in one sentence in place of a traceback."""


class Refusal(Exception):
    """Something that was given cannot be used: the message says what, and where it can what to do. Exit code 2."""


class SceneError(Refusal):
    """A scene or an override that cannot be used; the message names file or key."""
