"""Many rides: the same numbers as one by one, on any number of threads, interruptible."""

import os
import signal
import threading
import time

import numpy as np
import pytest
import twinhub

SHORT = {"duration_s": 2.0}


def test_a_batch_is_the_rides_one_by_one():
    rides = twinhub.batch(seeds=[3, 4], set=SHORT, vary=[{}, {"law": "constant"}])
    assert rides["seed"].tolist() == [3, 4, 3, 4]
    one = twinhub.ride(set={**SHORT, "law": "constant"}, seed=4)
    for name, values in rides.items():
        if name != "seed":
            assert values.shape == (4,)
            assert values[3] == getattr(one.metrics, name), name
    again = twinhub.batch(seeds=[3, 4], set=SHORT, vary=[{}, {"law": "constant"}], workers=1)
    assert all(np.array_equal(rides[name], again[name]) for name in rides)


def test_progress_counts_up_to_all():
    told = []
    twinhub.batch(seeds=range(6), set=SHORT, progress=lambda done, of: told.append((done, of)))
    assert told and told[-1] == (6, 6) and told == sorted(told)


def test_pandas_takes_it_as_it_is():
    pandas = pytest.importorskip("pandas")
    frame = pandas.DataFrame(twinhub.batch(seeds=range(2), set=SHORT))
    assert list(frame.seed) == [0, 1] and frame.fell.dtype == bool


def test_a_ride_that_cannot_be_set_up_is_named():
    with pytest.raises(twinhub.InputError, match="ride 1.*duration_s"):
        twinhub.batch(set=SHORT, vary=[{}, {"duration_s": -1.0}])
    with pytest.raises(twinhub.InputError, match="workers"):
        twinhub.batch(set=SHORT, workers=0)
    with pytest.raises(twinhub.UnknownNameError, match="roll_rms_rad"):
        twinhub.batch(set=SHORT)["roll_rms_deg"]


def test_what_progress_raises_ends_the_batch():
    def broken(done, of):
        raise RuntimeError("enough")

    begun = time.monotonic()
    with pytest.raises(RuntimeError, match="enough"):
        twinhub.batch(seeds=range(2000), set={"duration_s": 20.0}, progress=broken)
    assert time.monotonic() - begun < 60.0


def test_ctrl_c_ends_the_batch():
    timer = threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        twinhub.batch(seeds=range(5000), set={"duration_s": 20.0})
    timer.join()


def test_memory_does_not_grow_with_the_number_of_rides():
    def resident_kb():
        with open("/proc/self/statm", encoding="ascii") as file:
            return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") // 1024

    quick = {"duration_s": 0.2}
    twinhub.batch(seeds=range(50), set=quick)
    before = resident_kb()
    twinhub.batch(seeds=range(300), set=quick)
    assert resident_kb() - before < 20_000


def test_it_shows_itself():
    html = twinhub.batch(seeds=range(2), set=SHORT)._repr_html_()
    assert "2 rides" in html and "roll_rms_rad" in html
