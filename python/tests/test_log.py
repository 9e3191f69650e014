"""Reading logs: whole, cut off, wrong, and by the official MCAP packages."""

import numpy as np
import pytest
import twinhub
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory


def test_the_file_holds_what_the_ride_gave(ride_and_file):
    ride, path = ride_and_file
    log = twinhub.read_log(path)
    assert log.digest == ride.digest == log.stated_digest
    assert not log.recovered and log.recovery is None and not log.undecoded
    assert ride.path == log.path == path
    assert list(log) == list(ride) and len(log) == len(ride)
    for topic, columns in ride.items():
        assert list(log[topic]) == list(columns)
        for name, column in columns.items():
            assert np.array_equal(log[topic][name], column, equal_nan=True), (topic, name)
    about = log.metadata["twinhub"]
    assert about["version"] == twinhub.__version__ and about["seed"] == str(ride.seed)
    assert log.metadata["twinhub_end"]["digest"] == ride.digest
    assert log.config is not None and "duration_s = 5.0" in log.config
    assert log.attachments["config.toml"].decode() == log.config


def test_events_are_read(ride_and_file):
    events = twinhub.read_log(ride_and_file[1]).events
    assert any(e.code == "supervisor.mode" and e.level == "info" for e in events)
    assert [e.t_s for e in events] == sorted(e.t_s for e in events)


def test_unknown_topics_and_columns_list_what_there_is(ride_and_file):
    ride, _ = ride_and_file
    with pytest.raises(twinhub.UnknownNameError, match="/plant/truth") as caught:
        ride["/plant/thruth"]
    assert isinstance(caught.value, (KeyError, twinhub.InputError))
    with pytest.raises(twinhub.UnknownNameError, match="roll_rad, steer_rad"):
        ride["/plant/truth"]["roll_deg"]
    assert "/plant/thruth" not in ride and ride.get("/plant/thruth") is None


def test_a_log_that_was_cut_off_opens(ride_and_file, tmp_path):
    ride, path = ride_and_file
    whole = path.read_bytes()
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(whole[: len(whole) * 3 // 5])
    log = twinhub.read_log(cut)
    assert log.recovered and log.stated_digest is None
    assert log.recovery is not None and log.recovery.reason
    assert log.recovery.used_bytes + log.recovery.lost_bytes == cut.stat().st_size
    kept = log["/plant/truth"]
    n = len(kept["t_s"])
    assert 1000 < n < 5000
    for name, column in kept.items():
        assert (column == ride["/plant/truth"][name][:n]).all()


@pytest.mark.parametrize(
    "content, message",
    [
        (None, "cannot read the log"),
        (b"", "it is empty"),
        (b"t_s,roll_rad\n0.0,0.1\n", "is not an MCAP log: it begins with the text"),
        (b"\x89MCAP0\r\n", "nothing can be recovered"),
        (b"\x89MCAP0\r\n" + bytes(range(256)) * 40, "nothing can be recovered"),
    ],
)
def test_what_is_no_log_is_said(tmp_path, content, message):
    file = tmp_path / "some.mcap"
    if content is not None:
        file.write_bytes(content)
    with pytest.raises(twinhub.LogError, match=message) as caught:
        twinhub.read_log(file)
    assert "some.mcap" in str(caught.value)
    assert isinstance(caught.value, OSError)


def test_a_directory_is_no_log(tmp_path):
    with pytest.raises(twinhub.LogError, match="cannot read the log"):
        twinhub.read_log(tmp_path)


def test_the_official_packages_read_the_same_numbers(ride_and_file):
    ride, path = ride_and_file
    count = dict.fromkeys(ride, 0)
    roll_sum = 0.0
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        for _, channel, message, decoded in reader.iter_decoded_messages(topics=list(ride)):
            topic = channel.topic
            i = count[topic]
            count[topic] += 1
            if topic == "/plant/truth":
                assert decoded.roll_rad == ride[topic]["roll_rad"][i]
                assert message.publish_time == round(ride[topic]["t_s"][i] * 1e9)
                roll_sum += decoded.roll_rad
            if topic == "/control/output":
                assert decoded.mode == ride[topic]["mode"][i]
    assert count == {topic: len(columns["t_s"]) for topic, columns in ride.items()}
    assert roll_sum != 0.0
