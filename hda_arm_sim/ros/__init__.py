"""What the nodes of both packages share: start and end, parameters, topics, diagnostics."""
