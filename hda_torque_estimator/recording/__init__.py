"""The recorder: topics onto the disk, on one clock, whole after a crash."""
