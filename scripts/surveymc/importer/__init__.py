"""Surveys and readings in the forms that others write, for surveymc and the command surveymc import.

text, las, witsml, excel: one form each, to a Table of text cells; columns: what the headings mean, units, numbers;
checks: is it a survey that can be; listed: do its positions go with its angles; doubts: what else the table says of its rows;
output: the file written, and the account of it.
"""
