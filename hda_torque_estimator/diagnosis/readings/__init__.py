"""Causes that only raw readings show, before any filter."""
