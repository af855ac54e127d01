"""Tables, plots, the HTML page and the exported files.

Takes the records of ``types``, which the stages fill; knows no stage.  ``exports`` writes the files for other
programs, ``page`` the one for people.
"""
