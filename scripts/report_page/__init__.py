"""The parts of scripts/report.py: figures, tables, data for the interactive drawings, and the page itself."""
