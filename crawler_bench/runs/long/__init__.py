"""Long runs of Stable-Baselines3's agents: saved and evaluated on the way, gone on with after a kill."""
