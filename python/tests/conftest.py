"""Rides that several tests look at."""

import pytest
import twinhub


@pytest.fixture(scope="session")
def ride_and_file(tmp_path_factory):
    """Five seconds of the first ride, stabilizer on, and its log."""
    path = tmp_path_factory.mktemp("ride") / "on.mcap"
    return twinhub.ride(set={"duration_s": 5.0}, log=path), path
