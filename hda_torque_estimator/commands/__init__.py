"""The commands of `hda`, a module each: `configure` declares arguments, `execute` does the job."""
