"""The Gymnasium environment passes its checker."""

import numpy as np
import pytest

gymnasium = pytest.importorskip("gymnasium")
from twinhub.gym import StabilizerEnv  # noqa: E402

SHORT = {"duration_s": 3.0}


@pytest.mark.filterwarnings("ignore")
def test_the_checker_passes():
    from gymnasium.utils.env_checker import check_env

    check_env(StabilizerEnv(set=SHORT), skip_render_check=True)


def test_an_episode_ends_with_the_course_and_repeats_with_its_seed():
    def episode(seed):
        env = StabilizerEnv(set=SHORT)
        seen, info = env.reset(seed=seed)
        rows, over = [seen], False
        while not over:
            seen, reward, fell, over, info = env.step(np.array([1.0], dtype=np.float32))
            rows.append(seen)
            assert not fell and reward <= 0.0
        return np.array(rows), info

    (first, info), (again, _), (other, _) = episode(5), episode(5), episode(6)
    assert np.array_equal(first, again) and not np.array_equal(first, other)
    assert first.shape == (151, 7) and first[-1, 6] > 5.0, "the pair ramps up"
    assert info["metrics"]["ticks"] == 3000 and info["t_s"] == pytest.approx(3.0)


def test_bad_input_is_refused():
    import twinhub

    with pytest.raises(twinhub.InputError, match="pair_max_nm"):
        StabilizerEnv(pair_max_nm=0.0)
    with pytest.raises(twinhub.InputError, match="reset"):
        StabilizerEnv(set=SHORT).step(np.zeros(1, dtype=np.float32))
