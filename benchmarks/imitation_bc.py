"""Behaviour cloning by the library `imitation`, in an environment of its own.

    python benchmarks/imitation_bc.py pairs.npz network.npz

It needs gymnasium 0.29, which the studio does not run with, so `make bench-rl` gives it a
virtual environment and passes arrays: in go `states` and `actions`, out come the layers of the
network, `weights_0`, `biases_0`, ..., and `cpu_s`. Everything is at the library's defaults: two
layers of 32 tanh units, batches of 32; the number of epochs is chosen by a tenth of the pairs,
the last ones, held out.
"""

from __future__ import annotations

import sys
import tempfile
import time

import numpy as np
import torch
from gymnasium import spaces
from imitation.algorithms import bc
from imitation.data.types import Transitions
from imitation.util import logger

EPOCHS = 30
"""No more than this; where it is best on what was held out is kept."""


def transitions(states: np.ndarray, actions: np.ndarray) -> Transitions:
    """The pairs as the library wants them; behaviour cloning looks at nothing else."""
    count = len(states)
    return Transitions(
        obs=states,
        acts=actions,
        infos=np.array([{}] * count),
        next_obs=states,
        dones=np.zeros(count, dtype=bool),
    )


def main() -> None:
    torch.set_num_threads(1)
    torch.manual_seed(0)
    pairs = np.load(sys.argv[1])
    states, actions = pairs["states"].astype(np.float32), pairs["actions"].astype(np.float32)
    kept = len(states) * 9 // 10
    began = time.process_time()
    learner = bc.BC(
        observation_space=spaces.Box(-np.inf, np.inf, states.shape[1:]),
        action_space=spaces.Box(-1.0, 1.0, actions.shape[1:]),
        demonstrations=transitions(states[:kept], actions[:kept]),
        rng=np.random.default_rng(0),
        device="cpu",
        custom_logger=logger.configure(tempfile.mkdtemp(), format_strs=[]),
    )
    best, layers = np.inf, {}
    for _ in range(EPOCHS):
        learner.train(n_epochs=1, progress_bar=False)
        policy = learner.policy
        given, _ = policy.predict(states[kept:], deterministic=True)
        error = float(((given - actions[kept:]) ** 2).mean())
        if error < best:
            best = error
            linear = [
                one
                for one in [*policy.mlp_extractor.policy_net, policy.action_net]
                if isinstance(one, torch.nn.Linear)
            ]
            layers = {
                f"{name}_{number}": getattr(one, part).detach().numpy().copy()
                for number, one in enumerate(linear)
                for name, part in (("weights", "weight"), ("biases", "bias"))
            }
    np.savez(sys.argv[2], cpu_s=time.process_time() - began, **layers)


if __name__ == "__main__":
    main()
