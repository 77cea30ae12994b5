"""How a program may end whose threads still work."""


def assert_ended_cleanly(run):
    """No thread says anything: while the interpreter ends, Python 3.10 aborts where one prints."""
    assert run.returncode == 0 and run.stderr == "", run.stderr
