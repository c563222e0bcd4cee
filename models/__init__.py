"""What an actuator is: parameters, effects, the plant equation, recordings, camera timing."""
