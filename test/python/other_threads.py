"""Whether other threads of Python run meanwhile."""

import threading
import time


def most_counted_during(work, times):
    """The largest number to which another thread counts while work() is done once."""
    stop, counted = threading.Event(), [0]

    def count():
        while not stop.is_set():
            counted[0] += 1
            time.sleep(0)

    thread = threading.Thread(target=count)
    thread.start()
    most = 0
    try:
        for _ in range(times):
            before = counted[0]
            work()
            most = max(most, counted[0] - before)
    finally:
        stop.set()
        thread.join()
    return most
