"""The comparison: rollouts, gait metrics, statistics, claims, tables, figures."""
