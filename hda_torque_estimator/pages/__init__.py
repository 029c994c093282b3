"""What the pages and figures of all reports share."""
