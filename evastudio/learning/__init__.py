"""From pairs to a policy: cleaning, learners, policy files."""
