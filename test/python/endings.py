"""How a program may end whose threads still work."""

import re


def assert_ended_cleanly(run):
    """Threads may be told that the interpreter is ending, or that what they use is closed. They write at the same time, so lines may be mixed."""
    assert run.returncode == 0, run.stderr
    assert "terminate" not in run.stderr, run.stderr
    assert set(re.findall(r"\w*Error\b", run.stderr)) <= {"RuntimeError", "ValueError"}, run.stderr
    told = run.stderr.count("the interpreter is ending") + run.stderr.count("is closed")
    assert told >= len(re.findall(r"\w*Error\b", run.stderr)), run.stderr
