"""Ctrl-C, what a callback raises, and what a law or a rider must not give: one clear end each, soon."""

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest
import twinhub

#: Far below the length of the work, far above what an end takes.
SOON_S = 10.0


class Told(Exception):
    """What a callback raises."""


def interrupted(work):
    timer = threading.Timer(0.7, os.kill, (os.getpid(), signal.SIGINT))
    start = time.monotonic()
    timer.start()
    try:
        with pytest.raises(KeyboardInterrupt):
            work()
    finally:
        timer.cancel()
    assert time.monotonic() - start < SOON_S


def test_ctrl_c_ends_a_league():
    interrupted(lambda: twinhub.league(riders=500, controllers=["constant"], duration_s=600.0))


def test_ctrl_c_ends_a_map():
    speeds, torques = np.linspace(1.0, 10.0, 5000), np.linspace(0.0, 100.0, 200)
    interrupted(lambda: twinhub.stability_map(speeds_m_s=speeds, torques_nm=torques))


def test_a_progress_that_raises_ends_a_league_and_is_not_called_again():
    calls = []

    def progress(done, of):
        calls.append(done)
        raise Told

    with pytest.raises(Told):
        twinhub.league(riders=50, classes=["published"], controllers=["constant"], duration_s=10.0, progress=progress)
    assert len(calls) == 1


def test_a_law_that_raises_ends_a_league_with_that_tick():
    class Broken:
        def __call__(self, estimate, dt_s):
            raise Told

    start = time.monotonic()
    with pytest.raises(Told):
        twinhub.league(riders=200, controllers={"broken": Broken}, duration_s=600.0)
    assert time.monotonic() - start < 10 * SOON_S


@pytest.mark.parametrize("given", [float("nan"), float("inf"), (1.0, float("nan")), "much", None])
def test_a_law_gives_finite_numbers(given):
    with pytest.raises(twinhub.InputError, match="law gave"):
        twinhub.ride(set={"duration_s": 1.0}, law=lambda x, dt_s: given)


def test_progress_of_a_batch_is_not_called_again_after_it_raised():
    calls = []

    def progress(done, of):
        calls.append(done)
        raise Told

    with pytest.raises(Told):
        twinhub.batch(seeds=range(40), set={"duration_s": 5.0}, progress=progress)
    assert len(calls) == 1


def test_an_experiment_ends_when_its_progress_raises():
    data = Path(__file__).parents[3] / "shared" / "data" / "davis_instrumented_105"
    if not data.is_dir():
        pytest.skip(f"no measured data in {data}")
    calls = []

    def progress(text):
        calls.append(text)
        raise Told

    for work in (twinhub.experiment, twinhub.diagnose):
        with pytest.raises(Told):
            work("davis_instrumented_105", data=data, progress=progress)
    assert len(calls) == 2


def test_ctrl_c_leaves_nothing_running():
    code = (
        "import threading, os, signal, twinhub\n"
        "threading.Timer(1.0, os.kill, (os.getpid(), signal.SIGINT)).start()\n"
        "twinhub.league(riders=500, controllers=['constant'], duration_s=600.0)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode != 0 and "KeyboardInterrupt" in done.stderr
