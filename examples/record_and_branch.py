"""Record a run, verify it, and continue from its middle, once unchanged and once with a different force.

Run it with `python examples/record_and_branch.py`; it writes three logs to the current folder.
"""

import numpy as np

import granular_env as ge


def main() -> dict[str, float]:
    chain = ge.make("chain", grains=60, radius=3e-3, material="steel")
    push = ge.Profile.half_sine(peak=500.0, duration=4e-5)
    with ge.record(chain, "parent.mcap", every=1e-6, variables=["displacement", "velocity"], overwrite=True):
        chain.step(4e-4, left_force=push)
    verification = ge.verify("parent.mcap")

    parent = ge.open_log("parent.mcap")
    same = parent.branch(2e-4).run("same.mcap", overwrite=True)
    other = parent.branch(2e-4).run("other.mcap", {"left_force": 200.0}, overwrite=True)
    end = parent.get("velocity", 4e-4)
    return {
        "internal steps compared": verification.ticks,
        "identical": verification.identical,
        "bits of the final state changed by the unchanged branch": np.count_nonzero(same.get("velocity", 4e-4) != end),
        "grains reached by the other push": np.count_nonzero(other.get("velocity", 4e-4) != end),
    }


if __name__ == "__main__":
    for name, value in main().items():
        print(f"{name}: {value}")
