"""What is shown beside the findings: the rest and what it follows, figures, the page."""
