"""A whole recording: its readings and motion on one clock, and what it must fulfil."""
