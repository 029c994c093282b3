"""One sample of an arm: read from its message, put in order, and judged by what can be."""
