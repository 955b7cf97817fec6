"""Speed, as ratios to stated limits: `python -m benchmarks [--mesh-size H]`."""
