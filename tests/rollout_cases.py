"""What the tests of rollouts share; not a test itself."""


def quiet():
    """A callback that lets everything go on."""

    class Nothing:
        def __getattr__(self, name):
            return lambda *_: True

    return Nothing()
