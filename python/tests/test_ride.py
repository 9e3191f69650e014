"""Rides in this process: columns, digests, threads, signals, bad input."""

import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time

import numpy as np
import pytest
import twinhub

TICK_TOPICS = ["/control/output", "/plant/truth", "/rider/intent", "/rider/state", "/sensor/measurement"]


def test_columns_are_whole_and_finite(ride_and_file):
    ride, _ = ride_and_file
    assert sorted(topic for topic in ride if not topic.startswith("/link")) == TICK_TOPICS
    assert ride.metrics.ticks == 5000 and not ride.metrics.fell
    for topic in TICK_TOPICS:
        columns = ride[topic]
        assert list(columns)[0] == "t_s" and len(columns) > 1
        assert {(c.shape, c.dtype) for c in columns.values()} == {((5000,), np.dtype(np.float64))}
        np.testing.assert_allclose(columns["t_s"], np.arange(5000) * 1e-3, atol=1e-12)
    for topic in ("/plant/truth", "/rider/state"):
        for name, column in ride[topic].items():
            assert np.isfinite(column).all(), (topic, name)


def test_metrics_are_those_of_the_columns(ride_and_file):
    ride, _ = ride_and_file
    truth, rider, m = ride["/plant/truth"], ride["/rider/state"], ride.metrics
    rms = lambda x: float(np.sqrt(np.mean(x**2)))  # noqa: E731
    assert m.roll_rms_rad == pytest.approx(rms(truth["roll_rad"]), rel=1e-9) and m.roll_rms_rad > 0.0
    assert m.steer_rms_rad == pytest.approx(rms(truth["steer_rad"]), rel=1e-9)
    assert m.rider_effort_rms_nm == pytest.approx(rms(rider["steer_torque_nm"]), rel=1e-9)
    assert m.energy_j == pytest.approx(truth["battery_w"].sum() * 1e-3, rel=1e-9)
    assert m.distance_m == pytest.approx(truth["speed_m_s"].sum() * 1e-3, rel=1e-9)


def test_equal_rides_have_equal_digests_and_leave_no_file(ride_and_file, tmp_path, monkeypatch):
    ride, _ = ride_and_file
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    tempfile.tempdir = None
    again = twinhub.ride(course="three_to_eight", stabilizer=True, set=["duration_s=5.0"])
    assert again.digest == ride.digest and len(ride.digest) == 32
    assert again.stated_digest == again.digest and again.path is None
    assert again.metrics == ride.metrics
    assert list(tmp_path.iterdir()) == []
    truth, before = again["/plant/truth"], ride["/plant/truth"]
    assert all((truth[name] == before[name]).all() for name in before)


def test_stabilizer_and_seed_change_the_ride(ride_and_file):
    ride, _ = ride_and_file
    off = twinhub.ride(stabilizer=False, set={"duration_s": 5.0})
    assert off.stabilizer is False and off.digest != ride.digest
    assert (off["/plant/truth"]["front_brake_nm"] == 0.0).all()
    assert (ride["/plant/truth"]["front_brake_nm"] > 1.0).any()
    other = twinhub.ride(set={"duration_s": 5.0}, seed=ride.seed + 1)
    assert other.seed == ride.seed + 1 and other.digest != ride.digest


def test_the_command_line_rides_the_same_ride(ride_and_file, tmp_path):
    binary = os.environ.get("TWINHUB_BIN")
    if not binary:
        pytest.skip("TWINHUB_BIN does not name the twinhub command")
    command = [binary, "ride", "--in-process", "--set", "duration_s=5.0", "--json"]
    done = subprocess.run([*command, "--out", str(tmp_path)], check=True, capture_output=True, text=True)
    ride, _ = ride_and_file
    told = {run["stabilizer"]: run for run in json.loads(done.stdout)["runs"]}
    assert told["on"]["digest"] == ride.digest
    for name in ("fell", "roll_rms_rad", "rider_effort_rms_nm", "energy_j", "ticks"):
        assert told["on"][name] == getattr(ride.metrics, name), name
    theirs = twinhub.read_log(told["off"]["log"])
    assert theirs.digest == told["off"]["digest"] == theirs.stated_digest


def test_settings_reach_course_rider_and_law():
    ride = twinhub.ride(
        set={
            "duration_s": 1,
            "law": "off",
            "rider.rider.steer_torque.delay_s": 0.15,
            "speed": [{"t_s": 0.0, "speed_m_s": 6.5}],
        }
    )
    assert ride.metrics.ticks == 1000
    assert ride.config is not None
    assert "delay_s = 0.15" in ride.config
    assert (ride["/rider/state"]["wanted_speed_m_s"] == 6.5).all()


def test_a_fall_is_a_result():
    # Below its weave speed the bicycle falls, unless the rider steers: this one has no gains.
    gain = {"speed_m_s": 2.0, "roll_nm_rad": 0.0, "roll_rate_nms_rad": 0.0, "heading_nm_rad": 0.0}
    ride = twinhub.ride(
        stabilizer=False,
        set={
            "speed": [{"t_s": 0.0, "speed_m_s": 2.0}],
            "rider.rider.steer_torque.gains": [gain],
        },
    )
    assert ride.metrics.fell and ride.metrics.ticks < 60_000
    assert ride.events[-1].code == "plant.fell" and ride.events[-1].level == "error"


def test_other_threads_go_on_during_a_ride():
    passed = []
    thread = threading.Thread(target=lambda: passed.append(twinhub.ride(set={"duration_s": 20.0})))
    thread.start()
    turns = 0
    while thread.is_alive():
        turns += 1
        time.sleep(0.001)
    assert passed[0].metrics.ticks == 20_000
    # With the interpreter's lock held throughout, the loop would not turn.
    assert turns > 5


def test_ctrl_c_stops_a_ride_and_keeps_the_log(tmp_path):
    log = tmp_path / "cut.mcap"
    # An hour of ride: only the signal ends it.
    code = f"import twinhub; twinhub.ride(set={{'duration_s': 36000.0}}, log={str(log)!r})"
    process = subprocess.Popen([sys.executable, "-c", code], stderr=subprocess.PIPE, text=True)
    try:
        while not log.exists() or log.stat().st_size < 1_000_000:
            assert process.poll() is None, process.stderr.read()
            time.sleep(0.02)
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=120)
    finally:
        process.kill()
    assert errors.rstrip().endswith("KeyboardInterrupt"), errors
    cut = twinhub.read_log(log)
    assert not cut.recovered and cut.stated_digest == cut.digest
    # The torques were ramped out before the end.
    brake_nm = cut["/plant/truth"]["front_brake_nm"]
    assert brake_nm.max() > 1.0 and brake_nm[-1] == 0.0


@pytest.mark.parametrize(
    "arguments, message",
    [
        ({"course": "last_ride"}, "first_ride"),
        ({"course": 3}, "a name or a path"),
        ({"stabilizer": "off"}, "True or False"),
        ({"seed": -1}, "an integer from 0"),
        ({"seed": 1.5}, "an integer from 0"),
        ({"set": {"duration": 3.0}}, r"^set duration=3.0: no `duration` .*duration_s"),
        ({"set": {"duration_s": float("nan")}}, "duration_s"),
        ({"set": {"duration_s": "long"}}, "duration_s"),
        ({"set": {"rider": "nobody"}}, "older_6_to_7"),
        ({"set": {"law": "nolaw"}}, "scheduled"),
        ({"set": ["duration_s"]}, "path=value"),
    ],
)
def test_bad_input_says_what_is_accepted(arguments, message):
    with pytest.raises(twinhub.InputError, match=message):
        twinhub.ride(**arguments)


def test_a_bad_course_file_is_named_with_the_place(tmp_path):
    course = tmp_path / "mine.toml"
    course.write_text("schema_version = 1\nlength_s = 3.0\n")
    with pytest.raises(twinhub.InputError, match=r"(?s)mine\.toml.*line 2.*length_s"):
        twinhub.ride(course=course)


def test_a_log_that_cannot_be_written_is_an_error(tmp_path):
    with pytest.raises(twinhub.LogError, match="no_such_directory"):
        twinhub.ride(log=tmp_path / "no_such_directory" / "on.mcap")
