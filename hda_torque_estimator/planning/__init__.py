"""Plan a motion that separates two effects, by diagnosing simulated arms along candidates."""
