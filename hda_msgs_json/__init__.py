"""What travels: topics, messages as bytes and as arrays, strict JSON, and bags."""
