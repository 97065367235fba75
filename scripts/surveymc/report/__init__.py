"""The report: figures, tables, data for the interactive drawings, and the page itself."""
