"""Effects that a third simulator hides are found, and nothing where there is nothing."""

import importlib.util
from pathlib import Path

import pytest
import twinhub

spec = importlib.util.spec_from_file_location("other_simulator", Path(__file__).parent / "other_simulator.py")
assert spec is not None and spec.loader is not None
other_simulator = importlib.util.module_from_spec(spec)
spec.loader.exec_module(other_simulator)

# Effect, parameter and size.
HIDDEN = [
    ("steer_damping", "nms_rad", 0.8),
    ("roll_rate_sensor_delay", "s", 0.02),
    ("lateral_offset", "kg_m", 1.0),
    ("crosswind", "m_s", 5.0),
]


@pytest.fixture(scope="module")
def studies(tmp_path_factory):
    cases = [{}, *({name: size} for name, _, size in HIDDEN)]
    return other_simulator.Rides(cases, seed=1).write(tmp_path_factory.mktemp("rides"))


def test_nothing_is_found_where_nothing_is_hidden(studies):
    assert twinhub.diagnose(studies[0]).verdict == "no_effect"


@pytest.mark.parametrize("case", range(len(HIDDEN)), ids=[h[0] for h in HIDDEN])
def test_what_is_hidden_is_found_with_its_size(studies, case):
    name, parameter, size = HIDDEN[case]
    found = twinhub.diagnose(studies[1 + case])
    assert found.verdict == "cause", found
    assert name in found.causes[0]["set"], found
    if found.causes[0]["mechanism"] == name:
        assert found.causes[0]["parameters"][parameter]["value"] == pytest.approx(size, rel=0.15)
