"""The parts of the page, one idea each, in the order of the story."""
