"""How often error bars and verdicts hold: random models in their full matrices, closed forms, the door."""
