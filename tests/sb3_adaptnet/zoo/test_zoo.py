"""rl_zoo3 with the native worlds."""

from toy_zoo import conf, run_command


def test_rl_zoo3_trains_natively_and_enjoys(tmp_path):
    common = ["--algo", "ppo", "--env", "Toy-v0", "--gym-packages", "toy_env", "sb3_adaptnet.zoo", "-f", str(tmp_path)]
    train = run_command(["rl_zoo3.train", *common, "--conf-file", conf(tmp_path), "--eval-freq", "-1", "--seed", "0"])
    said = train.communicate(timeout=300)[0]
    assert train.returncode == 0, said
    assert "imitation_reward" in said and "Using 8 environments" in said
    assert (tmp_path / "ppo" / "Toy-v0_1" / "Toy-v0.zip").is_file()
    enjoy = run_command(["rl_zoo3.enjoy", *common, "--no-render", "-n", "50", "--num-threads", "1"])
    said = enjoy.communicate(timeout=300)[0]
    assert enjoy.returncode == 0 and "Episode Reward" in said, said
