"""How well a policy can crawl: the best tables and the best policy on the whole state that are known."""
