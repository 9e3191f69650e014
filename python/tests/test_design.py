"""Schedules with a proof: as the command makes them, and refused where they should be."""

import json
import os
import subprocess

import numpy as np
import pytest
import twinhub

NARROW = {"mass": 0.02, "load": 0.02, "twisting": (0.95, 1.05), "speeds_m_s": np.arange(7.0, 8.01, 0.25)}


@pytest.fixture(scope="module")
def design_and_heard():
    heard = []
    return twinhub.design(**NARROW, progress=heard.append), heard


def test_a_narrow_schedule_is_proved(design_and_heard):
    design, heard = design_and_heard
    assert design.cells_proved.all() and design.proved_m_s == [(7.0, 8.0)]
    assert design.torque_nm.max() > 5.0 and design.torque_nm[-1] == 0.0
    assert (design.from_nm <= design.torque_nm).all() and (design.torque_nm <= design.to_nm).all()
    assert (design.growth_per_s < 0.0).all()
    assert heard and all(" of " in text for text in heard)
    assert "7 to 8 m/s" in repr(design) and "<table>" in design._repr_html_()


@pytest.mark.skipif("TWINHUB_BIN" not in os.environ, reason="no twinhub command to compare with")
def test_the_command_certifies_it_and_makes_the_same(design_and_heard, tmp_path):
    design, _ = design_and_heard
    law = design.save(tmp_path / "law.toml")
    command = os.environ["TWINHUB_BIN"]
    certified = subprocess.run([command, "certify", law, "--json"], capture_output=True, text=True)
    assert json.loads(certified.stdout)["verdict"] == "holds", certified
    arguments = ["--mass=0.02", "--load=0.02", "--twisting=0.95:1.05", "--speeds-m-s=7:8:0.25", "--json"]
    theirs = subprocess.run([command, "design", *arguments], capture_output=True, text=True, check=True)
    assert [p["torque_nm"] for p in json.loads(theirs.stdout)["schedule"]] == design.torque_nm.tolist()


def test_what_cannot_be_asked_for_is_said(design_and_heard, tmp_path):
    with pytest.raises(twinhub.InputError, match="mass 2: accepted: 0 to 0.9"):
        twinhub.design(mass=2.0)
    with pytest.raises(twinhub.InputError, match="rider `nobody`: accepted: young"):
        twinhub.design(riders=["nobody"])
    with pytest.raises(twinhub.InputError, match="accepted: its file"):
        twinhub.design(twinhub.Bicycle("bulsink2017_bicycle1_full", set={"geometry.trail_m": 0.06}))
    with pytest.raises(twinhub.InputError, match="ends in .toml"):
        design_and_heard[0].save(tmp_path / "law.json")
