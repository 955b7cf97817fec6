"""How often error bars and verdicts hold: random models against an integration of their full matrices, closed forms, the door."""
