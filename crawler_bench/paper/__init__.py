"""The paper's claims, figures and films, reproduced."""
