"""The tables and figures of the paper, computed anew beside its peers."""
