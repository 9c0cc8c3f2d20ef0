"""Welds as environments of Gymnasium."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

gymnasium = pytest.importorskip("gymnasium")

from gymnasium.utils.env_checker import check_env  # noqa: E402

import trueweld.gym  # noqa: E402


@pytest.mark.filterwarnings("error")
def test_the_environment_keeps_the_rules_of_gymnasium(place: Path) -> None:
    check_env(trueweld.gym.WeldEnv(weld="short.toml", periods=20), skip_render_check=True)


def test_an_episode_is_a_weld(place: Path) -> None:
    env = gymnasium.make("trueweld/Weld-v0", weld="short.toml", periods=50, directions=("y", "rx"))
    observation, info = env.reset(seed=3)
    steps, done = 0, False
    while not done:
        observation, reward, terminated, truncated, info = env.step(env.action_space.sample() * 0)
        assert env.observation_space.contains(observation) and reward <= 0 and not truncated
        steps, done = steps + 1, terminated
    assert 5 < steps < 50 and abs(info["deviation_m"][1]) > 1e-4


def test_the_vector_form_is_its_environments_side_by_side(place: Path) -> None:
    options = {"weld": "short.toml", "periods": 40}
    vector = trueweld.gym.WeldVectorEnv(3, **options)
    single = trueweld.gym.WeldEnv(**options)
    observations, _ = vector.reset(seed=11)
    assert observations.shape == vector.observation_space.shape
    alone, _ = single.reset(seed=12)
    assert np.array_equal(observations[1], alone)
    over = np.zeros(3, dtype=bool)
    for k in range(40):
        actions = np.full((3, 1), 0.01 * k, dtype=np.float32)
        was_over = over
        observations, rewards, over, truncated, infos = vector.step(actions)
        if not was_over[1]:
            alone, reward, done, _, info = single.step(actions[1])
            assert np.array_equal(observations[1], alone) and rewards[1] == reward and over[1] == done
            assert np.array_equal(infos["deviation_m"][1], info["deviation_m"])
        else:
            # The weld begins anew in the step behind the last one.
            assert rewards[1] == 0.0 and not over[1]
            break
    else:
        pytest.fail("no weld was over")


def test_wrong_options(place: Path) -> None:
    with pytest.raises(ValueError, match="directions"):
        trueweld.gym.WeldEnv(directions=("z",))
    with pytest.raises(ValueError, match="periods"):
        trueweld.gym.WeldEnv(periods=0)
    with pytest.raises(ValueError, match="num_envs"):
        trueweld.gym.WeldVectorEnv(0)
