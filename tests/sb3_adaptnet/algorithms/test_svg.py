"""SVG learns, saves, loads, goes on and repeats itself, as every Stable-Baselines3 algorithm does."""

import numpy as np
import pytest
import torch
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.logger import configure
from stable_baselines3.common.policies import ActorCriticPolicy
from world_cases import CHARACTER

from sb3_adaptnet import AdaptNetPolicy, AdaptVecEnv
from sb3_adaptnet.algorithms.svg import SVG
from sb3_adaptnet.world_model.character import Character


def weights(model):
    return torch.cat([p.detach().flatten() for p in model.policy.actor.parameters()])


def test_learning_changes_policy_and_model(make_svg, tiny_world):
    model = make_svg()
    before = weights(model).clone()
    model.learn(96)
    assert model.num_timesteps == 96
    assert not torch.equal(weights(model), before)
    pairs = zip(model.world_model.parameters(), tiny_world.parameters(), strict=True)
    assert any(not torch.equal(a, b) for a, b in pairs)


def test_the_base_stays_frozen(make_svg):
    model = make_svg()
    base = [p.clone() for p in model.policy.actor.base.parameters()]
    model.learn(48)
    assert all(torch.equal(a, b) for a, b in zip(model.policy.actor.base.parameters(), base, strict=True))


def test_the_same_seed_gives_the_same_weights(make_svg):
    first, again, other = (weights(make_svg(seed=seed).learn(96)) for seed in (1, 1, 2))
    assert torch.equal(first, again)
    assert not torch.equal(first, other)


def test_a_saved_model_acts_alike_and_goes_on(make_svg, tmp_path):
    model = make_svg().learn(96)
    model.save(tmp_path / "model")
    loaded = SVG.load(tmp_path / "model", env=model.env, device="cpu")
    observations = model.env.reset()
    assert np.array_equal(*(m.predict(observations, deterministic=True)[0] for m in (model, loaded)))
    for name, tensor in model.world_model.state_dict().items():
        assert torch.equal(tensor, loaded.world_model.state_dict()[name])
    assert loaded.world_optimizer.state_dict()["state"].keys() == model.world_optimizer.state_dict()["state"].keys()
    loaded.learn(48, reset_num_timesteps=False)
    assert loaded.num_timesteps == 144
    assert SVG.load(tmp_path / "model", device="cpu").env is None


def test_settings_given_anew_are_checked_and_what_stays_stays(make_svg, tmp_path):
    model = make_svg(episodes={"steps": (2, 5)})
    model.save(tmp_path / "model")
    loaded = SVG.load(tmp_path / "model", device="cpu", guiding={"turn_rate": 2.0}, window=3)
    assert (loaded.guiding.turn_rate, loaded.window, loaded.episodes.steps) == (2.0, 3, (2, 5))
    for wrong, words in (
        ({"episodes": {"step": (2, 5)}}, "Episodes has no 'step'"),
        ({"loss_weights": {"gaol": 1.0}}, "LossWeights has no 'gaol'"),
        ({"window": 9}, "window is 9, expected 1 to n_steps"),
        ({"mirror": "no"}, "mirror is 'no'"),
        ({"average_decay": 7}, "average_decay must be a number that is at least 0 and below 1, not 7"),
        ({"regression_updates": -3}, "regression_updates is -3"),
        ({"world_model": "new"}, "a saved model has its own world model"),
    ):
        with pytest.raises(ValueError, match=words):
            SVG.load(tmp_path / "model", env=model.env, device="cpu", **wrong).learn(16)


def test_a_saved_model_does_not_go_on_in_another_body(make_svg, tmp_path):
    make_svg().save(tmp_path / "model")
    other = AdaptVecEnv("AdaptNet/Humanoid-LongShinsWalk-v0", num_envs=2, num_threads=1)
    loaded = SVG.load(tmp_path / "model", env=other, device="cpu")
    with pytest.raises(ValueError, match="the worlds have another body"):
        loaded.learn(16)


def test_goals_lie_afterwards_where_they_did_before(make_svg):
    model = make_svg(episodes={"goal_spread": 0.15, "loose_goal_spread": 0.3})
    model.env.set_attr("goal_spread", 0.7)
    seen = []

    class Spreads(BaseCallback):
        def _on_step(self):
            seen.append(self.training_env.get_attr("goal_spread"))
            return len(seen) < 3

    model.learn(480, callback=Spreads())
    assert seen[0] == [0.3] * 3 + [0.15] * 3
    assert model.env.get_attr("goal_spread") == [0.7] * 6


def test_a_progress_bar_knows_how_much_is_left(make_svg):
    class Asked(BaseCallback):
        def _on_training_start(self):
            self.asked = self.locals["total_timesteps"] - self.model.num_timesteps

        def _on_step(self):
            return True

    asked, model = Asked(), make_svg()
    for more in (96, 48):
        model.learn(more, callback=asked, reset_num_timesteps=False)
        assert asked.asked == more


def test_the_log_says_what_happened(make_svg, tmp_path):
    model = make_svg(episodes={"steps": (2, 5)})
    model.set_logger(configure(str(tmp_path), ["csv"]))
    model.learn(96)
    names = (tmp_path / "progress.csv").read_text().splitlines()[0].split(",")
    wanted = {"svg/tracking", "svg/travel", "svg/smoothness", "svg/gradient_norm", "svg/model_loss",
              "rollout/tracking_error", "rollout/episode_steps", "time/fps", "time/total_timesteps"}  # fmt: skip
    assert wanted <= set(names)


def test_callbacks_see_every_step_and_may_stop(make_svg):
    class Counter(BaseCallback):
        def _on_step(self):
            assert self.locals["step"].rewards.shape == (6,)
            return self.n_calls < 11

    counter = Counter()
    model = make_svg().learn(480, callback=counter)
    assert counter.n_calls == 11
    assert model.num_timesteps == 66


def test_schedules_follow_the_samples(make_svg):
    model = make_svg(episodes={"error_limit": {0: 0.4, 96: 0.2}})
    model.learn(96)
    assert model.policy.optimizer.param_groups[0]["lr"] == pytest.approx(1e-3 + (1e-4 - 1e-3) * 0.96)
    assert model._worlds.error_limit == pytest.approx(0.3)


def test_another_body_has_its_own_kinematics(make_svg):
    model = make_svg(environment="AdaptNet/Humanoid-LongShinsWalk-v0")
    assert model.world_model.character == Character.of(model.env.simulation.model) != CHARACTER
    model.learn(48)


def test_what_does_not_fit_is_refused(make_svg, walk_base, tiny_world):
    with pytest.raises(ValueError, match="window is 9, expected 1 to n_steps, which is 8"):
        make_svg(window=9)
    with pytest.raises(ValueError, match="symmetry 10.0 is of what is done in the mirror, so mirror must be True"):
        make_svg(loss_weights={"symmetry": 10.0})
    with pytest.raises(ValueError, match="other joints"):
        make_svg(environment="AdaptNet/Humanoid-LockedElbowsWalk-v0")
    with pytest.raises(ValueError, match="without a heightmap"):
        make_svg(environment="AdaptNet/Humanoid-TerrainHills-v0")
    env = AdaptVecEnv("AdaptNet/Humanoid-Walk-v0", num_envs=2, num_threads=1)
    with pytest.raises(ValueError, match="tiny.world.safetensors"):
        SVG(AdaptNetPolicy, env, policy_kwargs={"base": str(walk_base)})
    with pytest.raises(ValueError, match=r"'Walk' holds no gait cycle at 9\.00 m/s"):
        make_svg(environment="AdaptNet/Humanoid-Walk-v0", guiding={"gaits": [9.0]})
    with pytest.raises(ValueError, match="'GooseStep' is one gait cycle"):
        make_svg(environment="AdaptNet/Humanoid-GooseStep-v0", guiding={"gaits": [1.0]})
    with pytest.raises(ValueError, match="AdaptNetPolicy"):
        SVG(ActorCriticPolicy, env, tiny_world)


def test_the_task_itself_can_be_a_cost(make_svg):
    without, asked = make_svg(), make_svg(loss_weights={"goal": 1.0})
    names = []
    for model in (without, asked):
        model.learn(48, log_interval=None)
        names.append({name for name in model.logger.name_to_value if name.startswith("svg/")})
    assert names[1] - names[0] == {"svg/goal"}
