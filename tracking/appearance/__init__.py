"""How the moving part looks: its picture, mask and outline, and the layers learnt of it."""
