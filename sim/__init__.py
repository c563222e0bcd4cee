"""The bench as a MuJoCo model, its camera, and synthetic video with its known truth."""
