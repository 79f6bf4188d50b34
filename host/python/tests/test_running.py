"""How runs are made: beside other threads, ended by Ctrl-C, in memory that comes back."""

import os
import subprocess
import sys
import threading
import time

import numpy as np
import psutil
import pytest

import skyfront


def test_threads_change_nothing(sky):
    for preset in ["noise-aware", "paper-f160"]:
        one, four = (skyfront.segment(sky[0], preset=preset, threads=threads) for threads in (1, 4))
        assert one.labels.tobytes() == four.labels.tobytes() and one.front.tobytes() == four.front.tobytes()
        assert all((one.catalogue[name] == four.catalogue[name]).all() for name in ["label", "flags", "area"])


def test_the_interpreter_goes_on_meanwhile():
    image, _ = skyfront.simulate("noisy", shape=(900, 900))
    run = threading.Thread(target=skyfront.segment, args=[image])
    run.start()
    turns = 0
    while run.is_alive():
        time.sleep(0.001)
        turns += 1
    assert turns > 20


def test_many_at_once(sky):
    expected, found = skyfront.segment(sky[0]).labels.tobytes(), []
    runs = [threading.Thread(target=lambda: found.append(skyfront.segment(sky[0]).labels)) for _ in range(6)]
    for run in runs:
        run.start()
    for run in runs:
        run.join()
    assert [labels.tobytes() for labels in found] == 6 * [expected]


INTERRUPTED = """
import signal, sys, threading, time
import numpy as np
import skyfront
# A process in the background may have been started with the signal ignored.
signal.signal(signal.SIGINT, signal.default_int_handler)
image = np.tile(skyfront.simulate("noisy", shape=(1500, 1500))[0], (2, 2))
began = time.time()
threading.Timer(0.3, lambda: signal.raise_signal(signal.SIGINT)).start()
try:
    skyfront.segment(image, **{settings})
    print("finished")
except KeyboardInterrupt:
    print("interrupted", time.time() - began)
small, _ = skyfront.simulate("noisy", shape=(64, 64))
print(len(skyfront.segment(small)) >= 0)
"""


@pytest.mark.parametrize("settings", [{}, {"preset": "paper-f160", "eps": 1e-9, "threads": 2}])
def test_ctrl_c_ends_a_run(settings):
    code = INTERRUPTED.replace("{settings}", repr(settings))
    told = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120)
    words = told.stdout.split()
    assert words[0] == "interrupted" and float(words[1]) < 1.5 and words[2] == "True", told


def test_memory_comes_back_after_a_thousand_calls(sky):
    process = psutil.Process()
    small = sky[0]

    def calls(count):
        for _ in range(count):
            found = skyfront.segment(small, threads=2)
            found.catalogue, found.outlines
        return process.memory_info().rss

    before = calls(50)
    after = calls(int(os.environ.get("SKYFRONT_CALLS", 1000)))
    # A leak of one plane of a call would take 72 MB.
    assert after - before < 4 * small.nbytes * 10, (before, after)


def test_errors_leave_nothing_behind(sky):
    process = psutil.Process()
    image = np.tile(sky[0], (8, 8))

    def calls(count):
        for _ in range(count):
            with pytest.raises(skyfront.OptionError):
                skyfront.segment(image, threshold=-1)
        return process.memory_info().rss

    before = calls(10)
    assert calls(100) - before < 10 * image.nbytes


def test_python_adds_a_twentieth_at_most_to_the_time_of_a_run():
    image, _ = skyfront.simulate("noisy", shape=(2048, 2048))

    def took():
        began = time.perf_counter()
        found = skyfront.segment(image, threads=1)
        return (time.perf_counter() - began) / found.summary["engine_seconds"]

    # Both times are of one call: what else the machine does weighs on both.
    assert np.median([took() for _ in range(7)]) < 1.05
