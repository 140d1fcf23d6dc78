"""What a body did, in numbers: rollout, record, metrics."""
