"""Leagues: shards, executors, laws in Python."""

import concurrent.futures

import pytest
import twinhub

SMALL = {"riders": 2, "classes": ["older"], "duration_s": 10.0}


class Gentle:
    """A law of one's own: grows with slowness, and remembers."""

    def __init__(self):
        self.last = 0.0

    def __call__(self, estimate, dt_s):
        wanted = max(0.0, 9.0 - estimate.speed_m_s) * 2.0
        self.last += max(-5.0 * dt_s, min(5.0 * dt_s, wanted - self.last))
        return self.last


@pytest.fixture(scope="module")
def whole():
    return twinhub.league(controllers=["constant"], **SMALL)


def test_shards_and_executors_give_the_same(whole):
    shards = [twinhub.league(controllers=["constant"], shard=(i, 2), **SMALL) for i in (1, 2)]
    assert twinhub.merge_leagues(reversed(shards)).parts == whole.parts
    with concurrent.futures.ProcessPoolExecutor(2) as executor:
        there = twinhub.league(controllers=["constant"], executor=executor, **SMALL)
    assert there.parts == whole.parts and there.rows == whole.rows


def test_dask_runs_it(whole):
    distributed = pytest.importorskip("distributed")
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
        client.get_executor() as executor,
    ):
        there = twinhub.league(controllers=["constant"], executor=executor, **SMALL)
    assert there.parts == whole.parts


def test_rows_have_intervals(whole):
    row = whole.row("constant", "older")
    energy = row["energy_wh_per_km"]
    assert energy["ci95"][0] <= energy["value"] <= energy["ci95"][1] and energy["value"] > 0.0
    assert whole.row("off", "older")["energy_wh_per_km"]["value"] == pytest.approx(0.0, abs=1e-6)
    assert {"falls_per_1000_km", "rider_effort_rms_nm", "roll_rms_rad"} <= set(row)
    assert "<svg" in whole._repr_html_()
    with pytest.raises(twinhub.InputError, match="older"):
        whole.row("constant", "younger")


def test_a_law_in_python_competes():
    told = []
    league = twinhub.league(
        controllers={"gentle": Gentle, "constant": "constant"},
        progress=lambda done, of: told.append((done, of)),
        **SMALL,
    )
    energy = {name: league.row(name, "older")["energy_wh_per_km"]["value"] for name in ("gentle", "constant")}
    assert 0.0 < energy["gentle"] < energy["constant"]
    assert told[-1] == (2, 2)


def test_bad_input_is_refused(whole):
    with pytest.raises(twinhub.InputError, match="old_firm"):
        twinhub.league(classes=["old_firm"])
    with pytest.raises(twinhub.InputError, match="shard"):
        twinhub.league(shard=(3, 2), **SMALL)
    with pytest.raises(twinhub.InputError, match="no_such"):
        twinhub.league(controllers=["no_such"], **SMALL)
    with pytest.raises(twinhub.InputError, match="seed"):
        twinhub.merge_leagues([whole, twinhub.league(controllers=["constant"], seed=2, **SMALL)])

    with pytest.raises(twinhub.InputError, match="measured against"):
        twinhub.league(controllers={"off": Gentle}, **SMALL)
    with pytest.raises(twinhub.InputError, match="twice"):
        twinhub.league(controllers=["a/constant.toml", "constant"], **SMALL)

    def broken():
        raise KeyError("mine")

    with pytest.raises(KeyError, match="mine"):
        twinhub.league(controllers={"broken": broken}, **SMALL)
