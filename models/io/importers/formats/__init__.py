"""The formats that are read, one file each; what they share is one folder up."""
