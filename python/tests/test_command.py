"""The command and the package give the same numbers."""

import json
import os
import subprocess

import pytest
import twinhub


@pytest.fixture(scope="module")
def command(tmp_path_factory):
    binary = os.environ.get("TWINHUB_BIN")
    if not binary:
        pytest.skip("TWINHUB_BIN does not name the twinhub command")
    where = tmp_path_factory.mktemp("command")

    def run(*arguments):
        done = subprocess.run([binary, *arguments, "--json"], capture_output=True, text=True, cwd=where, check=False)
        assert done.returncode in (0, 1), done.stderr
        return json.loads(done.stdout)

    return run


def test_a_map_is_that_of_the_command(command):
    told = command("map", "--speeds-m-s", "4:8:2", "--torques-nm", "0:80:40")
    found = twinhub.stability_map(speeds_m_s=[4.0, 6.0, 8.0], torques_nm=[0.0, 40.0, 80.0], workers=1)
    assert found.growth_1_s.tolist() == told["growth_1_s"]
    assert found.slow_growth_1_s.tolist() == told["slow_growth_1_s"]


def test_a_league_is_that_of_the_command(command):
    told = command("league", "--riders", "1", "--classes", "older", "--duration-s", "10", "--controllers", "constant")
    found = twinhub.league(1, classes=["older"], duration_s=10.0, controllers=["constant"])
    assert found.rows == told["rows"]
    assert found.frontier == told["frontier"]
