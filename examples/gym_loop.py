"""A manual policy in `granular_env/Piston-v1`, recorded like any run, with a verified log of the episode.

Run it with `python examples/gym_loop.py`; it writes a log to the current folder.
"""

import gymnasium as gym

import granular_env as ge

PUSH, CONTROL_STEPS = 0.24, 12  # 2.4 m/s for 18 us


def main() -> dict[str, float]:
    env = gym.make("granular_env/Piston-v1", grains=64)
    total, count, over = 0.0, 0, False
    info = {}
    with ge.record(env.unwrapped.component, "episode.mcap", overwrite=True):
        env.reset(seed=0)
        while not over:
            _, reward, terminated, truncated, info = env.step([PUSH if count < CONTROL_STEPS else 0.0])
            total, count, over = total + float(reward), count + 1, terminated or truncated
    return {
        "return": total,
        "closeness to the target of 5 m/s": info["closeness"],
        "control steps": count,
        "identical": ge.verify("episode.mcap").identical,
    }


if __name__ == "__main__":
    for name, value in main().items():
        print(f"{name}: {value}")
