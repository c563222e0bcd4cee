"""Parts of the benchmark on real servos: its logs, the EMPS benchmark, its page."""
